// Looking up a map: where a fragment finds what its ray meets. Follows vertices.wgsl and map.wgsl.
//
// Kakimoto et al. 2007, section 3.4. Beyond the paper: a fragment knows its own ray, and the map knows the world
// position of each of its texels. So the fragment can see how far what it looked up lies from its ray, and step through
// the map towards it.

// Steps that each fragment takes; 0 is the paper's warp.
override REFINEMENTS: i32 = 0;
// 1 where maps have mipmaps.
override MIPMAPS: i32 = 0;
// 1 where each patch has six maps around its viewpoint, and lookups are directions from there.
override CUBE: i32 = 0;

const MAP_LEVELS = 5.0;

// Flags of a triangle
const SMOOTH = 1u;

struct WarpedTriangle {
    // Its number in the scene.
    face: u32,
    flags: u32,
    // Where its own numbers begin in `corner_data`.
    data: u32,
    padding: u32,
}

// The maps of one patch: of converging rays first what lies beyond their crossing, then what lies before it.
struct PatchMaps {
    views: array<Projection, 6>,
    sides: i32,
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

// The face of a cube map, in the order +x, -x, +y, -y, +z, -z, that a direction meets.
fn cube_face(direction: vec3f) -> i32 {
    let size = abs(direction);
    if size.x >= size.y && size.x >= size.z {
        return select(1, 0, direction.x > 0.0);
    }
    if size.y >= size.z {
        return select(3, 2, direction.y > 0.0);
    }
    return select(5, 4, direction.z > 0.0);
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
        return locate(vec4f(lookup.xyz, 0.0), 0, Place(0, vec2f(0.5)));
    }
    return Place(0, lookup.xy / lookup.z);
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

// Whether what lies before the rays' crossing hides what lies beyond it: it is there, and on this ray.
fn hides(before: Lookup, beyond: Lookup) -> bool {
    let there = before.point.w != 0.0;
    return there && (REFINEMENTS == 0 || before.deviation < max(beyond.deviation, projection.base.w));
}

fn find(start: Place, ray: Ray) -> Lookup {
    var best = refine(start, 0, ray);
    for (var side = 1; side < maps.sides; side++) {
        let before = refine(start, side, ray);
        if hides(before, best) {
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
    if REFINEMENTS == 0 && maps.sides == 1 {
        return sampled(start, 0, dx, dy).rgb;
    }
    let beyond = refine(start, 0, ray);
    var color = sampled(beyond.at, 0, dx, dy).rgb;
    for (var side = 1; side < maps.sides; side++) {
        let before = refine(start, side, ray);
        // Unrefined, the map's own emptiness says where nothing is: its depth is not even drawn.
        if REFINEMENTS == 0 || hides(before, beyond) {
            let nearer = sampled(before.at, side, dx, dy);
            color = nearer.rgb + (1.0 - nearer.a) * color;
        }
    }
    return color;
}

// The path's end: what is found, or what a mirror shows that is found.
fn end_of(found: Lookup) -> vec4f {
    if found.point.w > 0.0 && is_specular(u32(max(found.point.w, 1.0))) && textureDimensions(map_end).x > 1u {
        return textureLoad(map_end, map_texel(maps.views[found.at.view], found.at.place), 0);
    }
    return found.point;
}

fn warped_status(found: Lookup, start: Place, end: vec4f) -> u32 {
    let moved = any(found.at.place != start.place);
    return select(select(STATUS_WARPED, STATUS_REFINED, moved), STATUS_SKY, end.w == 0.0);
}
