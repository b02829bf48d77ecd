// One mipmap level from the one below it: each texel is the mean of four.
// needs: gpu/scene.wgsl

@group(2) @binding(0) var finer: texture_2d<f32>;

@vertex
fn halving_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 0.0);
}

@fragment
fn halve(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let last = vec2i(textureDimensions(finer)) - 1;
    let corner = 2 * vec2i(pixel.xy);
    let sum = textureLoad(finer, min(corner, last), 0)
        + textureLoad(finer, min(corner + vec2i(1, 0), last), 0)
        + textureLoad(finer, min(corner + vec2i(0, 1), last), 0)
        + textureLoad(finer, min(corner + vec2i(1, 1), last), 0);
    return 0.25 * sum;
}
