// What a fragment knows of its error, in pixels of the picture. Follows warp.wgsl, pervertex.wgsl and lens.wgsl.

// The ray's points at which map and ray are compared for what stands between.
const PROBES = 10;
// In distances from the eye to the surface: nearer nothing is expected, farther map and ray see the same.
const NEAREST_PROBE = 0.02;
const FARTHEST_PROBE = 100.0;
const UNKNOWN = 1e6;

// Whether a side's map sees something before a point.
fn hidden_in_map(point: vec4f, side: i32) -> bool {
    let view = select(side, cube_face(point.xyz - maps.views[0].eye.xyz), CUBE == 1);
    let clip = maps.views[view].clip * point;
    let place = clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5;
    let depth = textureLoad(map_depth, map_texel(maps.views[view], place), 0);
    let inside = clip.w > 0.0 && clip.z < clip.w && all(place >= vec2f(0.0)) && all(place <= vec2f(1.0));
    // Depth is reversed: the map sees something nearer than the ray where its depth is greater. The sky is nowhere nearer.
    return inside && depth.w > 0.0 && depth.x > clip.z / clip.w * 1.001 + 2.0 * (abs(depth.y) + abs(depth.z));
}

// Whether the ray passes behind something as the maps see it, before it reaches what was found: what the map cannot
// tell then is whether it passes behind or through.
fn hidden_on_the_way(ray: Ray, found: Lookup) -> bool {
    let start = NEAREST_PROBE * length(ray.origin - projection.eye.xyz);
    let farthest = start * FARTHEST_PROBE / NEAREST_PROBE;
    let end = select(min(length(found.point.xyz - ray.origin), farthest), farthest, found.point.w == 0.0);
    let ratio = pow(max(end / start, 1.0), 1.0 / f32(PROBES));
    var along = start / ratio;
    var hidden = false;
    for (var probe = 0; probe < PROBES; probe++) {
        along *= ratio;
        let point = vec4f(ray.origin + along * ray.direction, 1.0);
        for (var side = 0; side < maps.sides; side++) {
            hidden = hidden || hidden_in_map(point, side);
        }
    }
    return hidden;
}

// How many pixels of the picture what a fragment shows is away from what it should show; UNKNOWN where it cannot say.
fn error_in_pixels(ray: Ray, right_of: Ray, below: Ray, found: Lookup, valid: bool) -> f32 {
    let sky = found.point.w == 0.0;
    let offset = found.point.xyz - ray.origin;
    let distance = max(length(offset), 1e-12);
    let toward = select(offset / distance, found.point.xyz, sky);
    let nearness = select(1.0 / distance, 0.0, sky);
    let right = right_of.direction + nearness * right_of.origin;
    let down = below.direction + nearness * below.origin;
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
    let known = valid && dot(toward, ray.direction) > 0.0 && !specular && !hidden_on_the_way(ray, found);
    return select(UNKNOWN, length(step), known);
}

fn reflector_doubt(fragment: ReflectorFragment) -> f32 {
    let ray = reflection(fragment).ray;
    let right = Ray(dpdx(ray.origin), dpdx(ray.direction));
    let below = Ray(dpdy(ray.origin), dpdy(ray.direction));
    let start = start_of(fragment.lookup);
    return error_in_pixels(ray, right, below, find(start, ray), inside_map(start, fragment.lookup.w));
}

fn refractor_doubt(fragment: RefractorFragment) -> f32 {
    let ray = refraction(fragment.origin_green, fragment.direction_green);
    let right = Ray(dpdx(ray.origin), dpdx(ray.direction));
    let below = Ray(dpdy(ray.origin), dpdy(ray.direction));
    let start = start_of(fragment.lookup_green);
    return error_in_pixels(ray, right, below, find(start, ray), way_of(fragment, start) == LEAVES);
}

@fragment
fn reflector_error(fragment: ReflectorFragment) -> @location(0) f32 {
    return reflector_doubt(fragment);
}

@fragment
fn refractor_error(fragment: RefractorFragment) -> @location(0) f32 {
    return refractor_doubt(fragment);
}

// The overlay of what doubts itself: from yellow at one pixel to red at HIGHEST, and violet where it cannot say.
const HIGHEST = 100.0;
const LEAST_COLOR = vec3f(1.0, 0.8, 0.0);
const MOST_COLOR = vec3f(0.8, 0.0, 0.0);
const UNKNOWN_COLOR = vec3f(0.35, 0.0, 0.8);
const TINTED = 0.75;

fn tinted(color: vec4f, error: f32) -> vec4f {
    let scale = mix(LEAST_COLOR, MOST_COLOR, clamp(log(max(error, 1.0)) / log(HIGHEST), 0.0, 1.0));
    let tint = select(scale, UNKNOWN_COLOR, error >= UNKNOWN);
    return vec4f(mix(color.rgb, tint, select(0.0, TINTED, error > 1.0)), color.a);
}

@fragment
fn reflector_inconsistency(fragment: ReflectorFragment) -> @location(0) vec4f {
    return tinted(reflected_color(fragment), reflector_doubt(fragment));
}

@fragment
fn refractor_inconsistency(fragment: RefractorFragment) -> @location(0) vec4f {
    return tinted(refracted_color(fragment), refractor_doubt(fragment));
}
