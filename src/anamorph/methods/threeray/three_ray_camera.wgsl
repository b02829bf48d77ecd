// A three-ray camera as the device is given it: what projecting its points and drawing their squares need.

// Columns and vectors have one for each corner.
struct ThreeRayCamera {
    // Homogeneous, in samples from the middle of the first.
    image: mat3x3f,
    origins: mat3x3f,
    directions: mat3x3f,
    // Through a lens; 1 for a mirror.
    transmittance: vec3f,
    // The t before which a ray meets nothing.
    near: f32,
    // The longest edge, metres.
    longest: f32,
    // The least and the greatest depth of a corner, metres.
    least_depth: f32,
    greatest_depth: f32,
    // The number of the surface that the rays leave, as the points have it.
    surface: u32,
    // The specular object and, of a lens, the far face; 0 for none.
    item: u32,
    left: u32,
    // How many interfaces the rays have met.
    met: u32,
    // Of t, in lengths of the directions, for one unit of the scaled t.
    pace: f32,
}

// A point of the scene, a surfel's centre: less the scene's middle, the sum of two floats.
struct ScenePoint {
    high: vec3f,
    // Of the scene's index buffer.
    triangle: u32,
    low: vec3f,
    surface: u32,
}

// Where a camera sees a point.
struct Projected {
    // Weights of the second and third corner.
    u: f32,
    v: f32,
    // From the camera's triangle to the point, metres; less than 0 where it is not seen.
    way: f32,
}

fn weights_of(seen: Projected) -> vec3f {
    return vec3f(1.0 - seen.u - seen.v, seen.u, seen.v);
}
