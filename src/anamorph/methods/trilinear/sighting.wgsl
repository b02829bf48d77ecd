// What a pixel's ray is, and the point of the scene that it sees.
// needs: methods/trilinear/visibility.wgsl

// 1 where what lies between projected corners is interpolated, as in the thesis.
override STRAIGHT: bool = false;
// 1 to draw all ray triangles at no depth. There the depth of what is seen decides: above it are surfaces, at it the sky.
override LEVEL: bool = false;

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
    // The first specular surface on the way from the eye.
    @location(11) @interpolate(flat) first: u32,
    @location(12) normal: vec3f,
}

fn ray_fragment(clip: vec4f, triangle: RayTriangle, corner: u32) -> RayFragment {
    return RayFragment(
        vec4f(clip.xy, select(clip.z, 0.0, LEVEL), clip.w),
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
        triangle.first,
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

struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// What a ray is and what it meets; the rays of the pixels to the right and below tell its footprint.
struct Sighting {
    // From 1; 0 for the sky.
    triangle: u32,
    specular: bool,
    ray: Ray,
    right: Ray,
    down: Ray,
    // Of the light along the ray.
    transmittance: f32,
}

fn place_of(fragment: RayFragment) -> vec2f {
    return fragment.pixel.xy - vec2f(fragment.origin_x.w, fragment.origin_y.w);
}

fn ray_at(fragment: RayFragment, place: vec2f) -> Ray {
    let direction = fragment.direction_x * place.x + fragment.direction_y * place.y + fragment.direction_one;
    let origin = fragment.origin_x.xyz * place.x + fragment.origin_y.xyz * place.y + fragment.origin_one.xyz;
    // A direction of no length is a ray nowhere.
    let length = inverseSqrt(max(dot(direction.xyz, direction.xyz), 1e-30));
    return Ray(fragment.anchor.xyz + origin / direction.w, direction.xyz * length);
}

// Whether a fragment's pixel is its ray triangle's: another surface may stand before it.
fn is_own(fragment: RayFragment) -> bool {
    let owner = textureLoad(owners, vec2u(fragment.pixel.xy), 0).x;
    return owner == fragment.numbers.y && owner > 0u;
}

fn sighting(fragment: RayFragment, place: vec2f, seen: u32) -> Sighting {
    let scale = fragment.direction_x.w * place.x + fragment.direction_y.w * place.y + fragment.direction_one.w;
    let transmittance = fragment.origin_one.w * place.x + fragment.anchor.w * place.y + fragment.incident_x.w;
    return Sighting(
        seen & ~SPECULAR,
        (seen & SPECULAR) != 0u,
        ray_at(fragment, place),
        ray_at(fragment, place + vec2f(1.0, 0.0)),
        ray_at(fragment, place + vec2f(0.0, 1.0)),
        transmittance / scale,
    );
}

fn pixel_sighting(fragment: RayFragment) -> Sighting {
    return sighting(fragment, place_of(fragment), textureLoad(triangles_seen, vec2u(fragment.pixel.xy), 0).x);
}

fn sighted_sky(sighting: Sighting) -> vec3f {
    let direction = sighting.ray.direction;
    let spread = max(length(sighting.right.direction - direction), length(sighting.down.direction - direction));
    return sky_color(direction, spread);
}

// A triangle's plane: weights of its second and third corner at a point, and the normal, not unit.
struct Plane {
    corner: vec3f,
    normal: vec3f,
    second: vec3f,
    third: vec3f,
}

fn plane_of(a: vec3f, b: vec3f, c: vec3f) -> Plane {
    let normal = cross(b - a, c - a);
    let square = max(dot(normal, normal), 1e-36);
    return Plane(a, normal, cross(c - a, normal) / square, cross(normal, b - a) / square);
}

fn meeting(plane: Plane, ray: Ray) -> vec3f {
    let slant = dot(plane.normal, ray.direction);
    // A footprint's ray may run along the plane.
    let limit = 1e-6 * length(plane.normal);
    let along = dot(plane.normal, plane.corner - ray.origin) / select(slant, limit, abs(slant) < limit);
    return ray.origin + along * ray.direction;
}

fn weights_at(plane: Plane, point: vec3f) -> vec3f {
    let offset = point - plane.corner;
    let weights = vec2f(dot(offset, plane.second), dot(offset, plane.third));
    return vec3f(1.0 - weights.x - weights.y, weights);
}

fn point_seen(sighting: Sighting, texel: vec2u) -> SurfacePoint {
    let first = 3u * (sighting.triangle - 1u);
    let a = vertices[indices[first]];
    let b = vertices[indices[first + 1u]];
    let c = vertices[indices[first + 2u]];
    let plane = plane_of(position_of(a), position_of(b), position_of(c));
    let corners = mat3x3f(position_of(a), position_of(b), position_of(c));
    let texcoords = mat3x2f(texcoord_of(a), texcoord_of(b), texcoord_of(c));
    var point: SurfacePoint;
    point.position = meeting(plane, sighting.ray);
    var weights = weights_at(plane, point.position);
    point.texcoord_dx = clamp(texcoords * (weights_at(plane, meeting(plane, sighting.right)) - weights), vec2f(-4.0), vec2f(4.0));
    point.texcoord_dy = clamp(texcoords * (weights_at(plane, meeting(plane, sighting.down)) - weights), vec2f(-4.0), vec2f(4.0));
    if STRAIGHT {
        let found = textureLoad(weights_seen, texel, 0).xy;
        weights = vec3f(1.0 - found.x - found.y, found);
        point.position = corners * weights;
    }
    point.normal = normalize(mat3x3f(normal_of(a), normal_of(b), normal_of(c)) * weights);
    point.texcoord = texcoords * weights;
    point.color = mat3x3f(color_of(a), color_of(b), color_of(c)) * weights;
    point.object = a.object;
    return point;
}
