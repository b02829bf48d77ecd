// The rays of a converging ray mesh, and what each sees: looked up in the views from its point, and met exactly.
// needs: gpu/scene.wgsl, gpu/vertices.wgsl, gpu/path_end.wgsl, gpu/triangle_meeting.wgsl

// Rows of a matrix on directions: homogeneous texels of the view.
struct Lookup {
    x: vec3f,
    y: vec3f,
    ahead: vec3f,
}

struct RayCorner {
    // In samples of the image, homogeneous.
    place: vec3f,
    // From where the ray leaves to the point of convergence.
    arrow: vec3f,
}

@group(2) @binding(0) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(1) var<storage, read> indices: array<u32>;
@group(2) @binding(2) var<storage, read> corners: array<RayCorner>;
@group(2) @binding(3) var<storage, read> lookups: array<Lookup>;
@group(2) @binding(4) var fields: texture_2d_array<u32>;

struct RayFragment {
    @builtin(position) pixel: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
}

@vertex
fn ray_vertex(@builtin(vertex_index) index: u32) -> RayFragment {
    let place = corners[index].place;
    let x = 2.0 * place.x / projection.size.x - place.z;
    return RayFragment(vec4f(x, place.z - 2.0 * place.y / projection.size.y, 0.5 * place.z, place.z), index / 3u);
}

fn cross_of(a: vec2f, b: vec2f) -> f32 {
    return a.x * b.y - a.y * b.x;
}

// The arrow of a ray triangle at a place in the image. The rasteriser moves corners to a grid, and so its own
// interpolation.
fn arrow_at(triangle: u32, place: vec2f) -> vec3f {
    let a = corners[3u * triangle];
    let b = corners[3u * triangle + 1u];
    let c = corners[3u * triangle + 2u];
    let to_a = a.place.xy / a.place.z - place;
    let to_b = b.place.xy / b.place.z - place;
    let to_c = c.place.xy / c.place.z - place;
    let areas = vec3f(cross_of(to_b, to_c), cross_of(to_c, to_a), cross_of(to_a, to_b));
    let shares = areas / vec3f(a.place.z, b.place.z, c.place.z);
    let whole = shares.x + shares.y + shares.z;
    let weights = select(vec3f(1.0 / 3.0), shares / whole, whole != 0.0);
    return weights.x * a.arrow + weights.y * b.arrow + weights.z * c.arrow;
}

fn view_of(direction: vec3f) -> u32 {
    var best = 0u;
    for (var view = 1u; view < arrayLength(&lookups); view++) {
        if dot(lookups[view].ahead, direction) > dot(lookups[best].ahead, direction) {
            best = view;
        }
    }
    return best;
}

fn met(triangle: u32, origin: vec3f, direction: vec3f) -> f32 {
    let first = 3u * (triangle - 1u);
    let a = position_of(vertices[indices[first]]) - origin;
    let b = position_of(vertices[indices[first + 1u]]) - origin;
    let c = position_of(vertices[indices[first + 2u]]) - origin;
    return met_at(a, b, c, direction);
}

const NONE = 0xFFFFFFFFu;

// The least number after another.
fn after(seen: array<u32, 9>, before: u32) -> u32 {
    var least = NONE;
    for (var number = 0; number < 9; number++) {
        least = select(least, min(least, seen[number]), seen[number] > before);
    }
    return least;
}

@fragment
fn looked_up_along(fragment: RayFragment) -> PackedPathEnd {
    let arrow = arrow_at(fragment.triangle, fragment.pixel.xy);
    let direction = normalize(arrow);
    let origin = projection.eye.xyz - arrow;
    let view = view_of(direction);
    let lookup = lookups[view];
    let place = vec2f(dot(lookup.x, direction), dot(lookup.y, direction)) / dot(lookup.ahead, direction);
    let last = vec2i(textureDimensions(fields)) - 1;
    let middle = clamp(vec2i(floor(place)), vec2i(0), last);
    var seen: array<u32, 9>;
    var sees_sky = false;
    for (var number = 0; number < 9; number++) {
        let texel = clamp(middle + vec2i(number % 3, number / 3) - 1, vec2i(0), last);
        seen[number] = textureLoad(fields, texel, view, 0).x;
        sees_sky |= seen[number] == 0u;
    }
    let straight = seen[4];
    var nearest = FARTHEST;
    var found = 0u;
    // Each triangle once, by its number: in software a branch that is not taken costs as much as one that is.
    var triangle = after(seen, 0u);
    while triangle != NONE {
        let distance = met(triangle, origin, direction);
        if distance < nearest {
            nearest = distance;
            found = triangle;
        }
        triangle = after(seen, triangle);
    }
    var status = STATUS_PROJECTED;
    if found == 0u {
        status = select(STATUS_DOUBTFUL, STATUS_SKY, sees_sky);
        found = select(straight, 0u, sees_sky);
    }
    return packed(PathEnd(origin, found, direction, seen_flags(0u, status), vec3f(1.0)));
}
