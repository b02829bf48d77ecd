// What has been coloured by itself, where it belongs in the image.
// needs: methods/trilinear/visibility.wgsl

@group(3) @binding(0) var colors: texture_2d<f32>;

@fragment
fn composed_color(fragment: OwnerFragment) -> @location(0) vec4f {
    let texel = vec2i(fragment.pixel.xy);
    var color = textureLoad(colors, texel, 0);
    if color.a == 0.0 {
        // A sample on the border of a surface whose pixel's middle is not on it: a neighbour's colour.
        var sum = vec4f(0.0);
        for (var step = 0; step < 4; step++) {
            let beside = texel + select(vec2i(0, 2 * (step & 1) - 1), vec2i(2 * (step & 1) - 1, 0), step < 2);
            sum += textureLoad(colors, clamp(beside, vec2i(0), vec2i(textureDimensions(colors)) - 1), 0);
        }
        color = sum / max(sum.a, 1.0);
    }
    return color;
}

// Along the image's rim, samples that a ray mesh has no rays for because it was shifted: their pixel's own color, which
// the image's frame would darken otherwise.
@fragment
fn composed_rim(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let texel = vec2i(pixel.xy);
    let color = textureLoad(colors, texel, 0);
    let within = all(texel > vec2i(0)) && all(texel < vec2i(textureDimensions(colors)) - 1);
    if within || color.a == 0.0 {
        discard;
    }
    return color;
}
