// Pixels whose path is doubtful: their list, and the traced paths that replace them.

const STATUS_DOUBTFUL = 8u;

// The second texels of green, red and blue light.
@group(0) @binding(0) var green: texture_2d<u32>;
@group(0) @binding(1) var red: texture_2d<u32>;
@group(0) @binding(2) var blue: texture_2d<u32>;
// How many there are; then their numbers, row by row, from which they come in any order.
@group(0) @binding(3) var<storage, read_write> count: atomic<u32>;
@group(0) @binding(4) var<storage, read_write> numbers: array<u32>;

fn is_doubtful(texel: vec4u) -> bool {
    return ((texel.z >> 16u) & 0xFFu) == STATUS_DOUBTFUL;
}

@compute @workgroup_size(64)
fn list_doubtful(@builtin(global_invocation_id) place: vec3u) {
    let size = textureDimensions(green);
    if any(place.xy >= size) {
        return;
    }
    let texels = vec3<bool>(
        is_doubtful(textureLoad(green, place.xy, 0)),
        is_doubtful(textureLoad(red, place.xy, 0)),
        is_doubtful(textureLoad(blue, place.xy, 0)),
    );
    if any(texels) {
        numbers[atomicAdd(&count, 1u)] = place.y * size.x + place.x;
    }
}
