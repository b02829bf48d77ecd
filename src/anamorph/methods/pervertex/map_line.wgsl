// A ray as a map shows it: a straight line, along which depth is linear.

// A ray's line in a map, in texels of the map and depth, and what tells how far along the ray a place of it is.
struct Line {
    start: vec3f,
    change: vec3f,
    // Along the ray.
    first: f32,
    length: f32,
    start_weight: f32,
    end_weight: f32,
}

fn in_texels(clip: vec4f, size: vec2f) -> vec3f {
    let place = clip.xyz / clip.w;
    return vec3f((place.xy * vec2f(0.5, -0.5) + 0.5) * size, place.z);
}

// How far along the ray the place at a share of its line is.
fn along_ray(line: Line, share: f32) -> f32 {
    let part = share * line.start_weight;
    return line.first + part * line.length / max((1.0 - share) * line.end_weight + part, 1e-30);
}

// The share of the line at which the ray is so far along.
fn share_at(line: Line, distance: f32) -> f32 {
    let part = (distance - line.first) * line.end_weight;
    return part / max((line.length - (distance - line.first)) * line.start_weight + part, 1e-30);
}

// The shares of a line at which it enters and leaves the rectangle from 0 to `size`.
fn within(line: Line, size: vec2f) -> vec2f {
    let still = abs(line.change.xy) < vec2f(1e-6);
    let change = select(line.change.xy, vec2f(1.0), still);
    let one = select(-line.start.xy / change, vec2f(-1e9), still);
    let other = select((size - line.start.xy) / change, vec2f(1e9), still);
    let outside = any(still & ((line.start.xy < vec2f(0.0)) | (line.start.xy > size)));
    let enters = max(max(min(one.x, other.x), min(one.y, other.y)), 0.0);
    let leaves = min(min(max(one.x, other.x), max(one.y, other.y)), 1.0);
    return vec2f(enters, select(leaves, -1.0, outside));
}
