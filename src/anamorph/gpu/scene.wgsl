// Drawing the scene's meshes and its sky through one projection: the eye's, or a map's.
// needs: gpu/shading.wgsl

struct Projection {
    clip: mat4x4f,
    unclip: mat4x4f,
    // The image point (x, y), each in -1 to 1, looks along base + x right + y up; w: the angle of a pixel.
    base: vec4f,
    right: vec4f,
    up: vec4f,
    eye: vec4f,
    // xy: pixels of the image, zw: its first pixel, where it is a part of a larger one.
    size: vec4f,
}

@group(1) @binding(0) var<uniform> projection: Projection;

struct VertexIn {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) texcoord: vec2f,
    @location(3) color: vec4f,
    @location(4) object: u32,
}

struct SceneFragment {
    @builtin(position) @invariant pixel: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) texcoord: vec2f,
    @location(3) color: vec3f,
    @location(4) @interpolate(flat) object: u32,
    // The object's paint.
    @location(5) @interpolate(flat) paint_color: vec3f,
    @location(6) @interpolate(flat) texture_layer: u32,
}

// What a pixel sees: the world point and the object, and how it got its value.
struct Seen {
    // xyz: world point (unit direction where w is 0), w: object number.
    @location(0) point: vec4f,
    // Specular object number in the low 16 bits, status above.
    @location(1) flags: u32,
    // The angle between the pixel's own ray and the direction to the point, radians.
    @location(2) deviation: f32,
}

// The angle between two directions, neither of them unit.
fn angle_between(a: vec3f, b: vec3f) -> f32 {
    return atan2(length(cross(a, b)), dot(a, b));
}

const STATUS_DIRECT = 0u;
const STATUS_WARPED = 1u;
const STATUS_PROVED = 2u;
const STATUS_SKY = 4u;
const STATUS_TOTAL_REFLECTION = 5u;
const STATUS_OUTSIDE = 6u;
const STATUS_PROJECTED = 7u;
const STATUS_DOUBTFUL = 8u;

fn seen_flags(specular: u32, status: u32) -> u32 {
    return specular | (status << 16u);
}

// The direction in which a pixel looks, not unit.
fn viewing_direction(pixel: vec2f) -> vec3f {
    let place = (pixel - projection.size.zw) / projection.size.xy * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    return projection.base.xyz + place.x * projection.right.xyz + place.y * projection.up.xyz;
}

fn surface_point(fragment: SceneFragment) -> SurfacePoint {
    var point: SurfacePoint;
    point.position = fragment.position;
    point.normal = normalize(fragment.normal);
    point.texcoord = fragment.texcoord;
    point.texcoord_dx = dpdx(fragment.texcoord);
    point.texcoord_dy = dpdy(fragment.texcoord);
    point.color = fragment.color;
    point.object = fragment.object;
    return point;
}

@vertex
fn scene_vertex(vertex: VertexIn) -> SceneFragment {
    var fragment: SceneFragment;
    fragment.pixel = projection.clip * vec4f(vertex.position, 1.0);
    fragment.position = vertex.position;
    fragment.normal = vertex.normal;
    fragment.texcoord = vertex.texcoord;
    fragment.color = vertex.color.rgb;
    fragment.object = vertex.object;
    let paint = paint_of(vertex.object);
    fragment.paint_color = paint.color;
    fragment.texture_layer = paint.texture_layer;
    return fragment;
}

@vertex
fn depth_vertex(@location(0) position: vec3f) -> @builtin(position) @invariant vec4f {
    return projection.clip * vec4f(position, 1.0);
}

fn sky(pixel: vec4f) -> vec4f {
    return vec4f(sky_color(viewing_direction(pixel.xy), projection.base.w), 1.0);
}

// Added to what a map knows of a fragment: it is a specular front, where the path goes on.
const FRONT = vec4f(0.0, 0.0, 0.0, 0.5);

fn is_front(point: vec4f) -> bool {
    return fract(point.w) > 0.25;
}

// For a map's reader: depth is linear in the image on each triangle, so that depth, its slopes and the object
// number give back the seen point anywhere in the texel.
fn depth_and_slopes(pixel: vec4f, object: u32) -> vec4f {
    return vec4f(pixel.z, dpdx(pixel.z), dpdy(pixel.z), f32(object));
}

// Diffuse meshes, and the backs of mirrors.
@fragment
fn scene_color(fragment: SceneFragment) -> @location(0) vec4f {
    let paint = Paint(fragment.paint_color, fragment.texture_layer);
    return vec4f(shade_painted(surface_point(fragment), paint, viewing_direction(fragment.pixel.xy)), 1.0);
}

@fragment
fn stand_in_color(fragment: SceneFragment) -> @location(0) vec4f {
    let direction = normalize(viewing_direction(fragment.pixel.xy));
    return vec4f(specular_stand_in(fragment.object, normalize(fragment.normal), direction, projection.base.w), 1.0);
}

@fragment
fn scene_seen(fragment: SceneFragment) -> Seen {
    return Seen(vec4f(fragment.position, f32(fragment.object)), seen_flags(0u, STATUS_DIRECT), 0.0);
}

@fragment
fn stand_in_seen(fragment: SceneFragment) -> Seen {
    return Seen(vec4f(fragment.position, f32(fragment.object)), seen_flags(0u, STATUS_DIRECT), 0.0);
}

@fragment
fn scene_depth(fragment: SceneFragment) -> @location(0) vec4f {
    return depth_and_slopes(fragment.pixel, fragment.object);
}

@fragment
fn stand_in_depth(fragment: SceneFragment) -> @location(0) vec4f {
    return depth_and_slopes(fragment.pixel, fragment.object) + FRONT;
}

@fragment
fn stand_in_end(fragment: SceneFragment) -> @location(0) vec4f {
    return vec4f(fragment.position, f32(fragment.object)) + FRONT;
}

// The world point and the object.
@fragment
fn scene_end(fragment: SceneFragment) -> @location(0) vec4f {
    return vec4f(fragment.position, f32(fragment.object));
}

// A corner of a triangle that covers the image.
fn covering(index: u32, depth: f32) -> vec4f {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(corner * 2.0 - 1.0, depth, 1.0);
}

@vertex
fn sky_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 0.0);
}

@fragment
fn far_sky_color(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    return sky(pixel);
}

@fragment
fn far_sky_seen(@builtin(position) pixel: vec4f) -> Seen {
    return Seen(vec4f(normalize(viewing_direction(pixel.xy)), 0.0), seen_flags(0u, STATUS_SKY), 0.0);
}

@fragment
fn far_sky_depth(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    return vec4f(0.0);
}

@fragment
fn far_sky_end(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    return vec4f(normalize(viewing_direction(pixel.xy)), 0.0);
}
