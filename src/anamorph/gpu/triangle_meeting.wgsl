// Where a ray meets a triangle.

// Of a triangle's weights, so that no ray slips through between two of them.
const WEIGHT_ROUNDING = 2e-6;
const FARTHEST = 3e38;

// How far along a ray it meets the triangle with these corners, which are seen from the ray's start; or FARTHEST.
fn met_at(a: vec3f, b: vec3f, c: vec3f, direction: vec3f) -> f32 {
    // The ray passes on one side of all three edges: volumes of the edges and the ray have one sign.
    let volumes = vec3f(dot(direction, cross(c, b)), dot(direction, cross(a, c)), dot(direction, cross(b, a)));
    let whole = volumes.x + volumes.y + volumes.z;
    let weights = volumes / select(whole, 1.0, whole == 0.0);
    let inside = whole != 0.0 && all(weights >= vec3f(-WEIGHT_ROUNDING));
    let distance = dot(weights, vec3f(dot(a, direction), dot(b, direction), dot(c, direction)));
    return select(FARTHEST, distance, inside && distance > 0.0);
}
