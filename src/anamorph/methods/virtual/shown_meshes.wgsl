// Virtual objects put into the image where mirrors are seen.
// needs: gpu/scene.wgsl

@group(2) @binding(0) var first_texels: texture_2d<u32>;
@group(2) @binding(1) var second_texels: texture_2d<u32>;
@group(2) @binding(2) var leaving_depth: texture_depth_2d;
// By object number, from 1 for mirrors that are searched.
@group(2) @binding(3) var<storage, read> bodies: array<u32>;
@group(2) @binding(4) var first_virtual: texture_2d<u32>;
@group(2) @binding(5) var second_virtual: texture_2d<u32>;

struct EndAndDepth {
    @location(0) first: vec4u,
    @location(1) second: vec4u,
    // Of the mirror or lens: what stands before it hides it.
    @builtin(frag_depth) depth: f32,
}

@vertex
fn shown_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 1.0);
}

@fragment
fn shown_end(@builtin(position) pixel: vec4f) -> EndAndDepth {
    let texel = vec2u(pixel.xy);
    let depth = textureLoad(leaving_depth, texel, 0);
    let first = textureLoad(first_texels, texel, 0);
    let second = textureLoad(second_texels, texel, 0);
    let object = second.z & 0xFFFFu;
    if object == 0u {
        discard;
    }
    let drawn = textureLoad(second_virtual, texel, 0);
    if drawn.z != 0u {
        return EndAndDepth(textureLoad(first_virtual, texel, 0), drawn, depth);
    }
    // No virtual object is there; and what is not searched is traced.
    var status = (second.z >> 16u) & 0xFFu;
    if status != STATUS_DOUBTFUL {
        status = select(STATUS_PROJECTED, STATUS_DOUBTFUL, bodies[object] == 0u);
    }
    return EndAndDepth(first, vec4u(second.xy, (second.z & 0xFF00FFFFu) | (status << 16u), second.w), depth);
}
