// What the passes over an image's samples share: the ray triangles, whose samples are whose, and what these see.
// needs: gpu/vertices.wgsl

const SPECULAR = 0x80000000u;

// A ray triangle. Origin, direction, transmittance and the scale that they have in common are linear in the place.
struct RayTriangle {
    direction_x: vec3f,
    // The triangle of the scene's index buffer that it is.
    face: u32,
    direction_y: vec3f,
    // The object number of that; 0 for a bare ray mesh.
    object: u32,
    direction_one: vec3f,
    scale_x: f32,
    origin_x: vec3f,
    scale_y: f32,
    origin_y: vec3f,
    scale_one: f32,
    origin_one: vec3f,
    transmittance_x: f32,
    // What origins are relative to.
    anchor: vec3f,
    transmittance_y: f32,
    // The direction of the light before the surface, seen from the eye; it may have any length.
    incident_x: vec3f,
    transmittance_one: f32,
    incident_y: vec3f,
    // The row of the lens, from 1, or 0 for a mirror; and what keeps light from going through it: TOTAL, ENDS, BY_EDGE.
    lens: u32,
    incident_one: vec3f,
    inner: u32,
    // The column and row of the sample that places are relative to.
    center_x: f32,
    center_y: f32,
    // The object number of the first specular surface on the way from the eye.
    first: u32,
    // How many specular interfaces the path has met.
    met: u32,
    // 0 where it has no rays.
    exists: u32,
}

const TOTAL = 1u;
const ENDS = 2u;
const BY_EDGE = 4u;

@group(2) @binding(0) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(1) var<storage, read> indices: array<u32>;
@group(2) @binding(2) var<storage, read> ray_triangles: array<RayTriangle>;

// A lens, from the side by which rays enter.
struct Lens {
    // The middle of the far face's border.
    middle: vec3f,
    radius: f32,
    axis: vec3f,
    // The edge's triangles in the scene's index buffer; none where it has no mesh.
    first_face: u32,
    stop_face: u32,
}

@group(2) @binding(4) var<storage, read> lenses: array<Lens>;

// The ray triangle of each sample, from 0.
@group(3) @binding(0) var owners: texture_2d<u32>;
// The scene triangle that each sample sees, from 1, and whether it is the front of a specular surface; 0 for the sky.
@group(3) @binding(1) var triangles_seen: texture_2d<u32>;
// With straight edges, the weights of its second and third corner.
@group(3) @binding(2) var weights_seen: texture_2d<f32>;
// Of rays that go on, what share of their light reaches the eye, by colour.
@group(3) @binding(3) var throughput: texture_2d<f32>;
// Of the mirror or lens that each sample is on.
@group(3) @binding(4) var depths: texture_2d<f32>;

// What owns a sample that no ray triangle owns, and whatever is greater.
const NOBODY = 0x80000000u;
