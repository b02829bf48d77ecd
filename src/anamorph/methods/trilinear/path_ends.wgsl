// Where the path of each sample ends, as the visibility buffer keeps it.
// needs: gpu/scene.wgsl, methods/trilinear/visibility.wgsl, gpu/path_end.wgsl, gpu/plane.wgsl

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

// 1 where something may stand before the mirror or lens that a sample is on.
override HIDDEN: bool = false;

struct EndFragment {
    @location(0) first: vec4u,
    @location(1) second: vec4u,
    @builtin(frag_depth) depth: f32,
}

@vertex
fn sample_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 1.0);
}

// What goes by a sample: its ray, that of the light before the surface, and what share of the light arrives.
struct SampleRay {
    origin: vec3f,
    direction: vec3f,
    incident: vec3f,
    transmittance: f32,
}

fn ray_of(triangle: RayTriangle, texel: vec2u) -> SampleRay {
    let place = vec2f(texel) - vec2f(triangle.center_x, triangle.center_y);
    let direction = triangle.direction_x * place.x + triangle.direction_y * place.y + triangle.direction_one;
    let origin = triangle.origin_x * place.x + triangle.origin_y * place.y + triangle.origin_one;
    let scale = triangle.scale_x * place.x + triangle.scale_y * place.y + triangle.scale_one;
    let share = triangle.transmittance_x * place.x + triangle.transmittance_y * place.y + triangle.transmittance_one;
    let incident = triangle.incident_x * place.x + triangle.incident_y * place.y + triangle.incident_one;
    // A direction of no length is a ray nowhere.
    let unit = direction * inverseSqrt(max(dot(direction, direction), 1e-30));
    return SampleRay(triangle.anchor + origin / scale, unit, normalize(incident), share / scale);
}

// What share of the light that is seen reaches the eye, by colour.
fn transmitted(triangle: RayTriangle, ray: SampleRay, texel: vec2u) -> vec3f {
    var transmittance = vec3f(1.0);
    if triangle.object > 0u {
        transmittance = mirror_reflectance(triangle.object, 0.5 * length(ray.direction - ray.incident));
        if GLASS && triangle.lens > 0u {
            transmittance = ray.transmittance * lens_tint(triangle.object);
        }
    }
    if FOLLOWS {
        transmittance *= textureLoad(throughput, texel, 0).rgb;
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

// The normal of a triangle at a point of its plane, interpolated.
fn normal_at(face: u32, plane: Plane, point: vec3f) -> vec3f {
    let weights = weights_at(plane, point);
    let a = normal_of(vertices[indices[3u * face]]);
    let b = normal_of(vertices[indices[3u * face + 1u]]);
    let c = normal_of(vertices[indices[3u * face + 2u]]);
    return normalize(weights.x * a + weights.y * b + weights.z * c);
}

fn end_of(triangle: RayTriangle, texel: vec2u) -> PathEnd {
    let flags = triangle.first | (triangle.met * ONE_BOUNCE);
    if triangle.exists == 0u {
        return with_status(PathEnd(vec3f(0.0), 0u, vec3f(0.0), flags, vec3f(0.0)), STATUS_OUTSIDE);
    }
    let ray = ray_of(triangle, texel);
    let seen = textureLoad(triangles_seen, texel, 0).x;
    var end = PathEnd(ray.origin, seen & ~SPECULAR, ray.direction, flags, transmitted(triangle, ray, texel));
    if IN_GLASS {
        let lens = lenses[triangle.lens - 1u];
        let by_edge = length(from_axis(lens, ray.origin)) > lens.radius;
        let surface = triangle_plane(triangle.face);
        let entry = meeting(surface, projection.eye.xyz, ray.incident);
        if by_edge || (triangle.inner & TOTAL) > 0u {
            if by_edge {
                // The ray in the glass, which would have left the far face beyond the edge.
                end.flags -= ONE_BOUNCE;
                end.origin = entry;
                end.direction = normalize(ray.origin - entry);
            }
            let normal = normal_at(triangle.face, surface, entry);
            end.throughput = glass_transmittance(triangle.object, dot(ray.incident, normal));
            return with_status(at_edge(lens, end), select(STATUS_TOTAL_REFLECTION, STATUS_PROJECTED, by_edge));
        }
        if (triangle.inner & ENDS) > 0u {
            // As if nothing followed, from where the eye's ray meets the lens.
            end.flags -= ONE_BOUNCE;
            end.triangle = triangle.face + 1u;
            end.origin = entry;
            return with_status(end, STATUS_OUTSIDE);
        }
    }
    if STRAIGHT && end.triangle > 0u {
        let weights = textureLoad(weights_seen, texel, 0).xy;
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

@fragment
fn path_ended(@builtin(position) pixel: vec4f) -> EndFragment {
    let texel = vec2u(pixel.xy);
    let owner = textureLoad(owners, texel, 0).x;
    if owner >= NOBODY {
        discard;
    }
    let triangle = ray_triangles[owner];
    if IN_GLASS != (triangle.inner > 0u) {
        discard;
    }
    let end = packed(end_of(triangle, texel));
    return EndFragment(end.first, end.second, select(0.0, textureLoad(depths, texel, 0).x, HIDDEN));
}

// For the rays that go on from specular fronts.
@fragment
fn throughput_there(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let texel = vec2u(pixel.xy);
    let owner = textureLoad(owners, texel, 0).x;
    if owner >= NOBODY || (textureLoad(triangles_seen, texel, 0).x & SPECULAR) == 0u {
        discard;
    }
    let triangle = ray_triangles[owner];
    return vec4f(transmitted(triangle, ray_of(triangle, texel), texel), 1.0);
}
