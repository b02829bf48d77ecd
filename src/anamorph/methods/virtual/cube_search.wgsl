// The paper's search for where a reflector shows points: `cube_search.py`, in f32.
// Estalella et al. 2005, sections 4.2, 4.3 and 6.1.

const BORDER = 1;
const DIFFERENT = 0.4;
const ALIKE = 0.2;
const LARGEST_STEP = 2.0;
const LEAST_STEP = 0.015625;
const FIRST_STEP = 1.0;
const AGAIN_STEP = 0.25;
const LEAST = 1e-30;
// Of the way to a point, until it is in the reflector or nearest to it.
const CUTS = 16;
// In place of a length.
const UNKNOWN = 3e38;

struct Search {
    // The eye and the world's place of the middle; all else is less that place. Metres.
    eye: vec3f,
    // 1 where the outside reflects, else -1; 0 for a plane through the middle, with the normal of the first texel.
    side: f32,
    center: vec3f,
    // Texels along each side of a face.
    size: i32,
    iterations: u32,
    count: u32,
    // 1 where only points are searched for whose length is UNKNOWN.
    rest: u32,
    // How far the reflector is from its middle at most.
    reach: f32,
    // 1 where searches start from what was found last.
    again: u32,
}

struct MapTexel {
    position: vec3f,
    normal: vec3f,
}

struct Reflected {
    // On the reflector.
    place: vec3f,
    // (1 - B . N) / 2 there.
    error: f32,
    // The virtual point.
    behind: vec3f,
    // Of the path from the eye, metres; negative where the reflector hides the point, 0 of a point inside of it.
    length: f32,
}

@group(0) @binding(0) var<uniform> search: Search;
@group(0) @binding(1) var<storage, read> texels: array<MapTexel>;
@group(0) @binding(2) var<storage, read> points: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> reflected: array<Reflected>;

fn unit(vector: vec3f) -> vec3f {
    return vector / max(length(vector), LEAST);
}

fn rotated(vector: vec3f, axis: i32) -> vec3f {
    return select(select(vector.zxy, vector.yzx, axis == 1), vector, axis == 0);
}

// What the maps show in a direction, between four texels.
fn lookup(direction: vec3f) -> MapTexel {
    let sizes = abs(direction);
    let axis = select(select(2, 1, sizes.y >= sizes.z), 0, sizes.x >= sizes.y && sizes.x >= sizes.z);
    // The face's own axis first, then those of columns and rows.
    let turned = rotated(direction, axis);
    let face = 2 * axis + select(0, 1, turned.x < 0.0);
    let half = 0.5 * f32(search.size);
    let place = half * (turned.yz / max(abs(turned.x), LEAST) + 1.0) - 0.5 + f32(BORDER);
    let corner = clamp(vec2i(place), vec2i(0), vec2i(search.size));
    let share = place - vec2f(corner);
    let wide = search.size + 2 * BORDER;
    let first = (face * wide + corner.y) * wide + corner.x;
    let a = texels[first];
    let b = texels[first + 1];
    let c = texels[first + wide];
    let d = texels[first + wide + 1];
    return MapTexel(
        mix(mix(a.position, b.position, share.x), mix(c.position, d.position, share.x), share.y),
        unit(mix(mix(a.normal, b.normal, share.x), mix(c.normal, d.normal, share.x), share.y)),
    );
}

fn bisector(p: vec3f, point: vec3f) -> vec3f {
    return unit(unit(search.eye - p) + unit(point - p));
}

// The image of a point in the plane through p with unit normal n.
fn mirrored(point: vec3f, p: vec3f, n: vec3f) -> vec3f {
    return point - 2.0 * dot(point - p, n) * n;
}

// B - N at a place, as long as that is far from the middle.
fn toward(found: MapTexel, point: vec3f, hidden: bool) -> vec3f {
    let b = bisector(found.position, select(point, mirrored(point, found.position, found.normal), hidden));
    return search.side * length(found.position) * (b - found.normal);
}

// How far a point is from the middle, where the reflector is 1.
fn depth_in(point: vec3f) -> f32 {
    return length(point) / max(length(lookup(point).position), LEAST);
}

// Whether a convex reflector stands between the eye and a point. Along a line such depths have one minimum.
fn is_hidden(point: vec3f) -> bool {
    let way = point - search.eye;
    let nearest = search.eye + clamp(-dot(search.eye, way) / max(dot(way, way), LEAST), 0.0, 1.0) * way;
    if search.side <= 0.0 || length(nearest) >= search.reach {
        return false;
    }
    var low = 0.0;
    var high = 1.0;
    for (var cut = 0; cut < CUTS && depth_in(search.eye + 0.5 * (low + high) * way) >= 1.0; cut++) {
        let third = (high - low) / 3.0;
        if depth_in(search.eye + (low + third) * way) < depth_in(search.eye + (high - third) * way) {
            high -= third;
        } else {
            low += third;
        }
    }
    let between = 0.5 * (low + high);
    return depth_in(search.eye + between * way) < 1.0;
}

// A plane needs no search.
fn in_plane(point: vec3f) -> Reflected {
    let normal = texels[0].normal;
    let image = mirrored(point, vec3f(0.0), normal);
    let above = dot(search.eye, normal);
    let height = dot(point, normal);
    let share = above / select(above + height, 1.0, above + height == 0.0);
    let path = length(image - search.eye);
    let place = search.center + mix(search.eye, image, share);
    return Reflected(place, 0.0, search.center + image, select(-path, path, height > 0.0));
}

// Whether a point is inside of a convex reflector.
fn is_within(point: vec3f) -> bool {
    return search.side > 0.0 && depth_in(point) < 1.0;
}

@compute @workgroup_size(64)
fn search_points(@builtin(global_invocation_id) number: vec3u) {
    if number.x >= search.count || (search.rest == 1u && reflected[number.x].length != UNKNOWN) {
        return;
    }
    let point = points[number.x].xyz - search.center;
    if search.side == 0.0 {
        reflected[number.x] = in_plane(point);
        return;
    }
    let hidden = is_hidden(point);
    let last = reflected[number.x];
    var step = FIRST_STEP;
    var place = search.side * select(bisector(vec3f(0.0), point), unit(search.eye), hidden);
    if search.again == 1u && last.length != 0.0 && last.length != UNKNOWN && (last.length < 0.0) == hidden {
        place = last.place - search.center;
        step = AGAIN_STEP;
    }
    for (var iteration = 0u; iteration < search.iterations; iteration++) {
        let here = lookup(place);
        let first = toward(here, point, hidden);
        let second = toward(lookup(here.position + 0.5 * step * first), point, hidden);
        let differs = length(second - first) / max(length(first), LEAST);
        place = here.position + step * second;
        if differs > DIFFERENT {
            step = max(0.5 * step, LEAST_STEP);
        } else if differs < ALIKE {
            step = min(1.5 * step, LARGEST_STEP);
        }
    }
    let found = lookup(place);
    let p = found.position;
    let seen = select(point, mirrored(point, p, found.normal), hidden);
    let away = length(p - search.eye);
    let far = length(point - p);
    let behind = select(p + far / max(away, LEAST) * (p - search.eye), seen, hidden);
    reflected[number.x] = Reflected(
        search.center + p,
        0.5 * (1.0 - dot(bisector(p, seen), found.normal)),
        search.center + behind,
        select(select(1.0, -1.0, hidden) * (away + far), 0.0, is_within(point)),
    );
}
