// Points projected into ray triangles: solve.py on the device.
// needs: raytriangle/two_floats.wgsl, raytriangle/cubic.wgsl, raytriangle/weights.wgsl
//
// Where roots lie is found in f32, from a cubic that counts t from where the middle ray passes the point; each is then
// polished in sums of two floats, and so are its weights.

// In scaled units: what is beyond is not projected, because the squares of its coordinates leave the range of f32.
const FARTHEST = 1e17;
// What sums of two floats lose.
const ROUNDING = 2.8e-14;
const POLISHINGS = 12;
// A polished value that is a smaller share of its terms is 0.
const ZERO = 1e-11;
// Roots nearer to each other than this share of the way to them may be one.
const ALIKE = 1e-6;

// One of the `ScaledRays`.
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
    var t = start;
    var off = scaled(from_middle(triangle, point, t), 1.0 / unit);
    var normal = normal_at(triangle, t);
    // Products of unscaled lengths may be out of range.
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
    return Plane(t, abs(value.x) <= ZERO * steepest * farthest);
}

// Near which t's the roots are, scaled.
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
    return cubic_roots(cubic / greatest, clamp(1e18 / wide, 1.0, 1e8));
}

// All the roots of a point, which is given in world units: in ascending order, the real ones first.
fn roots_of(triangle: u32, world: Two) -> array<Root, 3> {
    let size_and_shift = triangles[triangle].size_and_shift;
    let around = minus(world, triangles[triangle].center);
    let point = times(around, Two(size_and_shift.xxx, size_and_shift.yyy));
    var roots = array<Root, 3>(Root(), Root(), Root());
    if triangles[triangle].flat == 0.0 && longest(point.hi) <= FARTHEST {
        let mean = triangles[triangle].mean.hi;
        let spread = triangles[triangle].directions[0].hi;
        let other = triangles[triangle].directions[1].hi;
        let middle = dot(point.hi, mean) / (dot(mean, mean) + dot(spread, spread) + dot(other, other));
        var unit = 1.0;
        var t = array<Two, 3>();
        let starts = near_roots(triangle, point, middle, &unit);
        for (var k = 0u; k < starts.count; k++) {
            let start = starts.at[k];
            let plane = polished(triangle, point, exact_sum(vec3f(middle), vec3f(start.x * unit)), unit);
            t[k] = plane.t;
            // From where the cubic may touch zero, Newton's steps can lead to where it crosses.
            var again = false;
            for (var other = 0u; other < k; other++) {
                let apart = minus(plane.t, t[other]).hi.x;
                again |= !start.crosses && starts.at[other].crosses && abs(apart) <= ALIKE * abs(plane.t.hi.x - middle);
            }
            if plane.holds && !again {
                roots[k] = root_at(triangle, point, plane.t);
            }
        }
    }
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
    return roots;
}

@compute @workgroup_size(64)
fn project(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= block.points * block.triangles {
        return;
    }
    let roots = roots_of(id.x / block.points, points[id.x % block.points]);
    var result = Projections();
    for (var k = 0; k < 3; k++) {
        result.t[k] = roots[k].t;
        result.u[k] = roots[k].u;
        result.v[k] = roots[k].v;
        result.flags |= (u32(roots[k].real) << u32(k)) | (u32(roots[k].valid) << u32(3 + k));
    }
    found[id.x] = result;
}
