// What a fragment knows of its error, in pixels of the image.
// needs: methods/pervertex/pervertex.wgsl, methods/pervertex/lens.wgsl

// In distances from the eye to the surface: nearer nothing is expected.
const NEAREST_PROBE = 0.02;
const MOST_PROBES = 24.0;
// How close to the crossing of its rays a map is asked.
const NEAREST_CROSSING = 0.1;
const UNKNOWN = 1e6;
// An image folds where a pixel turns the ray in one direction by less than so many pixels of the eye, and by less than
// such a share of what it does in the other. FOLDS is 1 where that counts as a doubt: where doubts are traced.
override FOLDS: i32 = 0;
const FOLD = 0.45;
const NARROW = 0.03;

// Whether a map sees something nearer on the straight line, in the map, between two points in clip space.
fn hidden_between(view: i32, first: vec4f, last: vec4f) -> bool {
    // Only where the map looks: rays that converge have a map on either side of their crossing.
    let least = select(0.0, NEAREST_CROSSING * max(first.w, last.w), min(first.w, last.w) <= 0.0);
    let steepness = select(last.w - first.w, 1.0, last.w == first.w);
    let crossing = clamp((least - first.w) / steepness, 0.0, 1.0);
    let start = select(first, mix(first, last, crossing), first.w < least);
    let end = select(last, mix(first, last, crossing), last.w < least);
    let size = maps.views[view].size.xy;
    let probes = clamp(ceil(length((end.xy / end.w - start.xy / start.w) * 0.5 * size)), 1.0, MOST_PROBES);
    var hidden = false;
    for (var probe = 0.5; probe < probes; probe += 1.0) {
        // Equal steps in the map are not equal steps along the ray.
        let share = probe / probes;
        let clip = mix(start, end, share * start.w / (share * start.w + (1.0 - share) * end.w));
        let place = clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5;
        let depth = textureLoad(map_depth, map_texel(maps.views[view], place), 0);
        let inside = clip.w > 0.0 && clip.z < clip.w && all(place >= vec2f(0.0)) && all(place <= vec2f(1.0));
        // Depth is reversed: the map sees something nearer than the ray where its depth is greater. The sky is nowhere
        // nearer.
        let nearer = depth.x > clip.z / clip.w * 1.001 + 2.0 * (abs(depth.y) + abs(depth.z));
        hidden = hidden || (inside && depth.w > 0.0 && nearer);
    }
    return hidden && max(first.w, last.w) > 0.0;
}

// Whether the ray passes behind something as the maps see it, before it reaches what was found: what a map cannot tell
// then is whether it passes behind or through.
fn hidden_on_the_way(ray: Ray, found: Lookup) -> bool {
    let sky = found.point.w == 0.0;
    let nearest = NEAREST_PROBE * length(ray.origin - projection.eye.xyz);
    let distance = max(length(found.point.xyz - ray.origin), nearest);
    let first = vec4f(ray.origin + nearest * ray.direction, 1.0);
    let last = select(vec4f(ray.origin + distance * ray.direction, 1.0), vec4f(ray.direction, 0.0), sky);
    var hidden = false;
    for (var side = 0; side < SIDES; side++) {
        let view = select(side, found.at.view, CUBE == 1);
        hidden = hidden || hidden_between(view, maps.views[view].clip * first, maps.views[view].clip * last);
    }
    return hidden;
}

// How many pixels of the image what a fragment shows is away from what it should show; UNKNOWN where it cannot say.
fn error_in_pixels(ray: Ray, right_of: Ray, below: Ray, found: Lookup, valid: bool) -> f32 {
    let sky = found.point.w == 0.0;
    let offset = found.point.xyz - ray.origin;
    let distance = max(length(offset), 1e-12);
    let toward = select(offset / distance, found.point.xyz, sky);
    let nearness = select(1.0 / distance, 0.0, sky);
    let right = right_of.direction + nearness * right_of.origin;
    let down = below.direction + nearness * below.origin;
    // The step in the image by which the ray would turn to what is shown, by least squares.
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
    // Where the image folds, a pixel turns the ray by next to nothing, and its least error is many pixels.
    let turning = normal_equations.x + normal_equations.z;
    let least = FOLD * projection.base.w;
    let folds = determinant < turning * min(least * least, NARROW * NARROW * turning);
    let known = valid && !(FOLDS == 1 && folds) && dot(toward, ray.direction) > 0.0 && !is_front(found.point) && !hidden_on_the_way(ray, found);
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
