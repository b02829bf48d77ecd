// Per-vertex reflection, second pass: a mirror drawn with the map, warped so that every vertex is exact.
// needs: methods/pervertex/warp.wgsl
// Kakimoto et al. 2007, sections 3.1 (step 4) and 3.4.

struct ReflectorFragment {
    @builtin(position) @invariant pixel: vec4f,
    @location(0) position: vec3f,
    // (s q, t q, q): projective, so that a flat mirror is exact; w: 1 where the map has a place for it.
    @location(1) lookup: vec4f,
    // Object number and flags.
    @location(2) @interpolate(flat) object: vec2u,
    @location(3) @interpolate(flat) corner_a: vec3f,
    @location(4) @interpolate(flat) corner_b: vec3f,
    @location(5) @interpolate(flat) corner_c: vec3f,
    @location(6) @interpolate(flat) normal_a: vec3f,
    @location(7) @interpolate(flat) normal_b: vec3f,
    @location(8) @interpolate(flat) normal_c: vec3f,
    @location(9) @interpolate(flat) silver: vec4f,
}

@vertex
fn reflector_vertex(@builtin(vertex_index) index: u32) -> ReflectorFragment {
    let triangle = triangles[index / 3u];
    let first = 3u * triangle.face;
    let a = vertices[indices[first]];
    let b = vertices[indices[first + 1u]];
    let c = vertices[indices[first + 2u]];
    let vertex = vertices[indices[first + index % 3u]];
    return ReflectorFragment(
        projection.clip * vec4f(position_of(vertex), 1.0),
        position_of(vertex),
        corner_data[triangle.data + index % 3u],
        vec2u(vertex.object, triangle.flags),
        position_of(a), position_of(b), position_of(c),
        normal_of(a), normal_of(b), normal_of(c),
        silver_of(vertex.object),
    );
}

// The ray that a fragment's line of sight goes on as, and the surface's normal where it does.
struct Reflection {
    ray: Ray,
    normal: vec3f,
    incident: vec3f,
}

fn barycentric(fragment: ReflectorFragment, point: vec3f) -> vec3f {
    let edge_b = fragment.corner_b - fragment.corner_a;
    let edge_c = fragment.corner_c - fragment.corner_a;
    let offset = point - fragment.corner_a;
    let across = cross(edge_b, edge_c);
    let weights = vec2f(dot(cross(offset, edge_c), across), dot(cross(edge_b, offset), across)) / dot(across, across);
    return vec3f(1.0 - weights.x - weights.y, weights);
}

fn normal_at(fragment: ReflectorFragment, weights: vec3f) -> vec3f {
    return normalize(weights.x * fragment.normal_a + weights.y * fragment.normal_b + weights.z * fragment.normal_c);
}

// Half the mean offset to the corners' tangent planes: to second order, where the smooth surface lies.
fn lift(fragment: ReflectorFragment, weights: vec3f) -> vec3f {
    let point = fragment.position;
    return 0.5 * (weights.x * dot(fragment.corner_a - point, fragment.normal_a) * fragment.normal_a
        + weights.y * dot(fragment.corner_b - point, fragment.normal_b) * fragment.normal_b
        + weights.z * dot(fragment.corner_c - point, fragment.normal_c) * fragment.normal_c);
}

fn reflection(fragment: ReflectorFragment) -> Reflection {
    let incident = normalize(viewing_direction(fragment.pixel.xy));
    let weights = barycentric(fragment, fragment.position);
    var origin = fragment.position;
    var normal = normal_at(fragment, weights);
    if (fragment.object.y & SMOOTH) != 0u {
        // Along the line of sight to the lifted surface, not along the normal: that is where the eye meets it.
        let slope = min(dot(incident, normal), -0.02);
        origin += incident * (dot(lift(fragment, weights), normal) / slope);
        normal = normal_at(fragment, barycentric(fragment, origin));
    }
    return Reflection(Ray(origin, reflect(incident, normal)), normal, incident);
}

fn reflected_color(fragment: ReflectorFragment) -> vec4f {
    let mirror = reflection(fragment);
    let start = start_of(fragment.lookup);
    var seen = found_color(start);
    if !inside_map(start, fragment.lookup.w) {
        seen = sky_color(mirror.ray.direction, projection.base.w);
    }
    return vec4f(schlick(fragment.silver, dot(mirror.normal, mirror.incident)) * seen, 1.0);
}

@fragment
fn reflector_color(fragment: ReflectorFragment) -> @location(0) vec4f {
    return reflected_color(fragment);
}

@fragment
fn reflector_depth(fragment: ReflectorFragment) -> @location(0) vec4f {
    return depth_and_slopes(fragment.pixel, fragment.object.x) + FRONT;
}

@fragment
fn reflector_end(fragment: ReflectorFragment) -> @location(0) vec4f {
    let mirror = reflection(fragment);
    let start = start_of(fragment.lookup);
    return select(vec4f(mirror.ray.direction, 0.0), end_of(find(start, mirror.ray)), inside_map(start, fragment.lookup.w));
}

@fragment
fn reflector_seen(fragment: ReflectorFragment) -> Seen {
    let mirror = reflection(fragment);
    let start = start_of(fragment.lookup);
    if !inside_map(start, fragment.lookup.w) {
        return Seen(vec4f(mirror.ray.direction, 0.0), seen_flags(fragment.object.x, STATUS_OUTSIDE), 0.0);
    }
    let found = find(start, mirror.ray);
    let end = end_of(found);
    return Seen(end, seen_flags(fragment.object.x, warped_status(end)), found.deviation);
}
