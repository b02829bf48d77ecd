// What each sample's ray meets, among the triangles that its tile may see.
// needs: gpu/scene.wgsl, gpu/path_end.wgsl, gpu/triangle_meeting.wgsl

// Samples along each side of a tile.
override SIDE: u32 = 8u;

// Instead of a count: rays are traced here.
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
@group(2) @binding(2) var<uniform> extent: vec4u;
@group(2) @binding(3) var<storage, read> triangles: array<SceneTriangle>;
// By object number.
@group(2) @binding(4) var<storage, read> surfaces: array<u32>;
// By tile, where its triangles begin in `seen`, and how many there are.
@group(2) @binding(5) var<storage, read> lists: array<vec2u>;
@group(2) @binding(6) var<storage, read> seen: array<u32>;

@vertex
fn met_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 0.0);
}

// Whether a ray that meets a triangle of the surface that it left has only just started.
fn is_own(triangle: SceneTriangle, surface: u32, direction: vec3f) -> bool {
    return triangle.surface == surface && dot(cross(triangle.b - triangle.a, triangle.c - triangle.a), direction) > 0.0;
}

@fragment
fn met_end(@builtin(position) pixel: vec4f) -> PackedPathEnd {
    let texel = vec2u(pixel.xy);
    let second = textureLoad(second_texels, texel, 0);
    let first = textureLoad(first_texels, texel, 0);
    var end = unpacked(first, second);
    if is_empty(end) {
        discard;
    }
    if status_of(end) == STATUS_DOUBTFUL {
        return PackedPathEnd(first, second);
    }
    let place = (texel - extent.xy) / SIDE;
    let list = lists[place.y * extent.z + place.x];
    let surface = surfaces[end.flags & 0xFFFFu];
    let traced = list.y == TRACED;
    var nearest = FARTHEST;
    var met = 0u;
    for (var number = 0u; number < select(list.y, 0u, traced); number++) {
        let face = seen[list.x + number];
        let triangle = triangles[face];
        let distance = met_at(triangle.a - end.origin, triangle.b - end.origin, triangle.c - end.origin, end.direction);
        if distance < nearest && !is_own(triangle, surface, end.direction) {
            nearest = distance;
            met = face + 1u;
        }
    }
    var status = select(STATUS_PROVED, STATUS_SKY, met == 0u);
    if traced || (met > 0u && triangles[met - 1u].specular == 1u) {
        status = STATUS_DOUBTFUL;
    }
    end.triangle = met;
    end.flags = (end.flags & 0xFF00FFFFu) | (status << 16u);
    return PackedPathEnd(vec4u(first.xyz, met), vec4u(second.xy, end.flags, second.w));
}
