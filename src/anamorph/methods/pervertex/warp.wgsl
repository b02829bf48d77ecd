// Looking up a map: where a fragment finds what its ray meets.
// needs: gpu/map.wgsl, gpu/vertices.wgsl
//
// Kakimoto et al. 2007, section 3.4. Beyond the paper: a fragment knows its own ray, and the map knows the world
// position of each of its texels. So the fragment can see how far what it looked up lies from its ray, and step through
// the map towards it.

// Steps that each fragment takes; 0 is the paper's warp.
override REFINEMENTS: i32 = 0;
// 1 where maps have mipmaps.
override MIPMAPS: i32 = 0;
// How many maps show a patch; two where its rays converge. A constant, because software runs what a branch leaves out.
override SIDES: i32 = 1;
// 1 where each patch has six maps around its viewpoint, and lookups are directions from there.
override CUBE: i32 = 0;

const MAP_LEVELS = 5.0;

// A flag of a triangle: the true surface lies off it.
const SMOOTH = 1u;

struct WarpedTriangle {
    // Its number in the scene.
    face: u32,
    flags: u32,
    // Where its own numbers begin in `corner_data`.
    data: u32,
    padding: u32,
}

// The maps of one patch: of converging rays first what lies beyond their crossing, then what lies before it; of a cube
// map its faces, by their numbers.
struct PatchMaps {
    views: array<Projection, 6>,
}

@group(2) @binding(0) var<uniform> maps: PatchMaps;
@group(2) @binding(1) var map_color: texture_2d<f32>;
@group(2) @binding(2) var map_sampler: sampler;
@group(2) @binding(3) var map_depth: texture_2d<f32>;
@group(2) @binding(4) var map_end: texture_2d<f32>;
@group(2) @binding(5) var<storage, read> triangles: array<WarpedTriangle>;
@group(2) @binding(6) var<storage, read> corner_data: array<vec4f>;
@group(2) @binding(7) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(8) var<storage, read> indices: array<u32>;

// A ray that leaves a specular surface; its direction is unit.
struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// A place (0 to 1, y down) in one of the patch's maps.
struct Place {
    view: i32,
    place: vec2f,
}

// What the map shows there, and the angle by which that misses the ray.
struct Lookup {
    at: Place,
    point: vec4f,
    deviation: f32,
}

// The number of a view in the patch. Where only the side counts it is the same for all fragments, which is faster.
fn view_number(at: Place, side: i32) -> i32 {
    return select(side, at.view, CUBE == 1);
}

// Where a side's map shows a point (w: 1) or a direction (w: 0); `otherwise` where it does not.
fn locate(point: vec4f, side: i32, otherwise: Place) -> Place {
    var view = side;
    if CUBE == 1 {
        view = cube_face(point.xyz - point.w * maps.views[0].eye.xyz);
    }
    let clip = maps.views[view_number(Place(view, vec2f(0.0)), side)].clip * point;
    if clip.w <= 0.0 {
        return otherwise;
    }
    return Place(view, clamp(clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5, vec2f(0.0), vec2f(1.0)));
}

// The place that the vertices' lookups give a fragment.
fn start_of(lookup: vec4f) -> Place {
    if CUBE == 1 {
        // A face that is not drawn has no place, and is no place to step from.
        return locate(vec4f(lookup.xyz, 0.0), 0, Place(0, vec2f(-1.0)));
    }
    return Place(0, lookup.xy / lookup.z);
}

// The start's change to the next pixel: on a cube by the angle alone, for places jump from face to face.
fn start_change(start: Place, lookup_change: vec3f, place_change: vec2f) -> vec2f {
    if CUBE == 1 {
        return vec2f(0.5 * length(lookup_change) / length(maps.views[start.view].right.xyz), 0.0);
    }
    return place_change;
}

fn look(at: Place, side: i32, ray: Ray) -> Lookup {
    let view = view_number(at, side);
    let point = map_point(maps.views[view], at.place, textureLoad(map_depth, map_texel(maps.views[view], at.place), 0));
    let toward = select(point.xyz - ray.origin, point.xyz, point.w == 0.0);
    return Lookup(at, point, angle_between(toward, ray.direction));
}

// Where the map shows the point of the ray nearest to what it showed last.
fn step_towards(ray: Ray, last: Lookup, side: i32) -> Place {
    let along = max(dot(last.point.xyz - ray.origin, ray.direction), 0.0);
    let nearest = vec4f(ray.origin + along * ray.direction, 1.0);
    return locate(select(nearest, vec4f(ray.direction, 0.0), last.point.w == 0.0), side, last.at);
}

// The lookup with the least deviation among the start and the steps from it: a step can swing between two surfaces.
fn refine(start: Place, side: i32, ray: Ray) -> Lookup {
    var last = look(Place(max(start.view, side), start.place), side, ray);
    var best = last;
    for (var step = 0; step < REFINEMENTS; step++) {
        last = look(step_towards(ray, last, side), side, ray);
        if last.deviation < best.deviation {
            best = last;
        }
    }
    return best;
}

// Whether what lies before the rays' crossing hides what lies beyond it: it is there, and on this ray, to half of what
// a pixel is wide seen from the ray's origin. The nearer to the mirror, the wider that is.
fn hides(before: Lookup, beyond: Lookup, ray: Ray) -> bool {
    let there = before.point.w != 0.0;
    let nearness = length(ray.origin - projection.eye.xyz) / max(length(before.point.xyz - ray.origin), 1e-12);
    let blur = projection.base.w * max(1.0, 0.5 * nearness);
    return there && (REFINEMENTS == 0 || before.deviation < max(beyond.deviation, blur));
}

fn find(start: Place, ray: Ray) -> Lookup {
    var best = refine(start, 0, ray);
    for (var side = 1; side < SIDES; side++) {
        let before = refine(start, side, ray);
        if hides(before, best, ray) {
            best = before;
        }
    }
    return best;
}

// Whether the map has an answer where the vertices' lookups, and their part of valid ones, lead.
fn inside_map(start: Place, valid: f32) -> bool {
    return valid > 0.9999 && all(start.place >= vec2f(0.0)) && all(start.place <= vec2f(1.0));
}

// The map's colour, and how much of it there is. `dx` and `dy` are the start's change to the next pixel.
fn sampled(at: Place, side: i32, dx: vec2f, dy: vec2f) -> vec4f {
    let size = maps.views[view_number(at, side)].size;
    let whole = vec2f(textureDimensions(map_color));
    var level = 0.0;
    if MIPMAPS == 1 {
        level = clamp(0.5 * log2(max(dot(dx * size.xy, dx * size.xy), dot(dy * size.xy, dy * size.xy))), 0.0, MAP_LEVELS - 1.0);
    }
    // No texel of another map comes in.
    let margin = min(vec2f(0.5 * exp2(ceil(level))), 0.5 * size.xy);
    let texel = size.zw + clamp(at.place * size.xy, margin, size.xy - margin);
    return textureSampleLevel(map_color, map_sampler, texel / whole, level);
}

// The colour that a ray finds.
fn found_color(start: Place, ray: Ray, dx: vec2f, dy: vec2f) -> vec3f {
    if REFINEMENTS == 0 && SIDES == 1 {
        return sampled(start, 0, dx, dy).rgb;
    }
    let beyond = refine(start, 0, ray);
    var color = sampled(beyond.at, 0, dx, dy).rgb;
    for (var side = 1; side < SIDES; side++) {
        let before = refine(start, side, ray);
        // Unrefined, the map's own emptiness says where nothing is: its depth is not even drawn.
        if REFINEMENTS == 0 || hides(before, beyond, ray) {
            let nearer = sampled(before.at, side, dx, dy);
            color = nearer.rgb + (1.0 - nearer.a) * color;
        }
    }
    return color;
}

// Four neighbouring ends lie on one surface where their quadrilateral is all but a parallelogram.
const EVEN = 0.1;

// Where paths end that go on from a mirror in the map: between the texels' centres where these show one surface.
fn map_end_at(seen_by: Projection, place: vec2f) -> vec4f {
    let pixel = place * seen_by.size.xy - 0.5;
    let low = vec2i(clamp(floor(pixel), vec2f(0.0), seen_by.size.xy - 2.0));
    let weight = clamp(pixel - vec2f(low), vec2f(0.0), vec2f(1.0));
    let texel = vec2i(seen_by.size.zw) + low;
    let a = textureLoad(map_end, texel, 0);
    let b = textureLoad(map_end, texel + vec2i(1, 0), 0);
    let c = textureLoad(map_end, texel + vec2i(0, 1), 0);
    let d = textureLoad(map_end, texel + vec2i(1, 1), 0);
    let across = length(b.xyz - a.xyz);
    let along = length(c.xyz - a.xyz);
    if all(vec3f(b.w, c.w, d.w) == vec3f(a.w)) && length(d.xyz - b.xyz - c.xyz + a.xyz) < EVEN * min(across, along) {
        return mix(mix(a, b, weight.x), mix(c, d, weight.x), weight.y);
    }
    return textureLoad(map_end, map_texel(seen_by, place), 0);
}

// The path's end: what is found, or what a mirror shows that is found.
fn end_of(found: Lookup) -> vec4f {
    if is_front(found.point) && textureDimensions(map_end).x > 1u {
        let end = map_end_at(maps.views[found.at.view], found.at.place);
        return select(end, vec4f(normalize(end.xyz), 0.0), end.w == 0.0);
    }
    return found.point;
}

fn warped_status(found: Lookup, start: Place, end: vec4f) -> u32 {
    let moved = any(found.at.place != start.place);
    // At a specular front the path goes on, and no map says where.
    let status = select(select(STATUS_WARPED, STATUS_REFINED, moved), STATUS_SKY, end.w == 0.0);
    return select(status, STATUS_OUTSIDE, is_front(end));
}
