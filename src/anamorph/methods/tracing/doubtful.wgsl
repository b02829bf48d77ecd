// Pixels whose path is doubtful: their list, and the traced paths that replace them.

const STATUS_DOUBTFUL = 8u;

// Lines of the spectrum that have textures of their own.
override LINES: i32 = 1;

// The second texels of green, red and blue light; only green ones where there is one line.
@group(0) @binding(0) var green: texture_2d<u32>;
@group(0) @binding(1) var red: texture_2d<u32>;
@group(0) @binding(2) var blue: texture_2d<u32>;
// How many there are; then their numbers, row by row, from which they come in any order.
@group(0) @binding(3) var<storage, read_write> count: atomic<u32>;
@group(0) @binding(4) var<storage, read_write> numbers: array<u32>;
// Where something may have been found: x0, y0, x1, y1, in samples, the ends left out.
@group(0) @binding(5) var<uniform> rectangle: vec4u;

fn is_doubtful(texel: vec4u) -> bool {
    return ((texel.z >> 16u) & 0xFFu) == STATUS_DOUBTFUL;
}

@compute @workgroup_size(64)
fn list_doubtful(@builtin(global_invocation_id) number: vec3u) {
    let place = rectangle.xy + number.xy;
    if any(place >= rectangle.zw) {
        return;
    }
    var doubtful = is_doubtful(textureLoad(green, place, 0));
    if LINES == 3 {
        doubtful = doubtful || is_doubtful(textureLoad(red, place, 0)) || is_doubtful(textureLoad(blue, place, 0));
    }
    if doubtful {
        numbers[atomicAdd(&count, 1u)] = place.y * textureDimensions(green).x + place.x;
    }
}
