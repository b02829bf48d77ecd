// Where a map of surfaces may miss what is thinner than a texel: silhouettes that the four texels around them do
// not all hide, each as near as it may be there. A cell of this map lies between the middles of four texels.
// needs: gpu/scene.wgsl

struct Silhouette {
    // From -1 to 1, and the depth.
    start: vec3f,
    end: vec3f,
}

@group(2) @binding(0) var<storage, read> silhouettes: array<Silhouette>;
@group(2) @binding(1) var map_surfaces: texture_2d<u32>;

// Texels on each side of a silhouette: half the diagonal of a cell, and a little more for rounding.
const SPREAD = 0.75;
// Texels by which rounding may move a plane.
const PLANE_ROUNDING = 0.02;

struct SilhouetteFragment {
    @builtin(position) pixel: vec4f,
    // In texels of the map, and depth.
    @location(0) @interpolate(flat) start: vec3f,
    @location(1) @interpolate(flat) end: vec3f,
    @location(2) share: f32,
}

fn in_texels(place: vec3f) -> vec3f {
    return vec3f((place.xy * vec2f(0.5, -0.5) + 0.5) * projection.size.xy, place.z);
}

@vertex
fn silhouette_vertex(@builtin(vertex_index) index: u32) -> SilhouetteFragment {
    let edge = silhouettes[index / 6u];
    let start = in_texels(edge.start);
    let end = in_texels(edge.end);
    let length = distance(start.xy, end.xy);
    let along = select(vec2f(1.0, 0.0), (end.xy - start.xy) / length, length > 0.0);
    let corner = index % 6u;
    let at_end = corner == 1u || corner == 2u || corner == 4u;
    let across = select(-SPREAD, SPREAD, corner >= 2u && corner <= 4u);
    let beyond = select(-SPREAD, SPREAD, at_end);
    let place = select(start, end, at_end);
    // Within a cell the nearest part is this much nearer.
    let slope = select(0.0, (end.z - start.z) / length, length > 2.0 * SPREAD);
    let depth = select(max(start.z, end.z), place.z + beyond * slope + SPREAD * abs(slope), slope != 0.0);
    let moved = place.xy + beyond * along + across * vec2f(-along.y, along.x) - 0.5;
    let share = select(0.0, 1.0, at_end) + beyond / max(length, 1e-3);
    let clip = moved / projection.size.xy * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    return SilhouetteFragment(vec4f(clip, clamp(depth, 0.0, 1.0), 1.0), start, end, share);
}

@fragment
fn silhouette(fragment: SilhouetteFragment) {
    let size = projection.size;
    let place = mix(fragment.start, fragment.end, clamp(fragment.share, 0.0, 1.0));
    let corner = floor(fragment.pixel.xy) - size.zw;
    var hidden = true;
    for (var number = 0; number < 4; number++) {
        let texel = clamp(corner + vec2f(f32(number % 2), f32(number / 2)), vec2f(0.0), size.xy - 1.0);
        let surface = textureLoad(map_surfaces, vec2i(size.zw + texel), 0);
        let plane = bitcast<vec3f>(surface.yzw);
        let there = plane.x + dot(plane.yz, place.xy - texel - 0.5);
        let margin = PLANE_ROUNDING * (abs(plane.y) + abs(plane.z)) + 1e-6 * abs(plane.x);
        // A surface that slopes may be nearer at the texel and farther at the silhouette, or the other way round.
        hidden = hidden && (surface.x != 0u && plane.x >= place.z && there > place.z + margin);
    }
    if hidden {
        discard;
    }
}
