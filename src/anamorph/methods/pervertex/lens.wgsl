// Per-vertex refraction: a lens drawn with the map, for light of one colour or of three in one pass.
// needs: methods/pervertex/warp.wgsl
// Kakimoto et al. 2007, section 4.5.

// A flag of a triangle: it has lookups and rays for green, red and blue.
const THREE_COLORS = 4u;

// Another: the path ends at the lens.
const ENDS = 8u;

struct RefractorFragment {
    @builtin(position) @invariant pixel: vec4f,
    // Object number and flags.
    @location(0) @interpolate(flat) object: vec2u,
    // (s q, t q, q), and 1 where the map has a place for it.
    @location(1) lookup_green: vec4f,
    // Where the ray leaves the lens, and the share of the light that goes this way.
    @location(2) origin_green: vec4f,
    // Its direction, and 1 where reflection in the glass is total.
    @location(3) direction_green: vec4f,
    @location(4) lookup_red: vec4f,
    @location(5) origin_red: vec4f,
    @location(6) direction_red: vec4f,
    @location(7) lookup_blue: vec4f,
    @location(8) origin_blue: vec4f,
    @location(9) direction_blue: vec4f,
    // The middle of the far face's border, and the object number of the edge.
    @location(10) @interpolate(flat) middle: vec4f,
    // The lens's axis, and its radius.
    @location(11) @interpolate(flat) axis: vec4f,
    @location(12) normal: vec3f,
}

@vertex
fn refractor_vertex(@builtin(vertex_index) index: u32) -> RefractorFragment {
    let triangle = triangles[index / 3u];
    let corner = index % 3u;
    let vertex = vertices[indices[3u * triangle.face + corner]];
    let colors = select(1u, 3u, (triangle.flags & THREE_COLORS) != 0u);
    let first = triangle.data + 2u + 3u * colors * corner;
    let red = first + 3u * min(1u, colors - 1u);
    let blue = first + 3u * min(2u, colors - 1u);
    return RefractorFragment(
        projection.clip * vec4f(position_of(vertex), 1.0),
        vec2u(vertex.object, triangle.flags),
        corner_data[first], corner_data[first + 1u], corner_data[first + 2u],
        corner_data[red], corner_data[red + 1u], corner_data[red + 2u],
        corner_data[blue], corner_data[blue + 1u], corner_data[blue + 2u],
        corner_data[triangle.data], corner_data[triangle.data + 1u],
        normal_of(vertex),
    );
}

fn refraction(origin: vec4f, direction: vec4f) -> Ray {
    return Ray(origin.xyz, normalize(direction.xyz));
}

// What becomes of a ray in the glass.
const LEAVES = 0u;
const LEFT_BY_EDGE = 1u;
const TOTAL = 2u;
const LOST = 3u;
const ENDED = 4u;

fn from_axis(fragment: RefractorFragment) -> vec3f {
    let offset = fragment.origin_green.xyz - fragment.middle.xyz;
    return offset - dot(offset, fragment.axis.xyz) * fragment.axis.xyz;
}

fn way_of(fragment: RefractorFragment, start: Place) -> u32 {
    if length(from_axis(fragment)) > fragment.axis.w {
        return LEFT_BY_EDGE;
    }
    if (fragment.object.y & ENDS) != 0u {
        return ENDED;
    }
    if fragment.direction_green.w > 0.0 {
        return TOTAL;
    }
    return select(LOST, LEAVES, inside_map(start, fragment.lookup_green.w));
}

// The diffuse edge, seen from within the glass.
fn edge_color(fragment: RefractorFragment) -> vec3f {
    var point: SurfacePoint;
    point.position = fragment.origin_green.xyz;
    point.normal = normalize(from_axis(fragment));
    point.color = vec3f(1.0);
    point.object = u32(max(fragment.middle.w, 1.0));
    return select(vec3f(0.0), shade(point, fragment.direction_green.xyz), fragment.middle.w > 0.0);
}

fn refracted_color(fragment: RefractorFragment) -> vec4f {
    let green = start_of(fragment.lookup_green);
    let towards = normalize(fragment.lookup_green.xyz);
    let dx = start_change(green, dpdx(towards), dpdx(green.place));
    let dy = start_change(green, dpdy(towards), dpdy(green.place));
    var color = found_color(green, refraction(fragment.origin_green, fragment.direction_green), dx, dy);
    if (fragment.object.y & THREE_COLORS) != 0u {
        let red = refraction(fragment.origin_red, fragment.direction_red);
        let blue = refraction(fragment.origin_blue, fragment.direction_blue);
        color.r = found_color(start_of(fragment.lookup_red), red, dx, dy).r;
        color.b = found_color(start_of(fragment.lookup_blue), blue, dx, dy).b;
    }
    let way = way_of(fragment, green);
    if way == LEFT_BY_EDGE || way == TOTAL {
        let cosine = dot(normalize(viewing_direction(fragment.pixel.xy)), normalize(fragment.normal));
        return vec4f(glass_transmittance(fragment.object.x, cosine) * edge_color(fragment), 1.0);
    } else if way == LOST || way == ENDED {
        color = sky_color(fragment.direction_green.xyz, projection.base.w);
    }
    return vec4f(fragment.origin_green.w * lens_tint(fragment.object.x) * color, 1.0);
}

@fragment
fn refractor_color(fragment: RefractorFragment) -> @location(0) vec4f {
    return refracted_color(fragment);
}

@fragment
fn refractor_color_and_depth(fragment: RefractorFragment) -> ColorAndDepth {
    let depth = depth_and_slopes(fragment.pixel, fragment.object.x) + FRONT;
    return ColorAndDepth(refracted_color(fragment), depth);
}

// Where a fragment's path ends, and how it was found.
struct Refracted {
    end: vec4f,
    status: u32,
    deviation: f32,
}

fn refracted(fragment: RefractorFragment) -> Refracted {
    let ray = refraction(fragment.origin_green, fragment.direction_green);
    let start = start_of(fragment.lookup_green);
    let edge = vec4f(ray.origin, fragment.middle.w);
    switch way_of(fragment, start) {
        case LEFT_BY_EDGE: { return Refracted(edge, STATUS_WARPED, 0.0); }
        case TOTAL: { return Refracted(edge, STATUS_TOTAL_REFLECTION, 0.0); }
        case LOST: { return Refracted(vec4f(ray.direction, 0.0), STATUS_OUTSIDE, 0.0); }
        case ENDED: { return Refracted(vec4f(ray.origin, f32(fragment.object.x)) + FRONT, STATUS_OUTSIDE, 0.0); }
        default: {}
    }
    let found = find(start, ray);
    let end = end_of(found);
    return Refracted(end, warped_status(found, start, end), found.deviation);
}

@fragment
fn refractor_depth(fragment: RefractorFragment) -> @location(0) vec4f {
    return depth_and_slopes(fragment.pixel, fragment.object.x) + FRONT;
}

@fragment
fn refractor_end(fragment: RefractorFragment) -> @location(0) vec4f {
    return refracted(fragment).end;
}

@fragment
fn refractor_seen(fragment: RefractorFragment) -> Seen {
    let seen = refracted(fragment);
    return Seen(seen.end, seen_flags(fragment.object.x, seen.status), seen.deviation);
}
