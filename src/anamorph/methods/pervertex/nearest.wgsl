// The pyramid over a map of surfaces: the nearest depth that each cell of 2, 4, ... texels shows.

@group(0) @binding(0) var map_surfaces: texture_2d<u32>;
@group(0) @binding(1) var finer: texture_2d<f32>;

@vertex
fn covering_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
}

// With a texel around it on all sides: what a texel shows may reach into its neighbours.
@fragment
fn nearest_surface(@builtin(position) pixel: vec4f) -> @location(0) f32 {
    let last = vec2i(textureDimensions(map_surfaces)) - 1;
    let corner = 2 * vec2i(pixel.xy) - 1;
    var nearest = 0.0;
    for (var number = 0; number < 16; number++) {
        let texel = clamp(corner + vec2i(number % 4, number / 4), vec2i(0), last);
        nearest = max(nearest, bitcast<f32>(textureLoad(map_surfaces, texel, 0).y));
    }
    return nearest;
}

@fragment
fn nearest_of_four(@builtin(position) pixel: vec4f) -> @location(0) f32 {
    let last = vec2i(textureDimensions(finer)) - 1;
    let corner = 2 * vec2i(pixel.xy);
    let right = min(corner + vec2i(1, 0), last);
    let below = min(corner + vec2i(0, 1), last);
    let across = min(corner + vec2i(1, 1), last);
    return max(
        max(textureLoad(finer, corner, 0).x, textureLoad(finer, right, 0).x),
        max(textureLoad(finer, below, 0).x, textureLoad(finer, across, 0).x),
    );
}
