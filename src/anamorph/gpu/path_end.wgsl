// What a method leaves for each pixel of a specular surface: the end of its light path.
// Source: Burns and Hunt, "The visibility buffer" (2013). Deviation: the record also holds the ray, because behind a
// mirror or a lens the pixel's place does not tell it.

// The end of a light path.
struct PathEnd {
    // Of the path's last ray.
    origin: vec3f,
    // From 1; 0 for the sky.
    triangle: u32,
    // Unit.
    direction: vec3f,
    // The first specular object in the low 16 bits, the status in the next 8, and bounces in the high 8.
    flags: u32,
    // What share of the light at the end of the path arrives, by colour.
    throughput: vec3f,
}

// A path's end as two texels hold it. The first has origin and triangle. The second has the direction, as a place on an
// octahedron of 24 bits a side, the flags, and the throughput as half floats: red above the direction, green and blue last.
struct PackedPathEnd {
    @location(0) first: vec4u,
    @location(1) second: vec4u,
}

const PLACES = 16777215.0;
const LARGEST_SHARE = 65504.0;
const LEAST_NORMAL_HALF = 6.103515625e-5;

// The bits of a half float, rounded to the nearest, and of two to the even: devices may round their own otherwise.
fn half_bits(share: f32) -> u32 {
    let bits = bitcast<u32>(share);
    let normal = (bits + 0xFFFu + ((bits >> 13u) & 1u) - (112u << 23u)) >> 13u;
    return select(normal, u32(round(share * 16777216.0)), share < LEAST_NORMAL_HALF);
}

fn signs(place: vec2f) -> vec2f {
    return select(vec2f(-1.0), vec2f(1.0), place >= vec2f(0.0));
}

fn octahedron(direction: vec3f) -> vec2f {
    let size = max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-30);
    let place = direction.xy / size;
    return select(place, (1.0 - abs(place.yx)) * signs(place), direction.z < 0.0);
}

fn on_octahedron(place: vec2f) -> vec3f {
    let height = 1.0 - abs(place.x) - abs(place.y);
    return normalize(vec3f(select(place, (1.0 - abs(place.yx)) * signs(place), height < 0.0), height));
}

// For the two targets of a pass that fills the visibility buffer.
fn packed(end: PathEnd) -> PackedPathEnd {
    let place = vec2u(round((0.5 + 0.5 * octahedron(end.direction)) * PLACES));
    let share = clamp(end.throughput, vec3f(0.0), vec3f(LARGEST_SHARE));
    let red = half_bits(share.x);
    return PackedPathEnd(
        vec4u(bitcast<vec3u>(end.origin), end.triangle),
        vec4u(place | vec2u(red << 24u, (red >> 8u) << 24u), end.flags, half_bits(share.y) | (half_bits(share.z) << 16u)),
    );
}

fn unpacked(first: vec4u, second: vec4u) -> PathEnd {
    let place = vec2f(second.xy & vec2u(0xFFFFFFu)) / PLACES * 2.0 - 1.0;
    let red = unpack2x16float((second.x >> 24u) | ((second.y >> 24u) << 8u)).x;
    return PathEnd(
        bitcast<vec3f>(first.xyz), first.w, on_octahedron(place), second.z, vec3f(red, unpack2x16float(second.w))
    );
}

// Whether nothing has been found for a pixel, not even the sky.
fn is_empty(end: PathEnd) -> bool {
    return end.triangle == 0u && end.flags == 0u;
}

fn status_of(end: PathEnd) -> u32 {
    return (end.flags >> 16u) & 0xFFu;
}

// Whether any light arrives: not in pixels without a ray.
fn arrives(end: PathEnd) -> bool {
    return any(end.throughput > vec3f(0.0));
}
