// What all exact surfaces share on the device: where their numbers lie, their kinds, and what a ray finds there.

// As `device_numbers` packs them, in the frame of the mesh whose surface it is.
@group(3) @binding(0) var<storage, read> surface_numbers: array<f32>;

const UNKNOWN_SURFACE = 0u;
const ROUND = 1u;
const TOROID = 2u;
const ASPHERE = 3u;
const PATCH = 4u;

// Where a ray meets an exact surface.
struct Met {
    // False where the ray passes the surface by, or the search fails.
    met: bool,
    // From where the ray meets the mesh, along the ray; it may be negative.
    step: f32,
    // Unit, to the surface's own outside.
    normal: vec3f,
}

fn vector_at(first: u32) -> vec3f {
    return vec3f(surface_numbers[first], surface_numbers[first + 1u], surface_numbers[first + 2u]);
}
