// Lines and dots over a picture: each is a capsule in pixels, drawn as the smallest rectangle around it.

struct Stroke {
    // World point, and half the width in logical pixels.
    first: vec4f,
    // World point; a dot's is the same.
    second: vec4f,
    color: vec4f,
}

struct Canvas {
    clip: mat4x4f,
    size: vec2f,
    // Pixels for each logical one.
    ratio: f32,
    unused: f32,
}

@group(0) @binding(0) var<uniform> canvas: Canvas;
@group(0) @binding(1) var<storage, read> strokes: array<Stroke>;

// What is drawn beyond the stroke's own border, in logical pixels; 0 for the stroke itself.
override HALO: f32 = 0.0;
override HALO_ALPHA: f32 = 0.5;
// Whether the target holds sRGB values that it does not make itself.
override ENCODE: bool = false;

struct Fragment {
    @builtin(position) place: vec4f,
    // Both ends in pixels.
    @location(0) @interpolate(flat) ends: vec4f,
    @location(1) @interpolate(flat) color: vec4f,
    @location(2) @interpolate(flat) radius: f32,
}

// The part, from 0 to 1, of a segment on the inside of planes, of which `a` and `b` are the heights of both ends.
fn inside(part: vec2f, a: f32, b: f32) -> vec2f {
    if a < 0.0 && b < 0.0 { return vec2f(1.0, 0.0); }
    if a < 0.0 { return vec2f(max(part.x, a / (a - b)), part.y); }
    if b < 0.0 { return vec2f(part.x, min(part.y, a / (a - b))); }
    return part;
}

fn pixel(point: vec4f, margin: vec2f) -> vec2f {
    let place = clamp(point.xy / max(point.w, 1e-30), -margin, margin);
    return (0.5 + vec2f(0.5, -0.5) * place) * canvas.size;
}

@vertex
fn stroke_vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) number: u32) -> Fragment {
    let stroke = strokes[number];
    let half_width = stroke.first.w * canvas.ratio;
    // A line thinner than a pixel is a fainter one of a pixel.
    let radius = max(half_width, 0.5) + HALO * canvas.ratio;
    let a = canvas.clip * vec4f(stroke.first.xyz, 1.0);
    let b = canvas.clip * vec4f(stroke.second.xyz, 1.0);
    // Clipped before it is divided by w, to a little more than the picture: an end near the plane of the eye would lie
    // farther away than pixels can be told apart.
    let margin = 1.0 + 2.0 * (radius + 2.0) / canvas.size;
    var part = inside(vec2f(0.0, 1.0), a.w - a.z, b.w - b.z);
    part = inside(part, margin.x * a.w + a.x, margin.x * b.w + b.x);
    part = inside(part, margin.x * a.w - a.x, margin.x * b.w - b.x);
    part = inside(part, margin.y * a.w + a.y, margin.y * b.w + b.y);
    part = inside(part, margin.y * a.w - a.y, margin.y * b.w - b.y);
    var fragment: Fragment;
    if part.x > part.y {
        fragment.place = vec4f(2.0, 2.0, 0.0, 1.0);
        return fragment;
    }
    // From the nearer end: what is short beside its distance keeps its digits.
    let first = pixel(select(a + part.x * (b - a), a, part.x == 0.0), margin);
    let second = pixel(select(a + part.y * (b - a), b, part.y == 1.0), margin);
    let way = second - first;
    let far = length(way);
    let along = select(vec2f(1.0, 0.0), way / max(far, 1e-6), far > 1e-6) * (radius + 1.0);
    let end = select(first - along, second + along, corner >= 2u);
    let across = vec2f(-along.y, along.x) * select(-1.0, 1.0, corner % 2u == 1u);
    let place = 2.0 * (end + across) / canvas.size - 1.0;
    fragment.place = vec4f(place.x, -place.y, 0.0, 1.0);
    fragment.ends = vec4f(first, second);
    let alpha = stroke.color.a * min(2.0 * half_width, 1.0);
    fragment.color = select(vec4f(stroke.color.rgb, alpha), vec4f(0.0, 0.0, 0.0, HALO_ALPHA * alpha), HALO > 0.0);
    fragment.radius = radius;
    return fragment;
}

fn encoded(linear: vec3f) -> vec3f {
    let value = clamp(linear, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(value, vec3f(1.0 / 2.4)) - 0.055, 12.92 * value, value <= vec3f(0.0031308));
}

@fragment
fn stroke_color(fragment: Fragment) -> @location(0) vec4f {
    let offset = fragment.place.xy - fragment.ends.xy;
    let way = fragment.ends.zw - fragment.ends.xy;
    let share = clamp(dot(offset, way) / max(dot(way, way), 1e-12), 0.0, 1.0);
    let coverage = clamp(fragment.radius + 0.5 - length(offset - share * way), 0.0, 1.0);
    let alpha = coverage * fragment.color.a;
    let color = select(fragment.color.rgb, encoded(fragment.color.rgb), ENCODE);
    return vec4f(alpha * color, alpha);
}
