// What a lens does to a pixel's own ray: `refracted_rays` of refraction.py, in f32, at both of its exact surfaces.
// needs: optics/bend.wgsl
//
// Against float64, for eight lenses of 0.04 mm to 120 m, seen from as far as they are large: the direction is off by 1e-7
// rad at the median and 1e-6 at the 99th percentile; at most by 5e-5, next to the critical angle. Of 20,000 rays one
// ends otherwise, at the very edge.

// The kind of the far faces of the lenses that a pipeline draws; SURFACE is that of the near ones.
override FAR_SURFACE: u32 = 0u;

struct Crossing {
    // Refracted, or reflected where no light crosses.
    direction: vec3f,
    // Fresnel's.
    transmittance: f32,
    crosses: bool,
}

// `normal` is against the ray; `eta` is the index on its side over that on the other.
fn crossing(direction: vec3f, normal: vec3f, eta: f32) -> Crossing {
    let cosine = -dot(normal, direction);
    let tangential = direction + cosine * normal;
    let square = 1.0 - eta * eta * dot(tangential, tangential);
    if square < 0.0 {
        return Crossing(direction + 2.0 * cosine * normal, 1.0, false);
    }
    let other = sqrt(square);
    let reflected = vec2f(
        (eta * cosine - other) / (eta * cosine + other),
        (cosine - eta * other) / (cosine + eta * other),
    );
    return Crossing(eta * tangential - other * normal, 1.0 - 0.5 * dot(reflected, reflected), true);
}

// Where a ray enters a lens; all colours do so here.
fn lens_entry(side: u32, hit: FlatHit) -> Interface {
    var place = interface_at(SURFACE, exact_sides[side].surface, hit);
    if dot(place.normal, hit.direction) >= 0.0 {
        place.normal = hit.facing;
    }
    return place;
}

fn off_axis(side: u32, vector: vec3f) -> vec3f {
    let axis = exact_sides[side].axis;
    return vector - dot(vector, axis) * axis;
}

// Where a ray in the glass meets the cylinder around the lens.
fn edge_point(side: u32, point: vec3f, direction: vec3f) -> vec3f {
    let offset = off_axis(side, point - exact_sides[side].middle);
    let change = off_axis(side, direction);
    let square = max(dot(change, change), 1e-12);
    let half = dot(offset, change);
    let radius = exact_sides[side].radius;
    let distance = (sqrt(max(half * half - square * (dot(offset, offset) - radius * radius), 0.0)) - half) / square;
    return point + max(distance, 0.0) * direction;
}

// Light of one refractive index through the lens. A ray that leaves by the edge ends there; one that is reflected
// totally is the reflected ray in the glass.
fn through_lens(side: u32, hit: FlatHit, entry: Interface, index: f32) -> BentRay {
    let unit = exact_sides[side].unit;
    let entering = crossing(hit.direction, entry.normal, 1.0 / index);
    let inside = kept_on_side(entering.direction, hit, entry, entering.crosses);
    if !entering.crosses {
        return BentRay(unit * entry.point, inside, 1.0, RAY_TOTAL_REFLECTION);
    }
    let axis = exact_sides[side].axis;
    let middle = exact_sides[side].middle;
    let distance = dot(middle - entry.point, axis) / max(dot(inside, axis), 1e-3);
    let start = entry.point + distance * inside;
    let uv = vec2f(dot(exact_sides[side].far_u, vec4f(start, 1.0)), dot(exact_sides[side].far_v, vec4f(start, 1.0)));
    let found = meet(FAR_SURFACE, exact_sides[side].far_surface, start, inside, uv, -axis);
    let exit = start + found.step * inside;
    let by_edge = length(off_axis(side, exit - middle)) > exact_sides[side].radius;
    if !found.met || distance + found.step <= 0.0 || by_edge {
        let edge = edge_point(side, entry.point, inside);
        return BentRay(unit * edge, inside, entering.transmittance, RAY_LEFT_BY_EDGE);
    }
    let normal = faceForward(found.normal, inside, found.normal);
    let leaving = crossing(inside, normal, index);
    let way = select(RAY_TOTAL_REFLECTION, way_from(entry), leaving.crosses);
    return BentRay(unit * exit, leaving.direction, entering.transmittance * leaving.transmittance, way);
}

// Whether a ray that left by the far face did so where the mesh has triangles too: beyond, tracing passes the face by.
fn left_by_triangles(side: u32, bent: BentRay) -> bool {
    let place = bent.origin / exact_sides[side].unit - exact_sides[side].middle;
    return length(off_axis(side, place)) < exact_sides[side].sure_radius;
}
