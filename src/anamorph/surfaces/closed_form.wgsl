// Where a ray meets a surface of closed form: plane, sphere, toroid or asphere.
// needs: surfaces/height.wgsl

const MOST_STEPS = 12;
// Lengths in a frame that is about as large as the mesh: what counts as met, and a step after which the next one would
// be lost in rounding.
const ON_SURFACE = 2e-6;
const LAST_STEP = 1e-4;

// How far it is to where a parabola is zero, that has this value, slope and second derivative here: of its two zeros to
// that where the slope has the sign of `side`, and if there is none to its turning point.
fn zero_of_parabola(value: f32, slope: f32, bend: f32, side: f32) -> f32 {
    let there = side * sqrt(max(slope * slope - 2.0 * value * bend, 0.0));
    return select((there - slope) / bend, -2.0 * value / (slope + there), slope * there > 0.0);
}

// The numbers of a plane or sphere: its point nearest to the frame's origin, the normal there, the curvature.
// Its height is a parabola along the ray.
fn meet_round(first: u32, point: vec3f, direction: vec3f, facing: vec3f) -> Met {
    let foot = point - vector_at(first);
    let outward = vector_at(first + 3u);
    let curvature = surface_numbers[first + 6u];
    let gradient = outward + curvature * foot;
    let value = dot(foot, outward + 0.5 * curvature * foot);
    let slope = dot(gradient, direction);
    let side = select(1.0, -1.0, dot(gradient, facing) > 0.0);
    let step = zero_of_parabola(value, slope, curvature, side);
    let met = slope * slope >= 2.0 * value * curvature && (curvature != 0.0 || slope * side > 0.0);
    return Met(met, step, normalize(gradient + curvature * step * direction));
}

// The numbers of the others: the apex, the axes right, up and outward, the shape.
// Each step goes to the zero of the parabola that touches the height along the ray.
fn meet_sag(kind: u32, first: u32, point: vec3f, ray: vec3f, facing: vec3f) -> Met {
    let axes = mat3x3f(vector_at(first + 3u), vector_at(first + 6u), vector_at(first + 9u));
    let start = (point - vector_at(first)) * axes;
    let direction = ray * axes;
    var step = 0.0;
    var here = height(kind, first + 12u, start, direction);
    let side = select(1.0, -1.0, dot(here.gradient, facing * axes) > 0.0);
    for (var number = 0; number < MOST_STEPS; number++) {
        let slope = dot(here.gradient, direction);
        if here.bend == 0.0 && slope * side <= 0.0 {
            break;
        }
        let change = zero_of_parabola(here.value, slope, here.bend, side);
        step += change;
        here = height(kind, first + 12u, start + step * direction, direction);
        if abs(change) <= LAST_STEP {
            break;
        }
    }
    return Met(abs(here.value) <= ON_SURFACE && here.sheet, step, axes * normalize(here.gradient));
}
