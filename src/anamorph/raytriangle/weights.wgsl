// The ray through a point in the plane of a known t: its weights, in sums of two floats.
// needs: raytriangle/points.wgsl

// How near a valid ray passes by its point, as a share of the greater distance of point and origins from the middle:
// two roundings to f32.
const REACH = 1e-7;
const OUTERMOST = 1e8;
// Below this share of what it comes from, a length is nothing.
const SAME = 1e-12;

struct Root {
    // The ray triangle's own t over its pace.
    t: f32,
    u: f32,
    v: f32,
    real: bool,
    valid: bool,
}

// The change of the two weights that leads from the triangle's middle nearest to a point of its plane.
fn solved(off: vec3f, e: vec3f, g: vec3f, normal: vec3f, thin: bool) -> vec2f {
    if thin {
        // On a line, the least change of the weights that leads to the point.
        return vec2f(dot(e, off), dot(g, off)) / (dot(e, e) + dot(g, g));
    }
    return vec2f(dot(normal, cross(off, g)), dot(normal, cross(e, off))) / dot(normal, normal);
}

// The root at a t: its ray's weights, and whether that ray passes through the point.
fn root_at(triangle: u32, point: Two, t: Two) -> Root {
    let rays = triangles[triangle];
    let change_e = times(t, rays.directions[0]);
    let change_g = times(t, rays.directions[1]);
    var e = plus(rays.origins[0], change_e);
    var g = plus(rays.origins[1], change_g);
    // What the two sums would be without cancelling is what their rounding errors are to be measured by.
    let full_e = length(rays.origins[0].hi) + length(change_e.hi);
    let full_g = length(rays.origins[1].hi) + length(change_g.hi);
    let extent = max(longest(e.hi), longest(g.hi));
    let together = extent <= max(SAME * (full_e + full_g), rays.blur);
    let unit = power_of_two(extent);
    e = scaled(e, 1.0 / unit);
    g = scaled(g, 1.0 / unit);
    let off = scaled(from_middle(triangle, point, t), 1.0 / unit);
    let normal = vector_product(e, g).hi;
    let thin = together || length(normal) <= SAME * (full_e * length(g.hi) + length(e.hi) * full_g) / unit;
    var left = off;
    var a = two(vec3f());
    var b = two(vec3f());
    // Each step gains seven digits, less what the triangle is thin.
    for (var step = 0; step < 4 && !together; step++) {
        let more = solved(left.hi, e.hi, g.hi, normal, thin);
        a = plus(a, two(more.xxx));
        b = plus(b, two(more.yyy));
        left = minus(off, plus(times(a, e), times(b, g)));
        if thin {
            break;
        }
    }
    let missed = length(left.hi) * unit;
    let shift = rays.size_and_shift.z;
    let size = max(length(point.hi + shift * rays.mean.hi), rays.extent);
    let spans = full_e + full_g + rays.extent + abs(shift) + abs(t.hi.x);
    let sum = abs(a.hi.x) + abs(b.hi.x);
    let lost = sum * rays.blur + ROUNDING * ((1.0 + sum) * spans + length(point.hi));
    let world_t = plus(t, Two(rays.size_and_shift.zzz, rays.size_and_shift.www));
    var root = Root(world_t.hi.x, 0.0, 0.0, true, sum <= OUTERMOST && missed + lost <= REACH * size + rays.blur);
    if root.valid {
        root.u = 1.0 / 3.0 + (0.70710678 * a.hi.x - 0.40824829 * b.hi.x);
        root.v = 1.0 / 3.0 + 0.81649658 * b.hi.x;
    }
    return root;
}
