// Where the roots of c0 + c1 x + c2 x^2 + c3 x^3 lie, to f32: roots.py on the device.

const STEPS = 50;
// What f32 may have lost of the sum of the terms.
const CUBIC_NOISE = 4e-7;

struct Start {
    x: f32,
    // Whether the cubic crosses zero there, and not only touches it.
    crosses: bool,
}

struct Starts {
    count: u32,
    at: array<Start, 3>,
}

fn cubic_value(c: vec4f, x: f32) -> f32 {
    return c.x + x * (c.y + x * (c.z + x * c.w));
}

fn cubic_slope(c: vec4f, x: f32) -> f32 {
    return c.y + x * (2.0 * c.z + x * 3.0 * c.w);
}

// Where the slope vanishes, ascending; beyond 1 where it does not.
fn extrema(c: vec4f) -> vec2f {
    let a = 3.0 * c.w;
    let square = c.z * c.z - a * c.y;
    if square < 0.0 {
        return vec2f(2.0);
    }
    let root = sqrt(square);
    let larger = -(c.z + select(root, -root, c.z < 0.0));
    var first = 2.0;
    if a != 0.0 {
        first = select(2.0 * sign(larger) * sign(a), larger / a, abs(larger) < 2.0 * abs(a));
    }
    var second = select(2.0, 0.0, a != 0.0);
    if larger != 0.0 {
        second = select(2.0 * sign(c.y) * sign(larger), c.y / larger, abs(c.y) < 2.0 * abs(larger));
    }
    return vec2f(min(first, second), max(first, second));
}

// The root from `low` to `high`, over which the sign changes once, from - to + where `rising`.
fn root_between(c: vec4f, from_low: f32, to_high: f32, rising: bool) -> f32 {
    var low = from_low;
    var high = to_high;
    var x = 0.5 * (low + high);
    for (var step = 0; step < STEPS; step++) {
        let value = cubic_value(c, x);
        let slope = cubic_slope(c, x);
        if (value >= 0.0) == rising {
            high = x;
        } else {
            low = x;
        }
        var next = 0.5 * (low + high);
        if abs(value) < 4.0 * abs(slope) {
            let newton = x - value / slope;
            next = select(next, newton, newton >= low && newton <= high);
        }
        let done = value == 0.0 || abs(next - x) <= 2.4e-7 * abs(next);
        x = next;
        if done {
            break;
        }
    }
    return x;
}

fn add(starts: ptr<function, Starts>, x: f32, reciprocal: bool, reach: f32, crosses: bool) {
    if (*starts).count < 3u && (!reciprocal || abs(x) * reach >= 1.0) {
        (*starts).at[(*starts).count] = Start(select(x, 1.0 / x, reciprocal), crosses);
        (*starts).count += 1u;
    }
}

// Near where each root is, from -reach to reach. Where the cubic touches zero, or may: on either side of there.
fn cubic_roots(c: vec4f, reach: f32) -> Starts {
    var starts = Starts();
    let noise = CUBIC_NOISE * (abs(c.x) + abs(c.y) + abs(c.z) + abs(c.w));
    let at_ends = vec2<bool>(cubic_value(c, -1.0) >= 0.0, cubic_value(c, 1.0) >= 0.0);
    var crossings = 0;
    var touch = 0.0;
    var aside = 0.0;
    var touched = false;
    var touches_beyond = false;
    for (var half = 0; half < 2; half++) {
        // Beyond -1 to 1 the cubic is used in 1 / x, divided by x^3, with its coefficients in reverse.
        let beyond = half == 1;
        let turned = select(c, c.wzyx, beyond);
        let places = clamp(extrema(turned), vec2f(-1.0), vec2f(1.0));
        let values = vec2f(cubic_value(turned, places.x), cubic_value(turned, places.y));
        let first = at_ends.x != beyond;
        let inner_signs = select(
            select(values >= vec2f(), vec2(at_ends.y), places >= vec2f(1.0)), vec2(first), places <= vec2f(-1.0));
        var ends = array<f32, 4>(-1.0, places.x, places.y, 1.0);
        var signs = array<bool, 4>(first, inner_signs.x, inner_signs.y, at_ends.y);
        for (var k = 0; k < 3; k++) {
            if signs[k] != signs[k + 1] {
                crossings++;
                add(&starts, root_between(turned, ends[k], ends[k + 1], signs[k + 1]), beyond, reach, true);
            }
        }
        for (var k = 0; k < 2; k++) {
            let x = places[k];
            if !touched && abs(x) < 1.0 && abs(values[k]) <= noise
                && signs[k] == signs[k + 1] && signs[k + 1] == signs[k + 2] {
                let bend = abs(turned.z + 3.0 * x * turned.w);
                aside = sqrt(noise / max(bend, noise));
                touch = x;
                touched = true;
                touches_beyond = beyond;
            }
        }
    }
    if touched && crossings <= 1 {
        add(&starts, touch - aside, touches_beyond, reach, false);
        add(&starts, touch + aside, touches_beyond, reach, false);
    }
    return starts;
}
