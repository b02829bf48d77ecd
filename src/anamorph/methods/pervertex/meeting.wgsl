// Maps of surfaces as shaders read them, and where a ray meets what their texels show.
// needs: gpu/scene.wgsl, gpu/vertices.wgsl, gpu/triangle_meeting.wgsl, methods/pervertex/map_line.wgsl

// Texels by which rounding may move a plane.
const PLANE_ROUNDING = 0.02;
// A bit of a triangle's number in a map: it is a specular surface, where the path goes on.
const SPECULAR = 0x80000000u;

// A ray that leaves a specular surface; its direction is unit.
struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// What the maps of a patch are: of converging rays first what lies beyond their crossing, then what lies before it.
struct PatchMaps {
    views: array<Projection, 2>,
}

// A triangle of a specular surface.
struct LookingTriangle {
    // Its number in the scene.
    face: u32,
    flags: u32,
    // Which of `unseen` may stand in the way of its rays where no map sees.
    first_unseen: u32,
    unseen_count: u32,
    // So far from its start, and from here to there, `unseen` has all that stands in the way.
    reach: f32,
    gap_start: f32,
    gap_end: f32,
    // No ray of the scene is longer.
    farthest: f32,
}

@group(2) @binding(0) var<uniform> maps: PatchMaps;
// The triangle that a texel sees, from 1, or 0; and the bits of its depth and of the slopes of that.
@group(2) @binding(1) var map_surfaces: texture_2d<u32>;
@group(2) @binding(2) var map_nearest: texture_2d<f32>;
@group(2) @binding(3) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(4) var<storage, read> indices: array<u32>;
@group(2) @binding(5) var<storage, read> looking: array<LookingTriangle>;
@group(2) @binding(6) var<storage, read> unseen: array<u32>;
// By cells between the middles of four texels: how near what none of them shows may be.
@group(2) @binding(7) var map_silhouettes: texture_depth_2d;

struct Hit {
    // From 1; 0 for none. It may have the bit SPECULAR.
    triangle: u32,
    distance: f32,
}

// How far along a ray it meets a triangle of the scene, or FARTHEST.
fn met_triangle(triangle: u32, ray: Ray) -> f32 {
    let first = 3u * (triangle - 1u);
    return met_at(
        position_of(vertices[indices[first]]) - ray.origin,
        position_of(vertices[indices[first + 1u]]) - ray.origin,
        position_of(vertices[indices[first + 2u]]) - ray.origin,
        ray.direction,
    );
}

fn surface_at(view: i32, place: vec2f) -> vec4u {
    let size = maps.views[view].size;
    return textureLoad(map_surfaces, vec2i(size.zw + clamp(floor(place), vec2f(0.0), size.xy - 1.0)), 0);
}

// Where a line meets what a texel shows.
struct PlaneMeeting {
    share: f32,
    // Whether it meets its plane; else this is where the line is as deep as the texel.
    met: bool,
}

fn crosses_plane(line: Line, place: vec2f, surface: vec4u) -> PlaneMeeting {
    let plane = bitcast<vec3f>(surface.yzw);
    let offset = line.start.xy - floor(place) - 0.5;
    let height = line.start.z - plane.x - dot(plane.yz, offset);
    let fall = line.change.z - dot(plane.yz, line.change.xy);
    let share = -height / select(fall, 1.0, fall == 0.0);
    let deep = (plane.x - line.start.z) / select(line.change.z, -1.0, line.change.z == 0.0);
    let met = fall < 0.0 && share >= 0.0 && share <= 1.0;
    return PlaneMeeting(select(deep, share, met), met);
}

// The texel whose middle and those of its three next are around a place of a line.
fn around(line: Line, share: f32, size: vec2f) -> vec2f {
    return clamp(floor((line.start + share * line.change).xy - 0.5), vec2f(0.0), size - 2.0);
}

// What a ray meets in a map, and where.
struct Meeting {
    // As the map has it.
    surface: vec4u,
    distance: f32,
    // Whether the ray meets it, with nothing of what is seen around before it.
    certain: bool,
}

// Where the texels around a place of a line show several triangles: the nearest that the ray meets itself. It is not
// certain where a texel shows what is nearer than the plane that is met, because the last triangles of that may fall
// between texels. `surface` is what `texel` shows, and `distance` where the ray meets its plane: where it meets none of
// the triangles, that is the best guess.
fn meet_at_edge(
    view: i32, line: Line, ray: Ray, share: f32, surface: vec4u, texel: vec2f, distance: f32
) -> Meeting {
    let size = maps.views[view].size.xy;
    let corner = around(line, share, size);
    var met = surface;
    var place = texel;
    var nearest = FARTHEST;
    var tested = 0u;
    for (var number = 0; number < 5; number++) {
        let beside = corner + vec2f(f32(number % 2), f32(number / 2 % 2));
        var shown = surface;
        if number < 4 {
            shown = surface_at(view, beside);
        }
        if shown.x != 0u && shown.x != tested {
            tested = shown.x;
            let other = met_triangle(shown.x & ~SPECULAR, ray);
            if other < nearest {
                nearest = other;
                met = shown;
                place = select(texel, beside, number < 4);
            }
        }
    }
    // Before the sky everything stands that the ray has not yet reached.
    let deepest = vec3f(line.start.z + line.change.z, 0.0, 0.0);
    let plane = select(bitcast<vec3f>(met.yzw), deepest, met.x == 0u);
    let margin = PLANE_ROUNDING * (abs(plane.y) + abs(plane.z)) + 1e-6 * abs(plane.x);
    var certain = nearest < FARTHEST || met.x == 0u;
    for (var number = 0; number < 4; number++) {
        let beside = corner + vec2f(f32(number % 2), f32(number / 2));
        let shown = surface_at(view, beside);
        let expected = plane.x + dot(plane.yz, beside - place);
        certain = certain && (shown.x == met.x || bitcast<f32>(shown.y) <= expected + margin);
    }
    return Meeting(met, select(nearest, distance, nearest == FARTHEST), certain);
}
