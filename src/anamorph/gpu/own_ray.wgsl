// A triangle of a mirror or a lens, drawn so that each pixel bends its own ray at the exact surfaces.
// needs: gpu/scene.wgsl, gpu/vertices.wgsl, optics/bend_lens.wgsl

// The line of the spectrum: 0 red, 1 green, 2 blue.
override LINE: i32 = 1;

// Whether the body is a lens, which light crosses, or a mirror.
override LENS: bool = false;

// By vertex of the scene: parameters on the exact surface.
@group(3) @binding(2) var<storage, read> parameters: array<vec2f>;

struct BodyFragment {
    @builtin(position) @invariant pixel: vec4f,
    @location(0) @interpolate(flat) corner_a: vec3f,
    @location(1) @interpolate(flat) corner_b: vec3f,
    @location(2) @interpolate(flat) corner_c: vec3f,
    @location(3) @interpolate(flat) normal_a: vec3f,
    @location(4) @interpolate(flat) normal_b: vec3f,
    @location(5) @interpolate(flat) normal_c: vec3f,
    @location(6) @interpolate(flat) parameters_ab: vec4f,
    @location(7) @interpolate(flat) parameters_c: vec2f,
    // What the body lets through at any angle, by colour.
    @location(8) @interpolate(flat) tint: vec3f,
    // The triangle's place among those that are drawn, and its object.
    @location(9) @interpolate(flat) numbers: vec2u,
}

// A corner of the triangle of three vertices with these numbers.
fn body_fragment(
    a: StoredVertex, b: StoredVertex, c: StoredVertex, vertex_numbers: vec3u, corner: u32, drawn: u32,
) -> BodyFragment {
    let corners = array<vec3f, 3>(position_of(a), position_of(b), position_of(c));
    return BodyFragment(
        projection.clip * vec4f(corners[corner], 1.0),
        corners[0], corners[1], corners[2],
        normal_of(a), normal_of(b), normal_of(c),
        vec4f(parameters[vertex_numbers.x], parameters[vertex_numbers.y]), parameters[vertex_numbers.z],
        select(silver_of(a.object).rgb, lens_tint(a.object), LENS), vec2u(drawn, a.object),
    );
}

fn hit_of(fragment: BodyFragment) -> FlatHit {
    return flat_hit(
        fragment.numbers.y - 1u,
        projection.eye.xyz,
        normalize(viewing_direction(fragment.pixel.xy)),
        mat3x3f(fragment.corner_a, fragment.corner_b, fragment.corner_c),
        mat3x3f(fragment.normal_a, fragment.normal_b, fragment.normal_c),
        mat3x2f(fragment.parameters_ab.xy, fragment.parameters_ab.zw, fragment.parameters_c),
    );
}

// A ray as it leaves a body.
struct LeavingRay {
    origin: vec3f,
    // Unit.
    direction: vec3f,
    // What share of the light goes this way, by colour.
    throughput: vec3f,
    // Whether the traced ray surely leaves so.
    certain: bool,
}

fn leaving(fragment: BodyFragment, bent: BentRay, surely: bool) -> LeavingRay {
    let origin = exact_sides[fragment.numbers.y - 1u].origin + bent.origin;
    return LeavingRay(origin, bent.direction, bent.transmittance * fragment.tint, surely && bent.way == RAY_OK);
}

fn reflected_ray(fragment: BodyFragment) -> LeavingRay {
    return leaving(fragment, mirrored(fragment.numbers.y - 1u, hit_of(fragment)), true);
}

fn refracted_ray(fragment: BodyFragment) -> LeavingRay {
    let side = fragment.numbers.y - 1u;
    let hit = hit_of(fragment);
    let bent = through_lens(side, hit, lens_entry(side, hit), exact_sides[side].indices[LINE]);
    return leaving(fragment, bent, left_by_triangles(side, bent));
}
