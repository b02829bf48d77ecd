// Which scene triangle each sample's ray meets: first whose ray it is, then what that ray triangle sees.
// needs: gpu/scene.wgsl, gpu/vertices.wgsl
//
// In a ray triangle everything is a polynomial of the place in the image, relative to the ray triangle's center. The
// weights of a scene triangle's corners, all times one number, are quadratics; N, which is positive where the triangle is
// seen from the side that the pair stands for, and N times the distance are linear. No edge is drawn straight, and
// nothing is interpolated: each sample asks for itself.

struct Quadratic {
    xx: f32, xy: f32, yy: f32, x: f32, y: f32, one: f32,
}

struct Linear {
    x: f32, y: f32, one: f32,
}

// A ray triangle and a scene triangle that it may see.
struct Pair {
    first: Quadratic,
    second: Quadratic,
    third: Quadratic,
    across: Linear,
    // N times t, from the near distance on.
    ahead: Linear,
    center_x: f32, center_y: f32,
    // From 1.
    ray_triangle: u32,
    // What is written for it: the scene triangle, from 1, and `SPECULAR` where it is the front of a specular surface.
    seen: u32,
}

const SPECULAR = 0x80000000u;

// A triangle of the image, in pixels, and the row of its pair.
struct Piece {
    x0: f32, y0: f32, x1: f32, y1: f32, x2: f32, y2: f32,
    pair: u32,
}

// A ray triangle. Origin, direction, transmittance and the scale that they have in common are linear in the place.
struct RayTriangle {
    // Its image's homogeneous corners in pixels, where it is not drawn as the surface that it is on.
    corner_0: vec3f,
    center_x: f32,
    corner_1: vec3f,
    center_y: f32,
    corner_2: vec3f,
    // From 1, by which its pixels know it; 0 where it has no rays.
    number: u32,
    direction_x: vec3f,
    // The triangle of the scene's index buffer that it is.
    face: u32,
    direction_y: vec3f,
    // The object number of that; 0 for a bare ray mesh.
    object: u32,
    direction_one: vec3f,
    scale_x: f32,
    origin_x: vec3f,
    scale_y: f32,
    origin_y: vec3f,
    scale_one: f32,
    origin_one: vec3f,
    transmittance_x: f32,
    // What origins are relative to.
    anchor: vec3f,
    transmittance_y: f32,
    // The direction of the light before the surface, seen from the eye; it may have any length.
    incident_x: vec3f,
    transmittance_one: f32,
    incident_y: vec3f,
    // The row of the lens, from 1, or 0 for a mirror; and what keeps light from going through it: TOTAL, ENDS, BY_EDGE.
    lens: u32,
    incident_one: vec3f,
    inner: u32,
    // The ray triangle whose rays it sends on, and what that has to see for it; 0 for none.
    before: u32,
    through: u32,
    // The object number of the first specular surface on the way from the eye.
    first: u32,
    // How many specular interfaces the path has met.
    met: u32,
}

const TOTAL = 1u;
const ENDS = 2u;
const BY_EDGE = 4u;

@group(2) @binding(0) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(1) var<storage, read> indices: array<u32>;
@group(2) @binding(2) var<storage, read> ray_triangles: array<RayTriangle>;
@group(2) @binding(3) var<storage, read> pairs: array<Pair>;
@group(2) @binding(4) var<storage, read> pieces: array<Piece>;
// A lens, from the side by which rays enter.
struct Lens {
    // The middle of the far face's border.
    middle: vec3f,
    radius: f32,
    axis: vec3f,
    // The edge's triangles in the scene's index buffer; none where it has no mesh.
    first_face: u32,
    stop_face: u32,
}

@group(2) @binding(5) var<storage, read> lenses: array<Lens>;

// The ray triangle of each sample, by its number; 0 for none. While these are found for rays that go on, those before.
@group(3) @binding(0) var owners: texture_2d<u32>;
// The scene triangle that each sample sees, from 1, and whether it is the front of a specular surface; 0 for the sky.
@group(3) @binding(1) var triangles_seen: texture_2d<u32>;
// With straight edges, the weights of its second and third corner.
@group(3) @binding(2) var weights_seen: texture_2d<f32>;
// Of rays that go on, what share of their light reaches the eye, by colour.
@group(3) @binding(3) var throughput: texture_2d<f32>;

// Pixels of the image from one sample to the next.
override PIXEL: f32 = 1.0;

fn quadratic_at(terms: Quadratic, place: vec2f) -> f32 {
    return (terms.xx * place.x + terms.xy * place.y + terms.x) * place.x + (terms.yy * place.y + terms.y) * place.y + terms.one;
}

fn linear_at(terms: Linear, place: vec2f) -> f32 {
    return terms.x * place.x + terms.y * place.y + terms.one;
}

// An image point in pixels, homogeneous, in clip space at a depth of one half.
fn image_clip(place: vec3f) -> vec4f {
    let size = projection.size.xy;
    return vec4f(2.0 * place.x / size.x - place.z, place.z - 2.0 * place.y / size.y, 0.5 * place.z, place.z);
}

struct OwnerFragment {
    @builtin(position) @invariant pixel: vec4f,
    @location(0) @interpolate(flat) number: u32,
    @location(1) @interpolate(flat) before: u32,
    @location(2) @interpolate(flat) through: u32,
}

// A corner of a specular surface, as the scene's own drawing shows it.
fn surface_clip(triangle: RayTriangle, corner: u32) -> vec4f {
    return projection.clip * vec4f(position_of(vertices[indices[3u * triangle.face + corner]]), 1.0);
}

// A corner of a ray triangle's own image.
fn bare_clip(triangle: RayTriangle, corner: u32) -> vec4f {
    var corners = array<vec3f, 3>(triangle.corner_0, triangle.corner_1, triangle.corner_2);
    return image_clip(corners[corner]);
}

@vertex
fn surface_owner_vertex(@builtin(vertex_index) index: u32) -> OwnerFragment {
    let triangle = ray_triangles[index / 3u];
    return OwnerFragment(surface_clip(triangle, index % 3u), triangle.number, 0u, 0u);
}

@vertex
fn bare_owner_vertex(@builtin(vertex_index) index: u32) -> OwnerFragment {
    let triangle = ray_triangles[index / 3u];
    return OwnerFragment(bare_clip(triangle, index % 3u), triangle.number, triangle.before, triangle.through);
}

@fragment
fn owner(fragment: OwnerFragment) -> @location(0) u32 {
    return fragment.number;
}

// Of rays that go on: where those before them see what sends these on.
@fragment
fn following_owner(fragment: OwnerFragment) -> @location(0) u32 {
    let texel = vec2u(fragment.pixel.xy);
    let before = textureLoad(owners, texel, 0).x;
    let through = textureLoad(triangles_seen, texel, 0).x;
    if before != fragment.before || through != fragment.through {
        discard;
    }
    return fragment.number;
}

struct PieceFragment {
    @builtin(position) pixel: vec4f,
    @location(0) @interpolate(flat) terms_0: vec4f,
    @location(1) @interpolate(flat) terms_1: vec4f,
    @location(2) @interpolate(flat) terms_2: vec4f,
    @location(3) @interpolate(flat) terms_3: vec4f,
    @location(4) @interpolate(flat) terms_4: vec4f,
    @location(5) @interpolate(flat) terms_5: vec4f,
    @location(6) @interpolate(flat) center: vec2f,
    // The ray triangle, and what is written.
    @location(7) @interpolate(flat) numbers: vec2u,
}

@vertex
fn piece_vertex(@builtin(vertex_index) index: u32) -> PieceFragment {
    let piece = pieces[index / 3u];
    // What is flat comes from a triangle's first corner: the others need not read it.
    var pair: Pair;
    if index % 3u == 0u {
        pair = pairs[piece.pair];
    }
    var corners = array<vec2f, 3>(vec2f(piece.x0, piece.y0), vec2f(piece.x1, piece.y1), vec2f(piece.x2, piece.y2));
    return PieceFragment(
        image_clip(vec3f(corners[index % 3u], 1.0)),
        vec4f(pair.first.xx, pair.first.xy, pair.first.yy, pair.first.x),
        vec4f(pair.first.y, pair.first.one, pair.second.xx, pair.second.xy),
        vec4f(pair.second.yy, pair.second.x, pair.second.y, pair.second.one),
        vec4f(pair.third.xx, pair.third.xy, pair.third.yy, pair.third.x),
        vec4f(pair.third.y, pair.third.one, pair.across.x, pair.across.y),
        vec4f(pair.across.one, pair.ahead.x, pair.ahead.y, pair.ahead.one),
        vec2f(pair.center_x, pair.center_y),
        vec2u(pair.ray_triangle, pair.seen),
    );
}

struct Visible {
    @location(0) seen: u32,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn visible(fragment: PieceFragment) -> Visible {
    let t0 = fragment.terms_0;
    let t1 = fragment.terms_1;
    let t2 = fragment.terms_2;
    let t3 = fragment.terms_3;
    let t4 = fragment.terms_4;
    let t5 = fragment.terms_5;
    let place = PIXEL * fragment.pixel.xy - fragment.center;
    let first = quadratic_at(Quadratic(t0.x, t0.y, t0.z, t0.w, t1.x, t1.y), place);
    let second = quadratic_at(Quadratic(t1.z, t1.w, t2.x, t2.y, t2.z, t2.w), place);
    let third = quadratic_at(Quadratic(t3.x, t3.y, t3.z, t3.w, t4.x, t4.y), place);
    let across = linear_at(Linear(t4.z, t4.w, t5.x), place);
    let ahead = linear_at(Linear(t5.y, t5.z, t5.w), place);
    let inside = min(min(first, second), min(third, ahead));
    let own = textureLoad(owners, vec2u(fragment.pixel.xy), 0).x == fragment.numbers.x;
    if inside < 0.0 || !own {
        discard;
    }
    // 1 where the rays start and 0 at infinity.
    return Visible(fragment.numbers.y, across / (across + ahead));
}
