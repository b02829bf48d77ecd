// What a ray meets, found in a map of surfaces: which triangle each texel sees, and its plane.
// needs: methods/pervertex/meeting.wgsl
//
// The ray's image in the map is a straight line, along which its depth is linear. From its far end on, the planes that
// the texels show are met one after the other until the texel there shows the one that was met; then the ray itself
// meets that triangle. So a hit is exact. It is proved to be the first one where a pyramid of what is nearest shows
// nothing before the ray, all the way to the hit.

// How many maps show a patch: two where its rays converge.
override SIDES: i32 = 1;

// Levels of the pyramid, of cells of 2, 4, ... 32 texels: maps begin at multiples of the largest.
const LEVELS = 5;
const PLANES = 4;
const CLEARINGS = 10;
// Of 1, in depth: what is nearer by less is as near.
const DEPTH_ROUNDING = 4e-7;

// Whether nothing stands before a ray between two shares of its line, but for what is seen at the last texel.
fn is_clear(view: i32, line: Line, from_share: f32, to_share: f32) -> bool {
    let size = maps.views[view].size;
    // No more at once than two of the largest cells always hold, and less where that is not clear.
    var most = f32(1 << u32(LEVELS)) / max(max(abs(line.change.x), abs(line.change.y)), 1e-6);
    let steepness = select(line.change.z, -1e-30, line.change.z == 0.0);
    var share = from_share;
    var done = false;
    for (var number = 0; number < CLEARINGS; number++) {
        let next = min(share + most, to_share);
        let here = clamp((line.start + share * line.change).xy, vec2f(0.0), size.xy - 0.01);
        let there = clamp((line.start + next * line.change).xy, vec2f(0.0), size.xy - 0.01);
        let span = max(abs(here.x - there.x), abs(here.y - there.y));
        let level = clamp(i32(ceil(log2(max(span, 1.0)))), 1, LEVELS);
        let cell = f32(1 << u32(level));
        let low = vec2i((size.zw + min(here, there)) / cell);
        let high = vec2i((size.zw + max(here, there)) / cell);
        let nearest = max(
            max(textureLoad(map_nearest, low, level - 1).x, textureLoad(map_nearest, high, level - 1).x),
            max(
                textureLoad(map_nearest, vec2i(low.x, high.y), level - 1).x,
                textureLoad(map_nearest, vec2i(high.x, low.y), level - 1).x
            ),
        );
        let depth = line.start.z + next * line.change.z;
        let clear = nearest < depth - DEPTH_ROUNDING * abs(depth);
        // Half a texel from the hit, all that is seen is among the four texels that were looked at there.
        done = done || (next >= to_share && (clear || (span < 0.5 && all(floor(here - 0.5) == floor(there - 0.5)))));
        let reached = clamp((nearest - line.start.z) / steepness, share, next);
        share = select(reached, next, clear || nearest == 0.0);
        most = select(0.25 * most, most, clear);
        if done {
            break;
        }
    }
    return done;
}

struct Found {
    hit: Hit,
    // Whether it is certain that nothing nearer was missed.
    proved: bool,
}

// The nearest thing that a map shows on a ray, from `first` to `last` along it.
fn search(view: i32, ray: Ray, first: f32, last: f32, known: Hit, triangle: LookingTriangle) -> Found {
    let size = maps.views[view].size.xy;
    let origin = maps.views[view].clip * vec4f(ray.origin, 1.0);
    let change = maps.views[view].clip * vec4f(ray.direction, 0.0);
    // From the near plane on, on which depth is 1, ...
    let near_height = origin.z - origin.w;
    let near_slope = change.z - change.w;
    let near = select(0.0, -near_height / select(near_slope, 1.0, near_slope == 0.0), near_height > 0.0);
    let from_here = max(first, near);
    // ... and only as far as the view goes.
    let least = 1e-3 * abs(origin.w + from_here * change.w);
    let narrow = (least - origin.w) / select(change.w, 1.0, change.w == 0.0);
    let to_here = select(last, min(last, narrow), change.w < 0.0);
    let start = origin + from_here * change;
    let end = origin + to_here * change;
    if (near_height > 0.0 && near_slope >= 0.0) || start.w <= 0.0 || !(to_here > from_here) {
        return Found(known, false);
    }
    let place = in_texels(start, size);
    let line = Line(place, in_texels(end, size) - place, from_here, to_here - from_here, start.w, end.w);
    let shares = within(line, size);
    let entered = along_ray(line, shares.x);
    let listed = entered <= triangle.reach || (entered >= triangle.gap_start && entered <= triangle.gap_end);
    let whole = (shares.x <= 0.0 && from_here <= first) || listed;
    if shares.y <= shares.x {
        return Found(known, whole && to_here >= last && known.triangle > 0u);
    }

    var share = shares.y;
    var place_seen = (line.start + share * line.change).xy;
    var surface = surface_at(view, place_seen);
    var met_plane = false;
    for (var number = 0; number < PLANES; number++) {
        if surface.x == 0u {
            break;
        }
        let crossing = crosses_plane(line, place_seen, surface);
        share = clamp(crossing.share, shares.x, shares.y);
        met_plane = crossing.met && share == crossing.share;
        let there = (line.start + share * line.change).xy;
        let shown = surface_at(view, there);
        // At an edge, what was met last is as good as the sky.
        if shown.x == surface.x || shown.x == 0u {
            break;
        }
        surface = shown;
        place_seen = there;
        met_plane = false;
    }
    var proved = whole;
    var hit = known;
    var met = Meeting(surface, along_ray(line, share), true);
    let corner = around(line, share, size);
    let alike = vec4u(
        surface_at(view, corner).x,
        surface_at(view, corner + vec2f(1.0, 0.0)).x,
        surface_at(view, corner + vec2f(0.0, 1.0)).x,
        surface_at(view, corner + vec2f(1.0, 1.0)).x,
    ) == vec4u(surface.x);
    // Between texels that all show one triangle, the ray meets that. Else it is the ray itself that tells.
    if !all(alike) || (!met_plane && surface.x != 0u) {
        met = meet_at_edge(view, line, ray, share, surface, floor(place_seen), met.distance);
    }
    proved = proved && met.certain;
    if met.surface.x == 0u {
        proved = proved && shares.y >= 1.0 && to_here >= last;
    } else if met.distance < hit.distance {
        hit = Hit(met.surface.x, met.distance);
    }
    let to_share = min(select(1.0, share_at(line, hit.distance), hit.triangle > 0u), shares.y);
    proved = proved && is_clear(view, line, shares.x, to_share);
    let cell = vec2i(maps.views[view].size.zw + around(line, to_share, size));
    let depth = max(line.start.z + to_share * line.change.z, 0.0);
    proved = proved && textureLoad(map_silhouettes, cell, 0) <= depth + DEPTH_ROUNDING * abs(depth);
    return Found(hit, proved);
}

// What a ray of a looking triangle meets.
fn find(ray: Ray, triangle: LookingTriangle) -> Found {
    var known = Hit(0u, FARTHEST);
    for (var number = 0u; number < triangle.unseen_count; number++) {
        let other = unseen[triangle.first_unseen + number];
        let distance = met_triangle(other & ~SPECULAR, ray);
        if distance < known.distance {
            known = Hit(other, distance);
        }
    }
    if SIDES == 1 {
        return search(0, ray, 0.0, triangle.farthest, known, triangle);
    }
    let before = search(1, ray, 0.0, triangle.gap_start, known, triangle);
    let beyond = search(0, ray, triangle.gap_end, triangle.farthest, before.hit, triangle);
    let settled = before.hit.triangle > 0u && before.hit.distance < triangle.gap_end;
    return Found(beyond.hit, before.proved && (settled || beyond.proved));
}
