// The rays that leave mirrors and lenses, one for each sample: what they meet is found later.
// needs: gpu/own_ray.wgsl, gpu/path_end.wgsl

// How many specular interfaces a path may meet.
override MOST_BOUNCES: u32 = 8u;

@group(2) @binding(0) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(1) var<storage, read> indices: array<u32>;

@vertex
fn body_vertex(@builtin(vertex_index) index: u32) -> BodyFragment {
    let first = index / 3u * 3u;
    let numbers = vec3u(indices[first], indices[first + 1u], indices[first + 2u]);
    return body_fragment(vertices[numbers.x], vertices[numbers.y], vertices[numbers.z], numbers, index % 3u, index / 3u);
}

// A path that is doubtful where the traced ray may leave otherwise, or not at all; else it would see the sky.
fn left(fragment: BodyFragment, ray: LeavingRay, bounces: u32) -> PackedPathEnd {
    let status = select(STATUS_DOUBTFUL, STATUS_SKY, ray.certain && bounces <= MOST_BOUNCES);
    let flags = fragment.numbers.y | (status << 16u) | (bounces << 24u);
    return packed(PathEnd(ray.origin, 0u, ray.direction, flags, ray.throughput));
}

@fragment
fn reflector_left(fragment: BodyFragment) -> PackedPathEnd {
    return left(fragment, reflected_ray(fragment), 1u);
}

@fragment
fn refractor_left(fragment: BodyFragment) -> PackedPathEnd {
    return left(fragment, refracted_ray(fragment), 2u);
}
