// The overlay of inconsistency: fragments that show what their own rays do not meet.
// needs: methods/pervertex/pervertex.wgsl, methods/pervertex/lens.wgsl
// Kakimoto et al. 2007, section 6 and Figure 16.

// From yellow at one pixel of the image to red at HIGHEST, and violet where the map has no place.
const HIGHEST = 100.0;
const LEAST_COLOR = vec3f(1.0, 0.8, 0.0);
const MOST_COLOR = vec3f(0.8, 0.0, 0.0);
const UNKNOWN_COLOR = vec3f(0.35, 0.0, 0.8);
const TINTED = 0.75;

// How many pixels away in the image a ray would turn to what is shown, by least squares over both its changes.
fn pixels_off(ray: Ray, shown: vec4f) -> f32 {
    let nearness = select(1.0 / max(length(shown.xyz - ray.origin), 1e-12), 0.0, shown.w == 0.0);
    let toward = select(nearness * (shown.xyz - ray.origin), shown.xyz, shown.w == 0.0);
    let right = dpdx(ray.direction) + nearness * dpdx(ray.origin);
    let down = dpdy(ray.direction) + nearness * dpdy(ray.origin);
    let normal_equations = mat2x2f(dot(right, right), dot(right, down), dot(right, down), dot(down, down));
    let sides = vec2f(dot(right, toward - ray.direction), dot(down, toward - ray.direction));
    let least = 1e-6 * normal_equations[0].x * normal_equations[1].y + 1e-30;
    let adjugate = mat2x2f(
        normal_equations[1].y, -normal_equations[0].y, -normal_equations[0].y, normal_equations[0].x
    );
    return length(adjugate * sides) / max(determinant(normal_equations), least);
}

fn tinted(color: vec4f, pixels: f32, known: bool) -> vec4f {
    let scale = mix(LEAST_COLOR, MOST_COLOR, clamp(log(max(pixels, 1.0)) / log(HIGHEST), 0.0, 1.0));
    let tint = select(UNKNOWN_COLOR, scale, known);
    return vec4f(mix(color.rgb, tint, select(0.0, TINTED, !known || pixels > 1.0)), color.a);
}

@fragment
fn reflector_inconsistency(fragment: ReflectorFragment) -> @location(0) vec4f {
    let ray = reflection(fragment).ray;
    let start = start_of(fragment.lookup);
    let pixels = pixels_off(ray, find(start, ray).point);
    return tinted(reflected_color(fragment), pixels, inside_map(start, fragment.lookup.w));
}

@fragment
fn refractor_inconsistency(fragment: RefractorFragment) -> @location(0) vec4f {
    let ray = refraction(fragment);
    let start = start_of(fragment.lookup_green);
    let pixels = pixels_off(ray, find(start, ray).point);
    return tinted(refracted_color(fragment), pixels, way_of(fragment, start) == LEAVES);
}
