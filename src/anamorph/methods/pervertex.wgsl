// Per-vertex reflection, second pass: the reflector drawn with the map, warped so that every vertex is exact.
// Kakimoto et al. 2007, sections 3.1 (step 4) and 3.4. Follows vertices.wgsl and map.wgsl.
//
// Beyond the paper: a fragment knows its own ray, and the map knows the world position of each of its texels. So the
// fragment can see how far what it looked up lies from its ray, and step through the map towards it.

// Steps that each fragment takes; 0 is the paper's warp.
override REFINEMENTS: i32 = 0;

struct ReflectorMesh {
    first_vertex: u32,
    // 1 where the mesh approximates a smooth surface: its true surface lies off the flat triangles.
    smooth_surface: u32,
}

@group(2) @binding(0) var<uniform> map_projection: Projection;
@group(2) @binding(1) var map_color: texture_2d<f32>;
@group(2) @binding(2) var map_sampler: sampler;
@group(2) @binding(3) var map_depth: texture_2d<f32>;
@group(2) @binding(4) var<uniform> mesh: ReflectorMesh;
@group(2) @binding(5) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(6) var<storage, read> indices: array<u32>;
// (s q, t q, q) of each vertex: projective, so that a flat mirror is exact; w: 1 where it has a place in the map.
@group(2) @binding(7) var<storage, read> lookups: array<vec4f>;

struct ReflectorFragment {
    @builtin(position) @invariant pixel: vec4f,
    @location(0) position: vec3f,
    @location(1) lookup: vec4f,
    @location(2) @interpolate(flat) object: u32,
    @location(3) @interpolate(flat) corner_a: vec3f,
    @location(4) @interpolate(flat) corner_b: vec3f,
    @location(5) @interpolate(flat) corner_c: vec3f,
    @location(6) @interpolate(flat) normal_a: vec3f,
    @location(7) @interpolate(flat) normal_b: vec3f,
    @location(8) @interpolate(flat) normal_c: vec3f,
}

@vertex
fn reflector_vertex(@builtin(vertex_index) index: u32) -> ReflectorFragment {
    let number = indices[index];
    let vertex = vertices[number];
    let first = index - index % 3u;
    let a = vertices[indices[first]];
    let b = vertices[indices[first + 1u]];
    let c = vertices[indices[first + 2u]];
    return ReflectorFragment(
        projection.clip * vec4f(position_of(vertex), 1.0),
        position_of(vertex),
        lookups[number - mesh.first_vertex],
        vertex.object,
        position_of(a), position_of(b), position_of(c),
        normal_of(a), normal_of(b), normal_of(c),
    );
}

// The ray that a fragment's eye ray goes on as: where it leaves the surface, its unit direction, and the surface's
// normal there.
struct TrueRay {
    origin: vec3f,
    direction: vec3f,
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

fn true_ray(fragment: ReflectorFragment) -> TrueRay {
    let incident = normalize(fragment.position - projection.eye.xyz);
    let weights = barycentric(fragment, fragment.position);
    var origin = fragment.position;
    var normal = normal_at(fragment, weights);
    if mesh.smooth_surface == 1u {
        // Along the eye's ray to the lifted surface, not along the normal: that is where the eye meets it.
        let slope = min(dot(incident, normal), -0.02);
        origin += incident * (dot(lift(fragment, weights), normal) / slope);
        normal = normal_at(fragment, barycentric(fragment, origin));
    }
    return TrueRay(origin, reflect(incident, normal), normal, incident);
}

// What the map shows at a place, and the angle by which that misses a fragment's ray.
struct Lookup {
    place: vec2f,
    point: vec4f,
    deviation: f32,
}

fn look(place: vec2f, ray: TrueRay) -> Lookup {
    let point = map_point(map_projection, place, textureLoad(map_depth, map_texel(map_projection, place), 0));
    let toward = select(point.xyz - ray.origin, point.xyz, point.w == 0.0);
    return Lookup(place, point, angle_between(toward, ray.direction));
}

// Where the map shows the point of the ray nearest to what it showed last.
fn step_towards(ray: TrueRay, last: Lookup) -> vec2f {
    let along = max(dot(last.point.xyz - ray.origin, ray.direction), 0.0);
    let nearest = vec4f(ray.origin + along * ray.direction, 1.0);
    let clip = map_projection.clip * select(nearest, vec4f(ray.direction, 0.0), last.point.w == 0.0);
    let place = clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5;
    return select(last.place, clamp(place, vec2f(0.0), vec2f(1.0)), clip.w > 0.0);
}

// The lookup with the least deviation among the start and the steps from it: a step can swing between two surfaces.
fn refine(start: vec2f, ray: TrueRay) -> Lookup {
    var last = look(start, ray);
    var best = last;
    for (var step = 0; step < REFINEMENTS; step++) {
        last = look(step_towards(ray, last), ray);
        if last.deviation < best.deviation {
            best = last;
        }
    }
    return best;
}

// Whether the map has an answer for this fragment.
fn inside_map(place: vec2f, valid: f32) -> bool {
    return valid > 0.9999 && all(place >= vec2f(0.0)) && all(place <= vec2f(1.0));
}

@fragment
fn reflector_color(fragment: ReflectorFragment) -> @location(0) vec4f {
    let ray = true_ray(fragment);
    let start = fragment.lookup.xy / fragment.lookup.z;
    var place = start;
    if REFINEMENTS > 0 {
        place = refine(start, ray).place;
    }
    let reflected = textureSampleGrad(map_color, map_sampler, place, dpdx(start), dpdy(start)).rgb;
    if !inside_map(start, fragment.lookup.w) {
        return vec4f(specular_stand_in(fragment.object, ray.normal, ray.incident, projection.base.w), 1.0);
    }
    return vec4f(mirror_reflectance(fragment.object, dot(ray.normal, ray.incident)) * reflected, 1.0);
}

@fragment
fn reflector_seen(fragment: ReflectorFragment) -> Seen {
    let ray = true_ray(fragment);
    let start = fragment.lookup.xy / fragment.lookup.z;
    if !inside_map(start, fragment.lookup.w) {
        return Seen(vec4f(ray.direction, 0.0), seen_flags(fragment.object, STATUS_OUTSIDE), 0.0);
    }
    let found = refine(start, ray);
    var status = select(STATUS_WARPED, STATUS_REFINED, any(found.place != start));
    if found.point.w == 0.0 {
        status = STATUS_SKY;
    }
    return Seen(found.point, seen_flags(fragment.object, status), found.deviation);
}

// The ray's points at which map and ray are compared for what stands between.
const PROBES = 8;
// As a share of the way.
const NEAREST_PROBE = 1e-3;
const FARTHEST_PROBE = 1e4;
const UNKNOWN = 1e6;

// Whether the ray passes behind something as the map sees it, before it reaches what was found: what the map cannot
// tell then is whether it passes behind or through.
fn hidden_on_the_way(ray: TrueRay, found: Lookup) -> bool {
    let end = select(length(found.point.xyz - ray.origin), FARTHEST_PROBE, found.point.w == 0.0);
    let ratio = pow(NEAREST_PROBE, -1.0 / f32(PROBES));
    var along = NEAREST_PROBE * end / ratio;
    var hidden = false;
    for (var probe = 0; probe < PROBES; probe++) {
        along *= ratio;
        let clip = map_projection.clip * vec4f(ray.origin + along * ray.direction, 1.0);
        let place = clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5;
        let depth = textureLoad(map_depth, map_texel(map_projection, place), 0);
        let inside = clip.w > 0.0 && clip.z < clip.w && all(place >= vec2f(0.0)) && all(place <= vec2f(1.0));
        // Depth is reversed: the map sees something nearer than the ray where its depth is greater.
        hidden = hidden || (inside && depth.x > clip.z / clip.w * 1.001 + 2.0 * (abs(depth.y) + abs(depth.z)));
    }
    return hidden;
}

// How many pixels of the picture what a fragment shows is away from what it should show; UNKNOWN where it cannot say.
@fragment
fn reflector_error(fragment: ReflectorFragment) -> @location(0) f32 {
    let ray = true_ray(fragment);
    let start = fragment.lookup.xy / fragment.lookup.z;
    let found = refine(start, ray);
    let sky = found.point.w == 0.0;
    let offset = found.point.xyz - ray.origin;
    let distance = max(length(offset), 1e-12);
    let toward = select(offset / distance, found.point.xyz, sky);
    let nearness = select(1.0 / distance, 0.0, sky);
    let right = dpdx(ray.direction) + nearness * dpdx(ray.origin);
    let down = dpdy(ray.direction) + nearness * dpdy(ray.origin);
    // The step in the picture by which the ray would turn to what is shown, by least squares.
    let miss = toward - ray.direction;
    let normal_equations = vec3f(dot(right, right), dot(right, down), dot(down, down));
    let determinant = max(
        normal_equations.x * normal_equations.z - normal_equations.y * normal_equations.y,
        1e-6 * normal_equations.x * normal_equations.z + 1e-30
    );
    let sides = vec2f(dot(right, miss), dot(down, miss));
    let step = vec2f(
        normal_equations.z * sides.x - normal_equations.y * sides.y,
        normal_equations.x * sides.y - normal_equations.y * sides.x
    ) / determinant;
    let specular = !sky && is_specular(u32(max(found.point.w, 1.0)));
    let known = inside_map(start, fragment.lookup.w) && dot(toward, ray.direction) > 0.0 && !specular
        && !hidden_on_the_way(ray, found);
    return select(UNKNOWN, length(step), known);
}
