// Samples of the visibility buffer are emptied where something stands before the mirror or lens that they look at.
// needs: gpu/scene.wgsl

// Of the mirror or lens, row by row.
@group(2) @binding(0) var<storage, read> depths: array<f32>;

struct EmptyEnd {
    @builtin(frag_depth) depth: f32,
    @location(0) first: vec4u,
    @location(1) second: vec4u,
}

@vertex
fn hidden_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 1.0);
}

@fragment
fn hidden_end(@builtin(position) pixel: vec4f) -> EmptyEnd {
    let place = vec2u(pixel.xy);
    return EmptyEnd(depths[place.y * u32(projection.size.x) + place.x], vec4u(0u), vec4u(0u));
}
