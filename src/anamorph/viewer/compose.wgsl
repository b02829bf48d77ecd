// A half of the image's area: an image in linear colour, or a false-colour image as it is.

@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var smooth_sampler: sampler;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) place: vec2f,
}

@vertex
fn canvas_vertex(@builtin(vertex_index) index: u32) -> Corner {
    let place = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return Corner(vec4f(2.0 * place.x - 1.0, 1.0 - 2.0 * place.y, 0.0, 1.0), place);
}

fn encode_srgb(linear: vec3f) -> vec4f {
    let inside = clamp(linear, vec3f(0.0), vec3f(1.0));
    return vec4f(select(1.055 * pow(inside, vec3f(1.0 / 2.4)) - 0.055, 12.92 * inside, inside <= vec3f(0.0031308)), 1.0);
}

fn nearest(place: vec2f) -> vec4f {
    let size = vec2f(textureDimensions(source));
    return textureLoad(source, vec2u(min(place * size, size - 1.0)), 0);
}

// An image with one pixel for each that it covers.
@fragment
fn sharp_image(corner: Corner) -> @location(0) vec4f {
    return encode_srgb(nearest(corner.place).rgb);
}

// An image of another size.
@fragment
fn blended_image(corner: Corner) -> @location(0) vec4f {
    return encode_srgb(textureSampleLevel(source, smooth_sampler, corner.place, 0.0).rgb);
}

// The colours of a false-colour image are figures, which must not be blended.
@fragment
fn false_color(corner: Corner) -> @location(0) vec4f {
    return nearest(corner.place);
}

// An image as it is, for an average: the blend weights it.
@fragment
fn copied(corner: Corner) -> @location(0) vec4f {
    return textureLoad(source, vec2u(corner.position.xy), 0);
}
