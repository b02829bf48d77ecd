// Where the path of each sample ends, as the visibility buffer keeps it.
// needs: methods/trilinear/visibility.wgsl, gpu/path_end.wgsl, gpu/plane.wgsl

// 1 where what lies between projected corners is interpolated, as in the thesis.
override STRAIGHT: bool = false;
// 1 where some ray triangles are on lenses.
override GLASS: bool = false;
// 1 to draw the ray triangles of which something keeps light in the glass, 0 for the others: software runs for every
// sample what a branch leaves out.
override IN_GLASS: bool = false;
// 1 where the rays are sent on by what others see.
override FOLLOWS: bool = false;

// In the flags of a path's end.
const ONE_BOUNCE = 0x1000000u;

struct RayFragment {
    @builtin(position) @invariant pixel: vec4f,
    // Of the ray triangle, as functions of the place; behind them three terms each of the scale and the share, and the
    // center.
    @location(0) @interpolate(flat) direction_x: vec4f,
    @location(1) @interpolate(flat) direction_y: vec4f,
    @location(2) @interpolate(flat) direction_one: vec4f,
    @location(3) @interpolate(flat) origin_x: vec4f,
    @location(4) @interpolate(flat) origin_y: vec4f,
    @location(5) @interpolate(flat) origin_one: vec4f,
    @location(6) @interpolate(flat) anchor: vec4f,
    @location(7) @interpolate(flat) incident_x: vec4f,
    @location(8) @interpolate(flat) incident_y: vec3f,
    @location(9) @interpolate(flat) incident_one: vec3f,
    // The object number, the ray triangle's own, the lens, and what keeps light from going through it.
    @location(10) @interpolate(flat) numbers: vec4u,
    // The flags of a path's end, without its status; and the triangle of the scene.
    @location(11) @interpolate(flat) path: vec2u,
    @location(12) normal: vec3f,
}

fn ray_fragment(clip: vec4f, triangle: RayTriangle, corner: u32) -> RayFragment {
    return RayFragment(
        // A triangle of no extent is not drawn.
        select(vec4f(0.0, 0.0, 0.0, 1.0), clip, IN_GLASS == (triangle.inner > 0u)),
        vec4f(triangle.direction_x, triangle.scale_x),
        vec4f(triangle.direction_y, triangle.scale_y),
        vec4f(triangle.direction_one, triangle.scale_one),
        vec4f(triangle.origin_x, triangle.center_x),
        vec4f(triangle.origin_y, triangle.center_y),
        vec4f(triangle.origin_one, triangle.transmittance_x),
        vec4f(triangle.anchor, triangle.transmittance_y),
        vec4f(triangle.incident_x, triangle.transmittance_one),
        triangle.incident_y,
        triangle.incident_one,
        vec4u(triangle.object, triangle.number, triangle.lens, triangle.inner),
        vec2u(triangle.first | (triangle.met * ONE_BOUNCE), triangle.face),
        normal_of(vertices[indices[3u * triangle.face + corner]]),
    );
}

@vertex
fn surface_ray_vertex(@builtin(vertex_index) index: u32) -> RayFragment {
    let triangle = ray_triangles[index / 3u];
    return ray_fragment(surface_clip(triangle, index % 3u), triangle, index % 3u);
}

@vertex
fn bare_ray_vertex(@builtin(vertex_index) index: u32) -> RayFragment {
    let triangle = ray_triangles[index / 3u];
    return ray_fragment(bare_clip(triangle, index % 3u), triangle, index % 3u);
}

// What goes by a sample: its ray, that of the light before the surface, and what share of the light arrives.
struct SampleRay {
    origin: vec3f,
    direction: vec3f,
    incident: vec3f,
    transmittance: f32,
}

fn ray_of(fragment: RayFragment) -> SampleRay {
    let place = PIXEL * fragment.pixel.xy - vec2f(fragment.origin_x.w, fragment.origin_y.w);
    let direction = fragment.direction_x * place.x + fragment.direction_y * place.y + fragment.direction_one;
    let origin = fragment.origin_x.xyz * place.x + fragment.origin_y.xyz * place.y + fragment.origin_one.xyz;
    let transmittance = fragment.origin_one.w * place.x + fragment.anchor.w * place.y + fragment.incident_x.w;
    let incident = fragment.incident_x.xyz * place.x + fragment.incident_y * place.y + fragment.incident_one;
    // A direction of no length is a ray nowhere.
    let unit = direction.xyz * inverseSqrt(max(dot(direction.xyz, direction.xyz), 1e-30));
    return SampleRay(
        fragment.anchor.xyz + origin / direction.w, unit, normalize(incident), transmittance / direction.w
    );
}

// What share of the light that is seen reaches the eye, by colour.
fn transmitted(fragment: RayFragment, ray: SampleRay) -> vec3f {
    var transmittance = vec3f(1.0);
    if fragment.numbers.x > 0u {
        transmittance = mirror_reflectance(fragment.numbers.x, 0.5 * length(ray.direction - ray.incident));
        if GLASS && fragment.numbers.z > 0u {
            transmittance = ray.transmittance * lens_tint(fragment.numbers.x);
        }
    }
    if FOLLOWS {
        transmittance *= textureLoad(throughput, vec2u(fragment.pixel.xy), 0).rgb;
    }
    return transmittance;
}

fn triangle_plane(face: u32) -> Plane {
    return plane_of(
        position_of(vertices[indices[3u * face]]),
        position_of(vertices[indices[3u * face + 1u]]),
        position_of(vertices[indices[3u * face + 2u]]),
    );
}

fn from_axis(lens: Lens, point: vec3f) -> vec3f {
    let offset = point - lens.middle;
    return offset - dot(offset, lens.axis) * lens.axis;
}

// A path in the glass that ends at the lens's edge. Nothing arrives where that has no mesh.
fn at_edge(lens: Lens, end: PathEnd) -> PathEnd {
    var found = end;
    found.triangle = 0u;
    // Between corners of which some leave by the far face, a ray may miss the edge by a little.
    var most = -1e30;
    for (var face = lens.first_face; face < lens.stop_face && most < 0.0; face++) {
        let plane = triangle_plane(face);
        let point = meeting(plane, end.origin, end.direction);
        let weights = weights_at(plane, point);
        let least = min(weights.x, min(weights.y, weights.z));
        if least > most && dot(from_axis(lens, point), end.direction) > 0.0 {
            most = least;
            found.triangle = face + 1u;
        }
    }
    if found.triangle == 0u {
        found.throughput = vec3f(0.0);
    }
    return found;
}

fn with_status(end: PathEnd, status: u32) -> PathEnd {
    var told = end;
    told.flags |= status << 16u;
    return told;
}

fn end_of(fragment: RayFragment) -> PathEnd {
    if fragment.numbers.y == 0u {
        return with_status(PathEnd(vec3f(0.0), 0u, vec3f(0.0), fragment.path.x, vec3f(0.0)), STATUS_OUTSIDE);
    }
    let ray = ray_of(fragment);
    let seen = textureLoad(triangles_seen, vec2u(fragment.pixel.xy), 0).x;
    var end = PathEnd(ray.origin, seen & ~SPECULAR, ray.direction, fragment.path.x, transmitted(fragment, ray));
    if IN_GLASS {
        let lens = lenses[fragment.numbers.z - 1u];
        let by_edge = length(from_axis(lens, ray.origin)) > lens.radius;
        let entry = meeting(triangle_plane(fragment.path.y), projection.eye.xyz, ray.incident);
        if by_edge || (fragment.numbers.w & TOTAL) > 0u {
            if by_edge {
                // The ray in the glass, which would have left the far face beyond the edge.
                end.flags -= ONE_BOUNCE;
                end.origin = entry;
                end.direction = normalize(ray.origin - entry);
            }
            end.throughput = glass_transmittance(fragment.numbers.x, dot(ray.incident, normalize(fragment.normal)));
            return with_status(at_edge(lens, end), select(STATUS_TOTAL_REFLECTION, STATUS_PROJECTED, by_edge));
        }
        if (fragment.numbers.w & ENDS) > 0u {
            // As if nothing followed, from where the eye's ray meets the lens.
            end.flags -= ONE_BOUNCE;
            end.triangle = fragment.path.y + 1u;
            end.origin = entry;
            return with_status(end, STATUS_OUTSIDE);
        }
    }
    if STRAIGHT && end.triangle > 0u {
        let weights = textureLoad(weights_seen, vec2u(fragment.pixel.xy), 0).xy;
        let a = position_of(vertices[indices[3u * end.triangle - 3u]]);
        let b = position_of(vertices[indices[3u * end.triangle - 2u]]);
        let c = position_of(vertices[indices[3u * end.triangle - 1u]]);
        let way = a + weights.x * (b - a) + weights.y * (c - a) - ray.origin;
        end.direction = select(ray.direction, normalize(way), dot(way, way) > 0.0);
    }
    let known = select(STATUS_PROJECTED, STATUS_SKY, end.triangle == 0u);
    // Until what follows is written over it.
    return with_status(end, select(known, STATUS_OUTSIDE, (seen & SPECULAR) != 0u));
}

// Whether a fragment's sample is its ray triangle's: another surface may stand before it.
fn is_own(fragment: RayFragment) -> bool {
    return textureLoad(owners, vec2u(fragment.pixel.xy), 0).x == fragment.numbers.y;
}

@fragment
fn path_ended(fragment: RayFragment) -> PackedPathEnd {
    if !is_own(fragment) {
        discard;
    }
    return packed(end_of(fragment));
}

// For the rays that go on from specular fronts.
@fragment
fn throughput_there(fragment: RayFragment) -> @location(0) vec4f {
    let seen = textureLoad(triangles_seen, vec2u(fragment.pixel.xy), 0).x;
    if !is_own(fragment) || (seen & SPECULAR) == 0u {
        discard;
    }
    return vec4f(transmitted(fragment, ray_of(fragment)), 1.0);
}
