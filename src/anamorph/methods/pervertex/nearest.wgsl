// The pyramid over a map of surfaces: the nearest depth that each cell of 2, 4, ... texels shows.

@group(0) @binding(0) var map_surfaces: texture_2d<u32>;
@group(0) @binding(1) var finer: texture_2d<f32>;
@group(0) @binding(2) var map_silhouettes: texture_depth_2d;

@vertex
fn covering_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
}

// Anywhere in its texels: what they show may slope, and silhouettes may cross them.
@fragment
fn nearest_surface(@builtin(position) pixel: vec4f) -> @location(0) f32 {
    let last = vec2i(textureDimensions(map_surfaces)) - 1;
    let corner = 2 * vec2i(pixel.xy);
    var nearest = 0.0;
    for (var number = 0; number < 4; number++) {
        let texel = min(corner + vec2i(number % 2, number / 2), last);
        let plane = bitcast<vec3f>(textureLoad(map_surfaces, texel, 0).yzw);
        nearest = max(nearest, plane.x + 0.5 * (abs(plane.y) + abs(plane.z)));
    }
    for (var number = 0; number < 9; number++) {
        let cell = clamp(corner - 1 + vec2i(number % 3, number / 3), vec2i(0), last);
        nearest = max(nearest, textureLoad(map_silhouettes, cell, 0));
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
