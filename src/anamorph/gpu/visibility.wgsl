// The one pass that colours what each pixel of a specular surface sees.
// needs: gpu/scene.wgsl, gpu/vertices.wgsl, gpu/path_end.wgsl, gpu/plane.wgsl

// Of one line of the spectrum: see LINE.
@group(2) @binding(0) var first_texels: texture_2d<u32>;
@group(2) @binding(1) var second_texels: texture_2d<u32>;
@group(2) @binding(2) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(3) var<storage, read> indices: array<u32>;

// Samples along each side of a pixel.
override SIDE: i32 = 1;

// 1 where nothing else is drawn. Where a ray mesh is shifted, samples on the image's rim have no ray, and look like their
// pixel's others: black would come in from beyond the image.
override ALONE: bool = false;

// 1 for green light, or all of it: 0 for red and blue, which only some samples of a pixel may have of their own.
override FIRST: bool = true;

// The angle between neighbouring rays is the pixel's footprint only where they take the same way: bounces and first
// specular object.
const WAY = 0xFF00FFFFu;
// The first specular object.
const OBJECT = 0xFFFFu;

fn path_end(texel: vec2i) -> PathEnd {
    return unpacked(textureLoad(first_texels, texel, 0), textureLoad(second_texels, texel, 0));
}

// The path of a pixel beside, by `step`, if it takes the same way: its ray is then this pixel's footprint. The way back
// serves where the way on leads elsewhere.
fn beside(texel: vec2i, step: vec2i, end: PathEnd) -> PathEnd {
    let size = vec2i(textureDimensions(first_texels));
    let on = path_end(min(texel + step, size - 1));
    let back = path_end(max(texel - step, vec2i(0)));
    let goes_on = (on.flags & WAY) == (end.flags & WAY) && !is_empty(on) && any(texel + step < size);
    let goes_back = (back.flags & WAY) == (end.flags & WAY) && !is_empty(back);
    if goes_on && any(on.direction != end.direction) {
        return on;
    }
    if goes_back {
        return back;
    }
    return end;
}

fn corner_of(triangle: u32, corner: u32) -> StoredVertex {
    return vertices[indices[3u * (triangle - 1u) + corner]];
}

// A ray as far from another as two rays of one way are.
fn moved(end: PathEnd, from_end: PathEnd, to_end: PathEnd) -> PathEnd {
    var other = end;
    other.origin += to_end.origin - from_end.origin;
    other.direction += to_end.direction - from_end.direction;
    return other;
}

// The colour of a path like that of a sample: of this itself, or of the mean of several.
fn seen_color(texel: vec2i, sample: PathEnd, end: PathEnd) -> vec3f {
    let right = moved(end, sample, beside(texel, vec2i(SIDE, 0), sample));
    let down = moved(end, sample, beside(texel, vec2i(0, SIDE), sample));
    // A path that has met too many specular surfaces goes on as if nothing followed.
    if end.triangle == 0u || status_of(end) == STATUS_OUTSIDE {
        let spread = max(length(right.direction - end.direction), length(down.direction - end.direction));
        return end.throughput * sky_color(end.direction, spread);
    }
    let a = corner_of(end.triangle, 0u);
    let b = corner_of(end.triangle, 1u);
    let c = corner_of(end.triangle, 2u);
    let plane = plane_of(position_of(a), position_of(b), position_of(c));
    let texcoords = mat3x2f(texcoord_of(a), texcoord_of(b), texcoord_of(c));
    var point: SurfacePoint;
    point.position = meeting(plane, end.origin, end.direction);
    let weights = weights_at(plane, point.position);
    let beside_right = weights_at(plane, meeting(plane, right.origin, right.direction));
    let beside_down = weights_at(plane, meeting(plane, down.origin, down.direction));
    point.texcoord = texcoords * weights;
    point.texcoord_dx = clamp(texcoords * (beside_right - weights), vec2f(-4.0), vec2f(4.0));
    point.texcoord_dy = clamp(texcoords * (beside_down - weights), vec2f(-4.0), vec2f(4.0));
    point.normal = normalize(mat3x3f(normal_of(a), normal_of(b), normal_of(c)) * weights);
    point.color = mat3x3f(color_of(a), color_of(b), color_of(c)) * weights;
    point.object = a.object;
    return end.throughput * shade(point, end.direction);
}

// Nearest of all: what is drawn after it leaves these pixels alone.
@vertex
fn found_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 1.0);
}

@fragment
fn found_color(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let texel = vec2i(pixel.xy);
    let end = path_end(texel);
    if is_empty(end) {
        discard;
    }
    if !arrives(end) {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    return vec4f(seen_color(texel, end, end), 1.0);
}

struct SampledColor {
    @location(0) color: vec4f,
    @builtin(sample_mask) samples: u32,
}

// Whether a sample has an end that this pass colours: with other meshes in the image, one behind a specular surface.
fn is_colored(end: PathEnd) -> bool {
    return !is_empty(end) && (ALONE || (end.flags & OBJECT) != 0u);
}

// A sample that sees a specular surface, of a pixel or next to it; beyond the textures if there is none. An image's
// own samples lie elsewhere in the pixel, and may be the only ones that see the surface.
fn sample_near(corner: vec2i) -> vec2i {
    let last = vec2i(textureDimensions(first_texels)) - 1;
    for (var number = 0; number < SIDE * SIDE; number++) {
        let texel = corner + vec2i(number % SIDE, number / SIDE);
        if (textureLoad(second_texels, texel, 0).z & OBJECT) != 0u {
            return texel;
        }
    }
    let wide = SIDE + 2;
    for (var number = 0; number < wide * wide; number++) {
        let texel = clamp(corner - 1 + vec2i(number % wide, number / wide), vec2i(0), last);
        if (textureLoad(second_texels, texel, 0).z & OBJECT) != 0u {
            return texel;
        }
    }
    return last + 1;
}

fn is_sample(texel: vec2i) -> bool {
    return all(texel < vec2i(textureDimensions(first_texels)));
}

// Of specular meshes only the depth is drawn, in the image's own samples.
@fragment
fn no_color(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    if !is_sample(sample_near(vec2i(pixel.xy) * SIDE)) {
        discard;
    }
    return vec4f(0.0);
}

// With several samples a pixel, each triangle that some see on one way is coloured once, where they see it in the mean.
@fragment
fn found_color_of_samples(@builtin(position) pixel: vec4f) -> SampledColor {
    let corner = vec2i(pixel.xy) * SIDE;
    var found = 0u;
    var colored = 0u;
    var color = vec3f(0.0);
    for (var number = 0; number < SIDE * SIDE; number++) {
        let texel = corner + vec2i(number % SIDE, number / SIDE);
        let sample = path_end(texel);
        if !is_colored(sample) {
            continue;
        }
        found |= 1u << u32(number);
        if (colored & (1u << u32(number))) != 0u {
            continue;
        }
        var mean = sample;
        var count = 1.0;
        for (var other = number + 1; other < SIDE * SIDE; other++) {
            let like = path_end(corner + vec2i(other % SIDE, other / SIDE));
            if like.triangle == sample.triangle && (like.flags & WAY) == (sample.flags & WAY) && !is_empty(like) {
                colored |= 1u << u32(other);
                mean.origin += like.origin;
                mean.direction += like.direction;
                mean.throughput += like.throughput;
                count += 1.0;
            }
        }
        mean.origin /= count;
        mean.direction = normalize(mean.direction);
        mean.throughput /= count;
        if arrives(mean) {
            color += count * seen_color(texel, sample, mean);
        }
    }
    if found == 0u {
        let texel = sample_near(corner);
        if ALONE || !is_sample(texel) {
            discard;
        }
        let near = path_end(texel);
        return SampledColor(vec4f(select(vec3f(0.0), seen_color(texel, near, near), arrives(near)), 1.0), 15u);
    }
    let last = vec2i(textureDimensions(first_texels)) - SIDE;
    let on_rim = any(corner == vec2i(0)) || any(corner == last);
    return SampledColor(vec4f(color / f32(countOneBits(found)), 1.0), select(15u, found, !FIRST || (ALONE && !on_rim)));
}

@fragment
fn found_seen(@builtin(position) pixel: vec4f) -> Seen {
    let end = path_end(vec2i(pixel.xy));
    if is_empty(end) {
        discard;
    }
    let flags = end.flags & 0xFFFFFFu;
    if end.triangle == 0u {
        return Seen(vec4f(select(vec3f(0.0), end.direction, arrives(end)), 0.0), flags, 0.0);
    }
    let a = corner_of(end.triangle, 0u);
    let plane = plane_of(position_of(a), position_of(corner_of(end.triangle, 1u)), position_of(corner_of(end.triangle, 2u)));
    return Seen(vec4f(meeting(plane, end.origin, end.direction), f32(a.object)), flags, 0.0);
}
