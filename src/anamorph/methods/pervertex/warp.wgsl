// Looking up a map: where a fragment finds what its ray meets.
// needs: gpu/map.wgsl, gpu/vertices.wgsl
//
// Kakimoto et al. 2007, section 3.4. Beyond the paper: a fragment knows its own ray, and the map knows the world
// position of each of its texels. So the fragment can see how far what it looked up lies from its ray.

// How many maps show a patch; two where its rays converge. A constant, because software runs what a branch leaves out.
override SIDES: i32 = 1;
// 1 where each patch has six maps around its viewpoint, and lookups are directions from there.
override CUBE: i32 = 0;

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
struct WarpMaps {
    views: array<Projection, 6>,
}

@group(2) @binding(0) var<uniform> maps: WarpMaps;
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

// The place that the vertices' lookups give a fragment.
fn start_of(lookup: vec4f) -> Place {
    if CUBE == 0 {
        return Place(0, lookup.xy / lookup.z);
    }
    let view = cube_face(lookup.xyz);
    let clip = maps.views[view].clip * vec4f(lookup.xyz, 0.0);
    let place = clamp(clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5, vec2f(0.0), vec2f(1.0));
    // A face that is not drawn has no place.
    return Place(view, select(vec2f(-1.0), place, clip.w > 0.0));
}

fn look(at: Place, ray: Ray) -> Lookup {
    let seen_by = maps.views[at.view];
    let point = map_point(seen_by, at.place, textureLoad(map_depth, map_texel(seen_by, at.place), 0));
    let toward = select(point.xyz - ray.origin, point.xyz, point.w == 0.0);
    return Lookup(at, point, angle_between(toward, ray.direction));
}

// What lies before the rays' crossing hides what lies beyond it.
fn find(start: Place, ray: Ray) -> Lookup {
    if SIDES == 2 {
        let before = look(Place(1, start.place), ray);
        if before.point.w != 0.0 {
            return before;
        }
    }
    return look(start, ray);
}

// Whether the map has an answer where the vertices' lookups, and their part of valid ones, lead.
fn inside_map(start: Place, valid: f32) -> bool {
    return valid > 0.9999 && all(start.place >= vec2f(0.0)) && all(start.place <= vec2f(1.0));
}

// The map's colour, and how much of it there is.
fn sampled(at: Place) -> vec4f {
    let size = maps.views[at.view].size;
    // No texel of another map comes in.
    let margin = min(vec2f(0.5), 0.5 * size.xy);
    let texel = size.zw + clamp(at.place * size.xy, margin, size.xy - margin);
    return textureSampleLevel(map_color, map_sampler, texel / vec2f(textureDimensions(map_color)), 0.0);
}

fn found_color(start: Place) -> vec3f {
    let beyond = sampled(start).rgb;
    if SIDES == 1 {
        return beyond;
    }
    // The map's own emptiness says where nothing is: its depth is not even drawn.
    let before = sampled(Place(1, start.place));
    return before.rgb + (1.0 - before.a) * beyond;
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

fn warped_status(end: vec4f) -> u32 {
    // At a specular front the path goes on, and no map says where.
    return select(select(STATUS_WARPED, STATUS_SKY, end.w == 0.0), STATUS_OUTSIDE, is_front(end));
}
