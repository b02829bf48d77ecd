// Projected points drawn into the visibility buffer as squares, the nearest by its way before all others.
// needs: gpu/scene.wgsl, gpu/vertices.wgsl, gpu/path_end.wgsl, methods/threeray/three_ray_camera.wgsl
// Source: Mei, Popescu and Sacks 2007, section 6. A square of n samples a side is n x n points, an instance for each.

override ROOTS: u32 = 3;
// Samples along a square's side.
override SIDE: u32 = 1;

// What the samples look at, row by row.
struct Owner {
    // The specular object and one, 0 where no square may be.
    item: u32,
    // Of the mirror or lens, metres.
    depth: f32,
}

@group(2) @binding(0) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(1) var<storage, read> indices: array<u32>;
@group(2) @binding(2) var<storage, read> cameras: array<ThreeRayCamera>;
@group(2) @binding(3) var<storage, read> scene_points: array<ScenePoint>;
@group(2) @binding(4) var<storage, read> pairs: array<vec2u>;
@group(2) @binding(5) var<storage, read> projected: array<Projected>;
@group(2) @binding(6) var<storage, read> owners: array<Owner>;

struct SquareFragment {
    @builtin(position) pixel: vec4f,
    @location(0) @interpolate(flat) first: vec4u,
    @location(1) @interpolate(flat) second: vec4u,
}

// Whether a sample looks at the camera's own mirror where the camera is, and not at a part of it that stands before.
fn is_own(camera: ThreeRayCamera, sample: vec2i, size: vec2i) -> bool {
    if any(sample < vec2i(0)) || any(sample >= size) {
        return false;
    }
    let owner = owners[sample.y * size.x + sample.x];
    let depth = clamp(owner.depth, camera.least_depth, camera.greatest_depth);
    return owner.item == camera.item + 1u && abs(owner.depth - depth) <= camera.longest;
}

// What share of the light arrives, by colour, along a ray that leaves a mirror or a lens.
fn arriving(camera: ThreeRayCamera, origin: vec3f, direction: vec3f, weights: vec3f) -> vec3f {
    if camera.item == 0u {
        return vec3f(1.0);
    }
    if is_mirror(camera.item) {
        let incident = normalize(origin - projection.eye.xyz);
        return mirror_reflectance(camera.item, 0.5 * length(direction - incident));
    }
    return dot(camera.transmittance, weights) * tint_of(camera.item) * tint_of(camera.left);
}

// Where a path meets a mirror's front or glass, it ends as if nothing followed.
fn status_there(triangle: u32, direction: vec3f) -> u32 {
    let a = vertices[indices[3u * triangle]];
    let one = position_of(vertices[indices[3u * triangle + 1u]]) - position_of(a);
    let other = position_of(vertices[indices[3u * triangle + 2u]]) - position_of(a);
    let front = !is_mirror(a.object) || dot(cross(one, other), direction) < 0.0;
    return select(STATUS_PROJECTED, STATUS_OUTSIDE, is_specular(a.object) && front);
}

@vertex
fn square_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) number: u32) -> SquareFragment {
    let nowhere = SquareFragment(vec4f(0.0, 0.0, -1.0, 1.0), vec4u(), vec4u());
    let seen = projected[index];
    if seen.way < 0.0 {
        return nowhere;
    }
    let pair = pairs[index / ROOTS];
    let camera = cameras[pair.x];
    let weights = weights_of(seen);
    let image = camera.image * weights;
    if image.z <= 0.0 {
        return nowhere;
    }
    let size = vec2i(projection.size.xy);
    let first = vec2i(floor(image.xy / image.z - 0.5 * f32(SIDE) + 1.0));
    let sample = first + vec2i(i32(number % SIDE), i32(number / SIDE));
    if !is_own(camera, sample, size) {
        return nowhere;
    }
    let origin = camera.origins * weights;
    let direction = normalize(camera.directions * weights);
    let triangle = scene_points[pair.y].triangle;
    let flags = camera.item | (status_there(triangle, direction) << 16u) | (camera.met << 24u);
    let share = arriving(camera, origin, direction, weights);
    let end = packed(PathEnd(origin, triangle + 1u, direction, flags, share));
    let place = (vec2f(sample) + 0.5) / projection.size.xy * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    return SquareFragment(vec4f(place, 1.0 / (1.0 + seen.way), 1.0), end.first, end.second);
}

@fragment
fn square_end(square: SquareFragment) -> PackedPathEnd {
    return PackedPathEnd(square.first, square.second);
}
