// How high a point is above a toroid or an asphere: zero on the surface, and nearly quadratic along a ray.
// needs: surfaces/numbers.wgsl
//
// Points are given in the surface's own axes (right, up, outward), from its apex. The height is measured by forms in
// which nothing is divided by a curvature: a flat surface is one of curvature zero, and nothing cancels.

struct Height {
    value: f32,
    gradient: vec3f,
    // The second derivative along the ray.
    bend: f32,
    // Whether the point is beside the surface's own sheet: a torus goes on behind where the toroid ends.
    sheet: bool,
}

// The arc along y, at its height above the circle of turning in the plane of x and z.
fn toroid_height(first: u32, p: vec3f, direction: vec3f) -> Height {
    let base = surface_numbers[first];
    let arc = surface_numbers[first + 1u];
    let above = p.z + 0.5 * base * (p.x * p.x + p.z * p.z);
    let lever = sqrt(max(1.0 + 2.0 * base * above, 1e-6));
    let circle = 2.0 * above / (1.0 + lever);
    let outward = vec2f(base * p.x, 1.0 + base * p.z) / lever;
    let change = dot(outward, direction.xz);
    let turning = outward.y * direction.x - outward.x * direction.z;
    let rest = 1.0 + arc * circle;
    return Height(
        circle + 0.5 * arc * (circle * circle + p.y * p.y),
        vec3f(rest * outward.x, arc * p.y, rest * outward.y),
        rest * base / lever * turning * turning + arc * (change * change + direction.y * direction.y),
        rest > 0.0 && outward.y > 0.0,
    );
}

// The conic above which the polynomial leaves the point.
fn asphere_height(first: u32, p: vec3f, direction: vec3f) -> Height {
    let c = surface_numbers[first];
    let conic = c * (1.0 + surface_numbers[first + 1u]);
    let square = dot(p.xy, p.xy);
    // The polynomial over the fourth power of the distance from the axis, and its derivatives by that distance's square.
    var sum = vec3f(0.0);
    for (var power = i32(surface_numbers[first + 2u]) - 1; power >= 0; power--) {
        sum = sum * square + vec3f(0.0, sum.x, 2.0 * sum.y);
        sum.x += surface_numbers[first + 3u + u32(power)];
    }
    let slope = square * (2.0 * sum.x + square * sum.y);
    let curve = 2.0 * sum.x + square * (4.0 * sum.y + square * sum.z);
    let above = p.z + square * square * sum.x;
    let across = dot(p.xy, direction.xy);
    let change = direction.z + 2.0 * slope * across;
    let width = dot(direction.xy, direction.xy);
    let lever = 1.0 + conic * above;
    return Height(
        above + 0.5 * (c * square + conic * above * above),
        vec3f((2.0 * lever * slope + c) * p.xy, lever),
        lever * (2.0 * slope * width + 4.0 * curve * across * across) + conic * change * change + c * width,
        lever > 0.0,
    );
}

fn height(kind: u32, first: u32, point: vec3f, direction: vec3f) -> Height {
    if kind == TOROID {
        return toroid_height(first, point, direction);
    }
    return asphere_height(first, point, direction);
}
