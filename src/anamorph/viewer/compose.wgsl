// The canvas from its two halves: each a picture in linear colour, or a layer that is measured, with a line between.

struct Placement {
    // Where the divider is, as a share of the width; 1 without a split.
    divider: f32,
    // 1 where the half shows its layer and not its picture.
    first_layer: u32,
    second_layer: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> placement: Placement;
@group(0) @binding(1) var first_picture: texture_2d<f32>;
@group(0) @binding(2) var first_layer: texture_2d<f32>;
@group(0) @binding(3) var second_picture: texture_2d<f32>;
@group(0) @binding(4) var second_layer: texture_2d<f32>;
@group(0) @binding(5) var smooth_sampler: sampler;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) place: vec2f,
}

@vertex
fn canvas_vertex(@builtin(vertex_index) index: u32) -> Corner {
    let place = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return Corner(vec4f(2.0 * place.x - 1.0, 1.0 - 2.0 * place.y, 0.0, 1.0), place);
}

fn encode_srgb(linear: vec3f) -> vec3f {
    let inside = clamp(linear, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(inside, vec3f(1.0 / 2.4)) - 0.055, 12.92 * inside, inside <= vec3f(0.0031308));
}

// The nearest pixel of a layer: its colours are figures, which must not be blended.
fn layer_at(layer: texture_2d<f32>, place: vec2f) -> vec3f {
    let size = vec2f(textureDimensions(layer));
    return textureLoad(layer, vec2u(min(place * size, size - 1.0)), 0).rgb;
}

@fragment
fn canvas_color(corner: Corner) -> @location(0) vec4f {
    if corner.place.x < placement.divider {
        if placement.first_layer == 1u {
            return vec4f(layer_at(first_layer, corner.place), 1.0);
        }
        return vec4f(encode_srgb(textureSampleLevel(first_picture, smooth_sampler, corner.place, 0.0).rgb), 1.0);
    }
    if placement.second_layer == 1u {
        return vec4f(layer_at(second_layer, corner.place), 1.0);
    }
    return vec4f(encode_srgb(textureSampleLevel(second_picture, smooth_sampler, corner.place, 0.0).rgb), 1.0);
}

// A picture as it is, for an average: the blend weights it.
@fragment
fn copied(corner: Corner) -> @location(0) vec4f {
    return textureLoad(first_picture, vec2u(corner.position.xy), 0);
}
