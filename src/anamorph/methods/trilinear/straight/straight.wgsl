// Pieces with straight edges, as the thesis draws them: what lies between projected corners is interpolated.
// needs: gpu/scene.wgsl, methods/trilinear/visibility.wgsl

// A corner of a piece with straight edges: its place in pixels, the weights of the scene triangle's second and third
// corner, and t.
struct StraightCorner {
    x: f32, y: f32, second: f32, third: f32, t: f32,
    // The ray triangle, and what is written where it is seen.
    owner: u32, seen: u32,
}

// Three to a piece.
@group(2) @binding(3) var<storage, read> straight_corners: array<StraightCorner>;

struct StraightFragment {
    @builtin(position) pixel: vec4f,
    // Weights, and t.
    @location(0) place: vec3f,
    @location(1) @interpolate(flat) numbers: vec2u,
}

// An image point in pixels in clip space, at a depth of one half.
fn image_clip(place: vec2f) -> vec4f {
    let size = projection.size.xy;
    return vec4f(2.0 * place.x / size.x - 1.0, 1.0 - 2.0 * place.y / size.y, 0.5, 1.0);
}

@vertex
fn straight_vertex(@builtin(vertex_index) index: u32) -> StraightFragment {
    let corner = straight_corners[index];
    let clip = image_clip(vec2f(corner.x, corner.y));
    return StraightFragment(clip, vec3f(corner.second, corner.third, corner.t), vec2u(corner.owner, corner.seen));
}

struct StraightVisible {
    @location(0) seen: u32,
    @location(1) weights: vec2f,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn straight_visible(fragment: StraightFragment) -> StraightVisible {
    let own = textureLoad(owners, vec2u(fragment.pixel.xy), 0).x == fragment.numbers.x;
    // Software interpolates over a sliver what is no number.
    let defined = all(abs(fragment.place.xy) <= vec2f(2.0)) && fragment.place.z >= 0.0;
    if !own || !defined {
        discard;
    }
    return StraightVisible(fragment.numbers.y, fragment.place.xy, 1.0 / (1.0 + fragment.place.z));
}
