// Mirrors and lenses drawn into the visibility buffer: each pixel's own ray, bent at the exact surfaces, and what the
// maps of surfaces show on it.
// needs: methods/pervertex/search.wgsl, gpu/path_end.wgsl, gpu/own_ray.wgsl

// 1 where what is doubtful will be traced, so that no guess is wanted.
override TRACED: i32 = 0;

// Flags of a triangle: its rays may meet their own body, which its maps leave out; and no map shows what they meet.
const MEETS_ITSELF = 2u;
const WITHOUT_MAP = 4u;

@vertex
fn body_vertex(@builtin(vertex_index) index: u32) -> BodyFragment {
    let first = 3u * looking[index / 3u].face;
    let numbers = vec3u(indices[first], indices[first + 1u], indices[first + 2u]);
    return body_fragment(vertices[numbers.x], vertices[numbers.y], vertices[numbers.z], numbers, index % 3u, index / 3u);
}

// The end of the path of a ray that leaves a body after so many bounces. Only where it certainly does so as the traced
// ray does can what it meets be proved.
fn end_of(fragment: BodyFragment, leaving: LeavingRay, bounces: u32) -> PackedPathEnd {
    let triangle = looking[fragment.numbers.x];
    let ray = Ray(leaving.origin, leaving.direction);
    let certain = leaving.certain && triangle.flags == 0u && triangle.reach >= 0.0;
    var found = Found(Hit(0u, FARTHEST), false);
    if certain || (TRACED == 0 && (triangle.flags & WITHOUT_MAP) == 0u) {
        found = find(ray, triangle);
    }
    let proved = found.proved && certain && (found.hit.triangle & SPECULAR) == 0u;
    let status = select(STATUS_DOUBTFUL, select(STATUS_PROVED, STATUS_SKY, found.hit.triangle == 0u), proved);
    let flags = fragment.numbers.y | (status << 16u) | (bounces << 24u);
    return packed(PathEnd(ray.origin, found.hit.triangle & ~SPECULAR, ray.direction, flags, leaving.throughput));
}

@fragment
fn reflector_found(fragment: BodyFragment) -> PackedPathEnd {
    return end_of(fragment, reflected_ray(fragment), 1u);
}

@fragment
fn refractor_found(fragment: BodyFragment) -> PackedPathEnd {
    return end_of(fragment, refracted_ray(fragment), 2u);
}
