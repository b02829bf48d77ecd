// Per-vertex reflection, second pass: the reflector drawn with the map, warped so that every vertex is exact.
// Kakimoto et al. 2007, sections 3.1 (step 4) and 3.4. Follows map.wgsl.

@group(2) @binding(0) var<uniform> map_projection: Projection;
@group(2) @binding(1) var map_color: texture_2d<f32>;
@group(2) @binding(2) var map_sampler: sampler;
@group(2) @binding(3) var map_depth: texture_2d<f32>;

struct ReflectorFragment {
    @builtin(position) pixel: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) @interpolate(flat) object: u32,
    // (s q, t q, q): projective, so that a flat mirror is exact; w: 1 where all vertices have a place in the map.
    @location(3) lookup: vec4f,
}

@vertex
fn reflector_vertex(vertex: VertexIn, @location(5) lookup: vec4f) -> ReflectorFragment {
    var fragment: ReflectorFragment;
    fragment.pixel = projection.clip * vec4f(vertex.position, 1.0);
    fragment.position = vertex.position;
    fragment.normal = vertex.normal;
    fragment.object = vertex.object;
    fragment.lookup = lookup;
    return fragment;
}

// Whether the map has an answer for this fragment.
fn inside_map(place: vec2f, valid: f32) -> bool {
    return valid > 0.9999 && all(place >= vec2f(0.0)) && all(place <= vec2f(1.0));
}

@fragment
fn reflector_color(fragment: ReflectorFragment) -> @location(0) vec4f {
    let place = fragment.lookup.xy / fragment.lookup.z;
    let reflected = textureSample(map_color, map_sampler, place).rgb;
    let normal = normalize(fragment.normal);
    let direction = normalize(fragment.position - projection.eye.xyz);
    if !inside_map(place, fragment.lookup.w) {
        return vec4f(specular_stand_in(fragment.object, normal, direction, projection.base.w), 1.0);
    }
    return vec4f(mirror_reflectance(fragment.object, dot(normal, direction)) * reflected, 1.0);
}

@fragment
fn reflector_seen(fragment: ReflectorFragment) -> Seen {
    let place = fragment.lookup.xy / fragment.lookup.z;
    let normal = normalize(fragment.normal);
    let direction = normalize(fragment.position - projection.eye.xyz);
    if !inside_map(place, fragment.lookup.w) {
        return Seen(vec4f(reflect(direction, normal), 0.0), seen_flags(fragment.object, STATUS_OUTSIDE));
    }
    let depth = textureLoad(map_depth, map_texel(map_projection, place), 0);
    let point = map_point(map_projection, place, depth);
    return Seen(point, seen_flags(fragment.object, select(STATUS_WARPED, STATUS_SKY, point.w == 0.0)));
}
