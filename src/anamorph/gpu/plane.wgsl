// The plane of a triangle: where a ray meets it, and the weights of the corners there.

// Weights of the second and third corner at a point, and the normal, not unit.
struct Plane {
    corner: vec3f,
    normal: vec3f,
    second: vec3f,
    third: vec3f,
}

fn plane_of(a: vec3f, b: vec3f, c: vec3f) -> Plane {
    let normal = cross(b - a, c - a);
    let square = max(dot(normal, normal), 1e-36);
    return Plane(a, normal, cross(c - a, normal) / square, cross(normal, b - a) / square);
}

fn meeting(plane: Plane, origin: vec3f, direction: vec3f) -> vec3f {
    let slant = dot(plane.normal, direction);
    // A footprint's ray may run along the plane.
    let limit = 1e-6 * length(plane.normal);
    let along = dot(plane.normal, plane.corner - origin) / select(slant, limit, abs(slant) < limit);
    return origin + along * direction;
}

fn weights_at(plane: Plane, point: vec3f) -> vec3f {
    let offset = point - plane.corner;
    let weights = vec2f(dot(offset, plane.second), dot(offset, plane.third));
    return vec3f(1.0 - weights.x - weights.y, weights);
}
