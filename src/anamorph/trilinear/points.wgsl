// Points projected into ray triangles: points.py on the device. Follows two_floats.wgsl and cubic.wgsl.
//
// Where roots lie is found in f32, from a cubic that counts t from where the middle ray passes the point; each is then
// polished in sums of two floats, and so are its weights.

const REACH = 1e-7;
const OUTERMOST = 1e8;
// In the frame: what is beyond is not projected, because the squares of its coordinates leave the range of f32.
const FARTHEST = 1e16;
// What sums of two floats lose, and below which share of what it comes from a length is nothing.
const ROUNDING = 2.8e-14;
const SAME = 1e-12;
const POLISHINGS = 12;

// A RayTriangleFrame.
struct RayTriangle {
    center: Two,
    origins: array<Two, 2>,
    directions: array<Two, 2>,
    mean: Two,
    planes: array<Two, 3>,
    // Of one over the size, and of the shift.
    size_and_shift: vec4f,
    extent: f32,
    blur: f32,
    flat: f32,
}

struct Block {
    points: u32,
    triangles: u32,
    zero: u32,
}

struct Projections {
    t: vec3f,
    // Bit k: root k is real; bit 3 + k: it is valid.
    flags: u32,
    u: vec3f,
    v: vec3f,
}

struct Root {
    // The ray triangle's own t over its pace.
    t: f32,
    u: f32,
    v: f32,
    real: bool,
    valid: bool,
}

struct Plane {
    // The polished t in all three places, and whether the point lies in its plane.
    t: Two,
    holds: bool,
}

@group(0) @binding(0) var<uniform> block: Block;
@group(0) @binding(1) var<storage> triangles: array<RayTriangle>;
@group(0) @binding(2) var<storage> points: array<Two>;
@group(0) @binding(3) var<storage, read_write> found: array<Projections>;

fn sealing() -> u32 {
    return block.zero;
}

fn longest(a: vec3f) -> f32 {
    return max(max(abs(a.x), abs(a.y)), abs(a.z));
}

// The point less t times the mean direction.
fn from_middle(triangle: u32, point: Two, t: Two) -> Two {
    return minus(point, times(t, triangles[triangle].mean));
}

// N(t).
fn normal_at(triangle: u32, t: Two) -> Two {
    let planes = triangles[triangle].planes;
    return plus(planes[0], times(t, plus(planes[1], times(t, planes[2]))));
}

// Newton's steps on (s - t m) . N(t), each taken where it comes nearer to zero. Lengths are in units of `unit`.
fn polished(triangle: u32, point: Two, start: Two, unit: f32) -> Plane {
    let planes = triangles[triangle].planes;
    let mean = triangles[triangle].mean.hi;
    // One scale for all of N: its squares may be out of range.
    var t = start;
    var off = scaled(from_middle(triangle, point, t), 1.0 / unit);
    var normal = normal_at(triangle, t);
    let steep = 1.0 / power_of_two(longest(normal.hi));
    normal = scaled(normal, steep);
    var value = inner(off, normal).hi;
    for (var step = 0; step < POLISHINGS; step++) {
        let change = (steep * planes[1].hi + 2.0 * t.hi * (steep * planes[2].hi)) * unit;
        let slope = dot(off.hi, change) - dot(mean, normal.hi);
        if slope == 0.0 || value.x == 0.0 {
            break;
        }
        let next = plus(t, two(-value / slope * unit));
        let next_off = scaled(from_middle(triangle, point, next), 1.0 / unit);
        let next_normal = scaled(normal_at(triangle, next), steep);
        let next_value = inner(next_off, next_normal).hi;
        if !(abs(next_value.x) < abs(value.x)) {
            break;
        }
        t = next;
        off = next_off;
        normal = next_normal;
        value = next_value;
    }
    let along = abs(t.hi.x);
    let steepest = steep * (length(planes[0].hi) + along * (length(planes[1].hi) + along * length(planes[2].hi)));
    let farthest = (length(point.hi) + along * length(mean)) / unit;
    return Plane(t, abs(value.x) <= ROUNDING * steepest * farthest);
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

// Near which t's the roots are, in the frame.
fn near_roots(triangle: u32, point: Two, middle: f32, unit: ptr<function, f32>) -> Starts {
    let rays = triangles[triangle];
    let t = two(vec3f(middle));
    let off = from_middle(triangle, point, t);
    let e = rays.origins[0].hi + middle * rays.directions[0].hi;
    let g = rays.origins[1].hi + middle * rays.directions[1].hi;
    // In units of how wide the rays are there.
    let wide = power_of_two(longest(off.hi) + longest(e) + longest(g) + rays.blur);
    *unit = wide;
    var normal = array<Two, 3>(
        normal_at(triangle, t),
        scaled(plus(rays.planes[1], times(scaled(t, 2.0), rays.planes[2])), wide),
        scaled(rays.planes[2], wide * wide));
    let most = max(longest(normal[0].hi), max(longest(normal[1].hi), longest(normal[2].hi)));
    let near = scaled(off, 1.0 / wide);
    var c = array<f32, 4>(0.0, 0.0, 0.0, 0.0);
    var before = two(vec3f());
    for (var k = 0; k < 3; k++) {
        let turned = scaled(normal[k], 1.0 / power_of_two(most));
        c[k] = minus(inner(near, turned), before).hi.x;
        before = inner(rays.mean, turned);
    }
    c[3] = -before.hi.x;
    let cubic = vec4f(c[0], c[1], c[2], c[3]);
    let greatest = max(longest(cubic.xyz), abs(cubic.w));
    // A point that lies in all planes has no t of its own.
    if !(greatest > ROUNDING * (1.0 + (length(point.hi) + abs(middle)) / wide)) {
        return Starts();
    }
    return cubic_roots(cubic / greatest, min(1e8, 1e17 / wide));
}

@compute @workgroup_size(64)
fn project(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= block.points * block.triangles {
        return;
    }
    let triangle = id.x / block.points;
    let size_and_shift = triangles[triangle].size_and_shift;
    let around = minus(points[id.x % block.points], triangles[triangle].center);
    let point = times(around, Two(size_and_shift.xxx, size_and_shift.yyy));
    var roots = array<Root, 3>(Root(), Root(), Root());
    if triangles[triangle].flat == 0.0 && longest(point.hi) <= FARTHEST {
        let mean = triangles[triangle].mean.hi;
        let spread = triangles[triangle].directions[0].hi;
        let other = triangles[triangle].directions[1].hi;
        let middle = dot(point.hi, mean) / (dot(mean, mean) + dot(spread, spread) + dot(other, other));
        var unit = 1.0;
        let starts = near_roots(triangle, point, middle, &unit);
        for (var k = 0u; k < starts.count; k++) {
            let start = starts.at[k];
            let plane = polished(triangle, point, exact_sum(vec3f(middle), vec3f(start.x * unit)), unit);
            if plane.holds && is_near(start, minus(plane.t, two(vec3f(middle))).hi.x / unit) {
                roots[k] = root_at(triangle, point, plane.t);
            }
        }
    }
    // In ascending order, the real ones first.
    for (var k = 0; k < 3; k++) {
        let first = select(0, 1, k == 1);
        let second = first + 1;
        let swapped = roots[second].real && (!roots[first].real || roots[second].t < roots[first].t);
        if swapped {
            let kept = roots[first];
            roots[first] = roots[second];
            roots[second] = kept;
        }
    }
    var result = Projections();
    for (var k = 0; k < 3; k++) {
        result.t[k] = roots[k].t;
        result.u[k] = roots[k].u;
        result.v[k] = roots[k].v;
        result.flags |= (u32(roots[k].real) << u32(k)) | (u32(roots[k].valid) << u32(3 + k));
    }
    found[id.x] = result;
}
