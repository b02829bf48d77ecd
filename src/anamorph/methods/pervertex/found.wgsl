// Mirrors and lenses drawn into the visibility buffer: each pixel's own ray, bent at the exact surfaces, and what the
// maps of surfaces show on it.
// needs: methods/pervertex/search.wgsl, gpu/path_end.wgsl, optics/bend_lens.wgsl

// The line of the spectrum: 0 red, 1 green, 2 blue.
override LINE: i32 = 1;

// Whether the body is a lens, which light crosses, or a mirror.
override LENS: bool = false;
// 1 where what is doubtful will be traced, so that no guess is wanted.
override TRACED: i32 = 0;

// Flags of a triangle: its rays may meet their own body, which its maps leave out; and no map shows what they meet.
const MEETS_ITSELF = 2u;
const WITHOUT_MAP = 4u;

// By vertex of the scene: parameters on the exact surface.
@group(3) @binding(2) var<storage, read> parameters: array<vec2f>;

struct BodyFragment {
    @builtin(position) @invariant pixel: vec4f,
    // What is known of the triangle: see `LookingTriangle`.
    @location(0) @interpolate(flat) numbers: vec4u,
    @location(1) @interpolate(flat) ranges: vec4f,
    @location(2) @interpolate(flat) corner_a: vec3f,
    @location(3) @interpolate(flat) corner_b: vec3f,
    @location(4) @interpolate(flat) corner_c: vec3f,
    @location(5) @interpolate(flat) normal_a: vec3f,
    @location(6) @interpolate(flat) normal_b: vec3f,
    @location(7) @interpolate(flat) normal_c: vec3f,
    @location(8) @interpolate(flat) parameters_ab: vec4f,
    @location(9) @interpolate(flat) parameters_c: vec2f,
    // What the body lets through at any angle, by colour.
    @location(10) @interpolate(flat) tint: vec3f,
    @location(11) @interpolate(flat) object: u32,
}

@vertex
fn body_vertex(@builtin(vertex_index) index: u32) -> BodyFragment {
    let triangle = looking[index / 3u];
    let first = 3u * triangle.face;
    let numbers = vec3u(indices[first], indices[first + 1u], indices[first + 2u]);
    let a = vertices[numbers.x];
    let b = vertices[numbers.y];
    let c = vertices[numbers.z];
    return BodyFragment(
        projection.clip * vec4f(position_of(vertices[indices[first + index % 3u]]), 1.0),
        vec4u(triangle.face, triangle.flags, triangle.first_unseen, triangle.unseen_count),
        vec4f(triangle.reach, triangle.gap_start, triangle.gap_end, triangle.farthest),
        position_of(a), position_of(b), position_of(c),
        normal_of(a), normal_of(b), normal_of(c),
        vec4f(parameters[numbers.x], parameters[numbers.y]), parameters[numbers.z],
        select(silver_of(a.object).rgb, lens_tint(a.object), LENS), a.object,
    );
}

fn looking_of(fragment: BodyFragment) -> LookingTriangle {
    let numbers = fragment.numbers;
    let ranges = fragment.ranges;
    return LookingTriangle(numbers.x, numbers.y, numbers.z, numbers.w, ranges.x, ranges.y, ranges.z, ranges.w);
}

fn hit_of(fragment: BodyFragment) -> FlatHit {
    return flat_hit(
        fragment.object - 1u,
        projection.eye.xyz,
        normalize(viewing_direction(fragment.pixel.xy)),
        mat3x3f(fragment.corner_a, fragment.corner_b, fragment.corner_c),
        mat3x3f(fragment.normal_a, fragment.normal_b, fragment.normal_c),
        mat3x2f(fragment.parameters_ab.xy, fragment.parameters_ab.zw, fragment.parameters_c),
    );
}

// The end of the path of a ray that leaves a body after so many bounces. Only where it `surely` does so as the traced
// ray does can what it meets be proved.
fn end_of(fragment: BodyFragment, bent: BentRay, surely: bool, bounces: u32) -> PackedPathEnd {
    let triangle = looking_of(fragment);
    let ray = Ray(exact_sides[fragment.object - 1u].origin + bent.origin, bent.direction);
    let certain = surely && triangle.flags == 0u && triangle.reach >= 0.0 && bent.way == RAY_OK;
    var found = Found(Hit(0u, FARTHEST), false);
    if certain || (TRACED == 0 && (triangle.flags & WITHOUT_MAP) == 0u) {
        found = find(ray, triangle);
    }
    let proved = found.proved && certain && (found.hit.triangle & SPECULAR) == 0u;
    let status = select(STATUS_DOUBTFUL, select(STATUS_PROVED, STATUS_SKY, found.hit.triangle == 0u), proved);
    let flags = fragment.object | (status << 16u) | (bounces << 24u);
    return packed(PathEnd(ray.origin, found.hit.triangle & ~SPECULAR, ray.direction, flags, bent.transmittance * fragment.tint));
}

@fragment
fn reflector_found(fragment: BodyFragment) -> PackedPathEnd {
    return end_of(fragment, mirrored(fragment.object - 1u, hit_of(fragment)), true, 1u);
}

@fragment
fn refractor_found(fragment: BodyFragment) -> PackedPathEnd {
    let side = fragment.object - 1u;
    let hit = hit_of(fragment);
    let bent = through_lens(side, hit, lens_entry(side, hit), exact_sides[side].indices[LINE]);
    return end_of(fragment, bent, left_by_triangles(side, bent), 2u);
}
