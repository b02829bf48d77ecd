// Per-vertex refraction: a lens drawn with the map, for light of one colour or of three in one pass.
// Kakimoto et al. 2007, section 4.5. Follows warp.wgsl.

const THREE_COLORS = 4u;
// What is seen in the glass where no light passes: about the matt edge of a lens.
const EDGE = vec3f(0.14, 0.15, 0.15);

struct RefractorFragment {
    @builtin(position) @invariant pixel: vec4f,
    // Object number and flags.
    @location(0) @interpolate(flat) object: vec2u,
    // (s q, t q, q), and 1 where the map has a place for it.
    @location(1) lookup_green: vec4f,
    // Where the ray leaves the lens, and the share of the light that goes this way.
    @location(2) origin_green: vec4f,
    // Its direction, and how far from the axis it leaves, in radii of the lens.
    @location(3) direction_green: vec4f,
    @location(4) lookup_red: vec4f,
    @location(5) origin_red: vec4f,
    @location(6) direction_red: vec4f,
    @location(7) lookup_blue: vec4f,
    @location(8) origin_blue: vec4f,
    @location(9) direction_blue: vec4f,
}

@vertex
fn refractor_vertex(@builtin(vertex_index) index: u32) -> RefractorFragment {
    let triangle = triangles[index / 3u];
    let corner = index % 3u;
    let vertex = vertices[indices[3u * triangle.face + corner]];
    let colors = select(1u, 3u, (triangle.flags & THREE_COLORS) != 0u);
    let first = triangle.data + 3u * colors * corner;
    let red = first + 3u * min(1u, colors - 1u);
    let blue = first + 3u * min(2u, colors - 1u);
    return RefractorFragment(
        projection.clip * vec4f(position_of(vertex), 1.0),
        vec2u(vertex.object, triangle.flags),
        corner_data[first], corner_data[first + 1u], corner_data[first + 2u],
        corner_data[red], corner_data[red + 1u], corner_data[red + 2u],
        corner_data[blue], corner_data[blue + 1u], corner_data[blue + 2u],
    );
}

fn refraction(origin: vec4f, direction: vec4f) -> Ray {
    return Ray(origin.xyz, normalize(direction.xyz));
}

// Whether the ray leaves by the far face, and not by the edge.
fn leaves(fragment: RefractorFragment) -> bool {
    return fragment.direction_green.w <= 1.0;
}

fn refracted_color(fragment: RefractorFragment) -> vec4f {
    let green = start_of(fragment.lookup_green);
    let dx = dpdx(green.place);
    let dy = dpdy(green.place);
    let tint = objects[fragment.object.x - 1u].tint;
    var color = found_color(green, refraction(fragment.origin_green, fragment.direction_green), dx, dy);
    if (fragment.object.y & THREE_COLORS) != 0u {
        let red = refraction(fragment.origin_red, fragment.direction_red);
        let blue = refraction(fragment.origin_blue, fragment.direction_blue);
        color.r = found_color(start_of(fragment.lookup_red), red, dx, dy).r;
        color.b = found_color(start_of(fragment.lookup_blue), blue, dx, dy).b;
    }
    if !inside_map(green, fragment.lookup_green.w) || !leaves(fragment) {
        return vec4f(EDGE * mix(lighting.ambient_ground, lighting.ambient_sky, 0.5), 1.0);
    }
    return vec4f(fragment.origin_green.w * tint * tint * color, 1.0);
}

@fragment
fn refractor_color(fragment: RefractorFragment) -> @location(0) vec4f {
    return refracted_color(fragment);
}

@fragment
fn refractor_color_and_depth(fragment: RefractorFragment) -> ColorAndDepth {
    let depth = vec4f(fragment.pixel.z, dpdx(fragment.pixel.z), dpdy(fragment.pixel.z), f32(fragment.object.x));
    return ColorAndDepth(refracted_color(fragment), depth);
}

@fragment
fn refractor_end(fragment: RefractorFragment) -> @location(0) vec4f {
    let ray = refraction(fragment.origin_green, fragment.direction_green);
    let start = start_of(fragment.lookup_green);
    let known = inside_map(start, fragment.lookup_green.w) && leaves(fragment);
    return select(vec4f(ray.direction, 0.0), end_of(find(start, ray)), known);
}

@fragment
fn refractor_seen(fragment: RefractorFragment) -> Seen {
    let ray = refraction(fragment.origin_green, fragment.direction_green);
    let start = start_of(fragment.lookup_green);
    if !inside_map(start, fragment.lookup_green.w) || !leaves(fragment) {
        return Seen(vec4f(ray.direction, 0.0), seen_flags(fragment.object.x, STATUS_OUTSIDE), 0.0);
    }
    let found = find(start, ray);
    let end = end_of(found);
    return Seen(end, seen_flags(fragment.object.x, warped_status(found, start, end)), found.deviation);
}
