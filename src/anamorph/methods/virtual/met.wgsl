// What each sample's ray meets, among the triangles that its tile may see.
// needs: gpu/scene.wgsl, gpu/path_end.wgsl, gpu/triangle_meeting.wgsl

// Samples along each side of a tile.
override SIDE: u32 = 8u;

// Instead of a count, or of a triangle: rays are traced here.
const TRACED = 0xFFFFFFFFu;

struct SceneTriangle {
    a: vec3f,
    // 1 for a mirror or glass, from which the path goes on.
    specular: u32,
    b: vec3f,
    // A number that all triangles of one surface have.
    surface: u32,
    c: vec3f,
    padding: u32,
}

@group(2) @binding(0) var first_texels: texture_2d<u32>;
@group(2) @binding(1) var second_texels: texture_2d<u32>;
@group(2) @binding(2) var leaving_depth: texture_depth_2d;
@group(2) @binding(3) var<uniform> extent: vec4u;
@group(2) @binding(4) var<storage, read> triangles: array<SceneTriangle>;
// By object number.
@group(2) @binding(5) var<storage, read> surfaces: array<u32>;
// By tile, where its triangles begin in `seen`, and how many there are.
@group(2) @binding(6) var<storage, read> lists: array<vec2u>;
@group(2) @binding(7) var<storage, read> seen: array<u32>;
// What was met before: a triangle, from 1, and the bits of its distance.
@group(2) @binding(8) var kept: texture_2d<u32>;

@vertex
fn met_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 1.0);
}

// Whether a ray that meets a triangle of the surface that it left has only just started.
fn is_own(triangle: SceneTriangle, surface: u32, direction: vec3f) -> bool {
    return triangle.surface == surface && dot(cross(triangle.b - triangle.a, triangle.c - triangle.a), direction) > 0.0;
}

struct Met {
    // From 1, 0 for the sky, or TRACED.
    triangle: u32,
    distance: f32,
}

// The nearer of what was met before and what a ray meets of its tile's triangles.
fn nearest_met(end: PathEnd, texel: vec2u, before: Met) -> Met {
    let place = (texel - extent.xy) / SIDE;
    let list = lists[place.y * extent.z + place.x];
    if list.y == TRACED || before.triangle == TRACED {
        return Met(TRACED, 0.0);
    }
    let surface = surfaces[end.flags & 0xFFFFu];
    var nearest = before;
    for (var number = 0u; number < list.y; number++) {
        let face = seen[list.x + number];
        let triangle = triangles[face];
        let distance = met_at(triangle.a - end.origin, triangle.b - end.origin, triangle.c - end.origin, end.direction);
        if distance < nearest.distance && !is_own(triangle, surface, end.direction) {
            nearest = Met(face + 1u, distance);
        }
    }
    return nearest;
}

@fragment
fn met_first(@builtin(position) pixel: vec4f) -> @location(0) vec2u {
    let texel = vec2u(pixel.xy);
    let end = unpacked(textureLoad(first_texels, texel, 0), textureLoad(second_texels, texel, 0));
    if is_empty(end) || status_of(end) == STATUS_DOUBTFUL {
        discard;
    }
    let met = nearest_met(end, texel, Met(0u, FARTHEST));
    return vec2u(met.triangle, bitcast<u32>(met.distance));
}

struct EndAndDepth {
    @location(0) first: vec4u,
    @location(1) second: vec4u,
    // Of the mirror or lens: what stands before it hides it.
    @builtin(frag_depth) depth: f32,
}

@fragment
fn met_end(@builtin(position) pixel: vec4f) -> EndAndDepth {
    let texel = vec2u(pixel.xy);
    let depth = textureLoad(leaving_depth, texel, 0);
    let first = textureLoad(first_texels, texel, 0);
    let second = textureLoad(second_texels, texel, 0);
    let end = unpacked(first, second);
    if is_empty(end) {
        discard;
    }
    if status_of(end) == STATUS_DOUBTFUL {
        return EndAndDepth(first, second, depth);
    }
    let before = textureLoad(kept, texel, 0).xy;
    let met = nearest_met(end, texel, Met(before.x, select(bitcast<f32>(before.y), FARTHEST, before.x == 0u)));
    var status = select(STATUS_PROVED, STATUS_SKY, met.triangle == 0u);
    var triangle = met.triangle;
    if triangle == TRACED {
        triangle = 0u;
        status = STATUS_DOUBTFUL;
    } else if triangle > 0u && triangles[triangle - 1u].specular == 1u {
        status = STATUS_DOUBTFUL;
    }
    let flags = (end.flags & 0xFF00FFFFu) | (status << 16u);
    return EndAndDepth(vec4u(first.xyz, triangle), vec4u(second.xy, flags, second.w), depth);
}
