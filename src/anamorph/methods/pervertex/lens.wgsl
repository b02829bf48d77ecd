// Per-vertex refraction: a lens drawn with the map, for light of one colour or of three in one pass.
// needs: methods/pervertex/warp.wgsl
// Kakimoto et al. 2007, section 4.5.

// A flag of a triangle: it has lookups for green, red and blue.
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
    @location(2) origin: vec4f,
    // Its direction, and 1 where reflection in the glass is total.
    @location(3) direction: vec4f,
    @location(4) lookup_red: vec4f,
    @location(5) lookup_blue: vec4f,
    // The middle of the far face's border, and the object number of the edge.
    @location(6) @interpolate(flat) middle: vec4f,
    // The lens's axis, and its radius.
    @location(7) @interpolate(flat) axis: vec4f,
    @location(8) normal: vec3f,
}

@vertex
fn refractor_vertex(@builtin(vertex_index) index: u32) -> RefractorFragment {
    let triangle = triangles[index / 3u];
    let corner = index % 3u;
    let vertex = vertices[indices[3u * triangle.face + corner]];
    let colors = select(1u, 3u, (triangle.flags & THREE_COLORS) != 0u);
    let first = triangle.data + 2u + (colors + 2u) * corner;
    return RefractorFragment(
        projection.clip * vec4f(position_of(vertex), 1.0),
        vec2u(vertex.object, triangle.flags),
        corner_data[first], corner_data[first + colors], corner_data[first + colors + 1u],
        corner_data[first + min(1u, colors - 1u)], corner_data[first + min(2u, colors - 1u)],
        corner_data[triangle.data], corner_data[triangle.data + 1u],
        normal_of(vertex),
    );
}

fn refraction(fragment: RefractorFragment) -> Ray {
    return Ray(fragment.origin.xyz, normalize(fragment.direction.xyz));
}

// What becomes of a ray in the glass.
const LEAVES = 0u;
const LEFT_BY_EDGE = 1u;
const TOTAL = 2u;
const LOST = 3u;
const ENDED = 4u;

fn from_axis(fragment: RefractorFragment) -> vec3f {
    let offset = fragment.origin.xyz - fragment.middle.xyz;
    return offset - dot(offset, fragment.axis.xyz) * fragment.axis.xyz;
}

fn way_of(fragment: RefractorFragment, start: Place) -> u32 {
    if length(from_axis(fragment)) > fragment.axis.w {
        return LEFT_BY_EDGE;
    }
    if (fragment.object.y & ENDS) != 0u {
        return ENDED;
    }
    if fragment.direction.w > 0.0 {
        return TOTAL;
    }
    return select(LOST, LEAVES, inside_map(start, fragment.lookup_green.w));
}

// The diffuse edge, seen from within the glass.
fn edge_color(fragment: RefractorFragment) -> vec3f {
    var point: SurfacePoint;
    point.position = fragment.origin.xyz;
    point.normal = normalize(from_axis(fragment));
    point.color = vec3f(1.0);
    point.object = u32(max(fragment.middle.w, 1.0));
    return select(vec3f(0.0), shade(point, fragment.direction.xyz), fragment.middle.w > 0.0);
}

fn refracted_color(fragment: RefractorFragment) -> vec4f {
    let green = start_of(fragment.lookup_green);
    var color = found_color(green);
    if (fragment.object.y & THREE_COLORS) != 0u {
        color.r = found_color(start_of(fragment.lookup_red)).r;
        color.b = found_color(start_of(fragment.lookup_blue)).b;
    }
    let way = way_of(fragment, green);
    if way == LEFT_BY_EDGE || way == TOTAL {
        let cosine = dot(normalize(viewing_direction(fragment.pixel.xy)), normalize(fragment.normal));
        return vec4f(glass_transmittance(fragment.object.x, cosine) * edge_color(fragment), 1.0);
    } else if way == LOST || way == ENDED {
        color = sky_color(fragment.direction.xyz, projection.base.w);
    }
    return vec4f(fragment.origin.w * lens_tint(fragment.object.x) * color, 1.0);
}

@fragment
fn refractor_color(fragment: RefractorFragment) -> @location(0) vec4f {
    return refracted_color(fragment);
}

// Where a fragment's path ends, and how it was found.
struct Refracted {
    end: vec4f,
    status: u32,
    deviation: f32,
}

fn refracted(fragment: RefractorFragment) -> Refracted {
    let ray = refraction(fragment);
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
    return Refracted(end, warped_status(end), found.deviation);
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
