// What a mirror does to a pixel's own ray: `_bend` of bounces.py, in f32, in the frame of a mesh.
// needs: surfaces/meet.wgsl
//
// Against float64, for ten mirrors of 1 mm to 1 km at cosines of incidence above 0.02: the point is off by at most 2e-7
// of the body's size and 1e-7 of the eye's distance, over that cosine. Seen from as far as the body is large, the
// direction is off by 1e-7 to 3e-7 rad at the median, 3e-6 at the 99th percentile and 1e-5 at most.

// The kind of exact surface of the meshes that a pipeline draws.
override SURFACE: u32 = 0u;

// What bends the rays that meet a specular mesh, as `exact_sides` packs it. Points and lengths are in the mesh's frame.
struct ExactSide {
    // The frame: world points less this, in metres, over the unit.
    origin: vec3f,
    unit: f32,
    // Where the surface's numbers begin, and those of a lens's far face.
    surface: u32,
    far_surface: u32,
    // A mirror's, at normal incidence.
    reflectance: f32,
    // A lens's, from its axis to its edge.
    radius: f32,
    // Of the far face's border.
    middle: vec3f,
    // Up to here from the axis, a ray meets the far face's triangles; between them and the edge's circle, only the
    // exact surface.
    sure_radius: f32,
    // A lens's, from the near face to the far one; unit.
    axis: vec3f,
    // Of the glass, for red, green and blue light.
    indices: vec3f,
    // The far face's parameters at a point: linear in (x, y, z, 1).
    far_u: vec4f,
    far_v: vec4f,
}

// By the number of the mesh, which is the object's less one.
@group(3) @binding(1) var<storage, read> exact_sides: array<ExactSide>;

// What became of a ray: `RayStatus`, and one that passed the exact surface by and was bent at the mesh instead.
const RAY_OK = 0u;
const RAY_TOTAL_REFLECTION = 2u;
const RAY_LEFT_BY_EDGE = 3u;
const RAY_MISSED = 4u;

struct BentRay {
    // In metres from the side's origin.
    origin: vec3f,
    // Unit.
    direction: vec3f,
    // What share of the light goes this way, but for tints.
    transmittance: f32,
    way: u32,
}

// Where a pixel's ray meets a flat triangle of the mesh.
struct FlatHit {
    point: vec3f,
    // From the eye.
    distance: f32,
    // Unit.
    direction: vec3f,
    // The triangle's normal and the interpolated one, on the side from which the ray comes; the first is unit.
    facing: vec3f,
    normal: vec3f,
    // The interpolated parameters.
    uv: vec2f,
}

// `eye`, or another point of the ray before the mesh, and corners in the world, in metres.
fn flat_hit(
    side: u32, eye: vec3f, direction: vec3f, corners: mat3x3f, normals: mat3x3f, parameters: mat3x2f,
) -> FlatHit {
    let scale = 1.0 / exact_sides[side].unit;
    let start = scale * (eye - exact_sides[side].origin);
    let corner = scale * (corners[0] - exact_sides[side].origin);
    let edge_1 = scale * (corners[1] - corners[0]);
    let edge_2 = scale * (corners[2] - corners[0]);
    let area = cross(edge_1, edge_2);
    let slope = dot(area, direction);
    let distance = dot(area, corner - start) / slope;
    let point = start + distance * direction;
    let inside = point - corner;
    let u = dot(cross(inside, edge_2), area) / dot(area, area);
    let v = dot(cross(edge_1, inside), area) / dot(area, area);
    let weights = vec3f(1.0 - u - v, u, v);
    let turn = select(-1.0, 1.0, slope < 0.0);
    return FlatHit(point, distance, direction, turn * normalize(area), turn * (normals * weights), parameters * weights);
}

// Where a ray is bent: on the exact surface, or on the triangle; the normal there is unit and against the ray.
struct Interface {
    point: vec3f,
    normal: vec3f,
    exact: bool,
}

fn interface_at(kind: u32, surface: u32, hit: FlatHit) -> Interface {
    let found = meet(kind, surface, hit.point, hit.direction, hit.uv, hit.facing);
    // The faces may be turned against the surface's own normals, as in a concave mirror cut from a sphere.
    let normal = select(-found.normal, found.normal, dot(found.normal, hit.facing) > 0.0);
    if found.met && hit.distance + found.step > 0.0 && dot(normal, hit.direction) < 0.0 {
        return Interface(hit.point + found.step * hit.direction, normal, true);
    }
    if dot(hit.normal, hit.facing) <= 1e-6 {
        return Interface(hit.point, hit.facing, false);
    }
    return Interface(hit.point, normalize(hit.normal), false);
}

// An interpolated normal can send a ray through the flat triangle: it stays on its side.
fn kept_on_side(bent: vec3f, hit: FlatHit, place: Interface, crosses: bool) -> vec3f {
    let height = dot(bent, hit.facing);
    if place.exact || (height > 0.0) != crosses {
        return bent;
    }
    return normalize(bent - height * hit.facing);
}

// Schlick's approximation.
fn mirror_share(reflectance: f32, cosine: f32) -> f32 {
    let rest = 1.0 - clamp(cosine, 0.0, 1.0);
    return reflectance + (1.0 - reflectance) * rest * rest * rest * rest * rest;
}

fn way_from(place: Interface) -> u32 {
    return select(RAY_OK, RAY_MISSED, SURFACE != UNKNOWN_SURFACE && !place.exact);
}

fn mirrored(side: u32, hit: FlatHit) -> BentRay {
    let place = interface_at(SURFACE, exact_sides[side].surface, hit);
    let cosine = -dot(place.normal, hit.direction);
    let bent = kept_on_side(hit.direction + 2.0 * cosine * place.normal, hit, place, false);
    let share = mirror_share(exact_sides[side].reflectance, cosine);
    return BentRay(exact_sides[side].unit * place.point, bent, share, way_from(place));
}
