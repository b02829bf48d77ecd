// Lines and dots over an image: each is a capsule in pixels, drawn as the smallest rectangle around it.

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

// How far the dark rim reaches beyond the stroke, in logical pixels.
override HALO: f32 = 0.0;
override HALO_ALPHA: f32 = 0.5;
// Whether the target holds sRGB values that it does not make itself.
override ENCODE: bool = false;

struct Fragment {
    @builtin(position) place: vec4f,
    // Pixels along the stroke from its middle, and across.
    @location(0) @interpolate(linear) local: vec2f,
    // Multiplied by its alpha.
    @location(1) @interpolate(flat) color: vec4f,
    // Half the stroke's length, of its width, and the alpha of its rim.
    @location(2) @interpolate(flat) kind: vec3f,
}

// The part, from 0 to 1, of a segment on the inside of planes, of which `a` and `b` are the heights of both ends.
fn inside(part: vec2f, a: f32, b: f32) -> vec2f {
    if a < 0.0 && b < 0.0 { return vec2f(1.0, 0.0); }
    if a < 0.0 { return vec2f(max(part.x, a / (a - b)), part.y); }
    if b < 0.0 { return vec2f(part.x, min(part.y, a / (a - b))); }
    return part;
}

// How far a clip point lies before the eye, less what rounding may make of that.
fn depth(world: vec3f, clipped: vec4f) -> f32 {
    let row = vec4f(canvas.clip[0].w, canvas.clip[1].w, canvas.clip[2].w, canvas.clip[3].w);
    return clipped.w - 1e-5 * dot(abs(row), vec4f(abs(world), 1.0)) - 1e-20;
}

fn pixel(point: vec4f, margin: vec2f) -> vec2f {
    let place = clamp(point.xy / max(point.w, 1e-30), -margin, margin);
    return (0.5 + vec2f(0.5, -0.5) * place) * canvas.size;
}

fn encoded(linear: vec3f) -> vec3f {
    let value = clamp(linear, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(value, vec3f(1.0 / 2.4)) - 0.055, 12.92 * value, value <= vec3f(0.0031308));
}

@vertex
fn stroke_vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) number: u32) -> Fragment {
    let stroke = strokes[number];
    let half_width = stroke.first.w * canvas.ratio;
    // A line thinner than a pixel is a fainter one of a pixel.
    let radius = max(half_width, 0.5);
    let reach = radius + HALO * canvas.ratio + 0.5;
    let a = canvas.clip * vec4f(stroke.first.xyz, 1.0);
    let b = canvas.clip * vec4f(stroke.second.xyz, 1.0);
    // Clipped before it is divided by w, to a little more than the image: an end near the plane of the eye would lie
    // farther away than pixels can be told apart.
    let margin = 1.0 + 2.0 * (reach + 1.0) / canvas.size;
    var part = inside(vec2f(0.0, 1.0), depth(stroke.first.xyz, a), depth(stroke.second.xyz, b));
    part = inside(part, margin.x * a.w + a.x, margin.x * b.w + b.x);
    part = inside(part, margin.x * a.w - a.x, margin.x * b.w - b.x);
    part = inside(part, margin.y * a.w + a.y, margin.y * b.w + b.y);
    part = inside(part, margin.y * a.w - a.y, margin.y * b.w - b.y);
    var fragment: Fragment;
    if part.x > part.y {
        fragment.place = vec4f(2.0, 2.0, 0.0, 1.0);
        return fragment;
    }
    // Ends that are not clipped stay exactly where they are.
    let first = pixel(select(a + part.x * (b - a), a, part.x == 0.0), margin);
    let second = pixel(select(a + part.y * (b - a), b, part.y == 1.0), margin);
    let way = second - first;
    let far = length(way);
    let along = select(vec2f(1.0, 0.0), way / max(far, 1e-6), far > 1e-6);
    let sides = vec2f(select(-1.0, 1.0, corner >= 2u), select(-1.0, 1.0, corner % 2u == 1u));
    fragment.local = sides * vec2f(0.5 * far + reach, reach);
    let pixels = 0.5 * (first + second) + fragment.local.x * along + fragment.local.y * vec2f(-along.y, along.x);
    let place = 2.0 * pixels / canvas.size - 1.0;
    fragment.place = vec4f(place.x, -place.y, 0.0, 1.0);
    let alpha = stroke.color.a * min(2.0 * half_width, 1.0);
    let color = select(stroke.color.rgb, encoded(stroke.color.rgb), ENCODE);
    fragment.color = vec4f(alpha * color, alpha);
    // What shines through hardly has a rim: it would be all that is seen of it.
    fragment.kind = vec3f(0.5 * far, radius + 0.5, select(0.0, HALO_ALPHA * alpha * alpha, HALO > 0.0));
    return fragment;
}

@fragment
fn stroke_color(fragment: Fragment) -> @location(0) vec4f {
    let away = length(vec2f(max(abs(fragment.local.x) - fragment.kind.x, 0.0), fragment.local.y));
    let color = clamp(fragment.kind.y - away, 0.0, 1.0) * fragment.color;
    let rim = clamp(fragment.kind.y + HALO * canvas.ratio - away, 0.0, 1.0) * fragment.kind.z;
    return color + vec4f(0.0, 0.0, 0.0, (1.0 - color.a) * rim);
}
