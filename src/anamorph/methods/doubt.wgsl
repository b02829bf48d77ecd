// What a fragment knows of its error, in pixels of the picture. Follows warp.wgsl, pervertex.wgsl and lens.wgsl.

// In distances from the eye to the surface: nearer nothing is expected.
const NEAREST_PROBE = 0.02;
const MOST_PROBES = 24.0;
const UNKNOWN = 1e6;

// Whether the ray passes behind something as the map sees it, before it reaches what was found: what the map cannot
// tell then is whether it passes behind or through. In the map the way there is a short straight line.
fn hidden_on_the_way(ray: Ray, found: Lookup) -> bool {
    let view = select(0, found.at.view, CUBE == 1 || SIDES > 1);
    let sky = found.point.w == 0.0;
    let first = NEAREST_PROBE * length(ray.origin - projection.eye.xyz);
    let last = select(max(length(found.point.xyz - ray.origin), first), 0.0, sky);
    var from_clip = maps.views[view].clip * vec4f(ray.origin + first * ray.direction, 1.0);
    let to_clip = maps.views[view].clip * vec4f(last * ray.direction + select(ray.origin, ray.direction, sky), select(1.0, 0.0, sky));
    if SIDES > 1 && from_clip.w < NEAREST_PROBE * to_clip.w {
        // Only from beyond the crossing of the rays.
        let share = (NEAREST_PROBE * to_clip.w - from_clip.w) / (to_clip.w - from_clip.w);
        from_clip = mix(from_clip, to_clip, clamp(share, 0.0, 1.0));
    }
    let line = (to_clip.xy / to_clip.w - from_clip.xy / from_clip.w) * 0.5 * maps.views[view].size.xy;
    let probes = clamp(ceil(length(line)), 1.0, MOST_PROBES);
    var hidden = false;
    for (var probe = 0.5; probe < probes; probe += 1.0) {
        // Equal steps in the map are not equal steps along the ray.
        let part = probe / probes * from_clip.w;
        let clip = mix(from_clip, to_clip, part / (part + (1.0 - probe / probes) * to_clip.w));
        let place = clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5;
        let depth = textureLoad(map_depth, map_texel(maps.views[view], place), 0);
        let inside = clip.w > 0.0 && clip.z < clip.w && all(place >= vec2f(0.0)) && all(place <= vec2f(1.0));
        // Depth is reversed: the map sees something nearer than the ray where its depth is greater.
        hidden = hidden || (inside && depth.x > clip.z / clip.w * 1.001 + 2.0 * (abs(depth.y) + abs(depth.z)));
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
    let known = valid && dot(toward, ray.direction) > 0.0 && !is_front(found.point) && !hidden_on_the_way(ray, found);
    return select(UNKNOWN, length(step), known);
}

@fragment
fn reflector_error(fragment: ReflectorFragment) -> @location(0) f32 {
    let ray = reflection(fragment).ray;
    let right = Ray(dpdx(ray.origin), dpdx(ray.direction));
    let below = Ray(dpdy(ray.origin), dpdy(ray.direction));
    let start = start_of(fragment.lookup);
    return error_in_pixels(ray, right, below, find(start, ray), inside_map(start, fragment.lookup.w));
}

@fragment
fn refractor_error(fragment: RefractorFragment) -> @location(0) f32 {
    let ray = refraction(fragment.origin_green, fragment.direction_green);
    let right = Ray(dpdx(ray.origin), dpdx(ray.direction));
    let below = Ray(dpdy(ray.origin), dpdy(ray.direction));
    let start = start_of(fragment.lookup_green);
    return error_in_pixels(ray, right, below, find(start, ray), way_of(fragment, start) == LEAVES);
}
