// Trilinear projection: what the rays of a picture's ray triangles see, coloured. Follows visibility.wgsl.

// The scene triangle that each pixel sees, from 1, and whether it is the front of a specular surface; 0 for the sky.
@group(3) @binding(1) var triangles_seen: texture_2d<u32>;

struct RayFragment {
    @builtin(position) @invariant pixel: vec4f,
    // Of the ray triangle, as functions of the place; last come the scale's three terms, the center, and two numbers.
    @location(0) @interpolate(flat) direction_x: vec4f,
    @location(1) @interpolate(flat) direction_y: vec4f,
    @location(2) @interpolate(flat) direction_one: vec4f,
    @location(3) @interpolate(flat) origin_x: vec4f,
    @location(4) @interpolate(flat) origin_y: vec4f,
    @location(5) @interpolate(flat) origin_one: vec3f,
    @location(6) @interpolate(flat) anchor: vec3f,
    // Object number, and 1 where there are rays.
    @location(7) @interpolate(flat) object: vec2u,
}

fn ray_fragment(clip: vec4f, triangle: RayTriangle) -> RayFragment {
    return RayFragment(
        clip,
        vec4f(triangle.direction_x, triangle.scale_x),
        vec4f(triangle.direction_y, triangle.scale_y),
        vec4f(triangle.direction_one, triangle.scale_one),
        vec4f(triangle.origin_x, triangle.center_x),
        vec4f(triangle.origin_y, triangle.center_y),
        triangle.origin_one,
        triangle.anchor,
        vec2u(triangle.object, triangle.valid),
    );
}

@vertex
fn surface_ray_vertex(@builtin(vertex_index) index: u32) -> RayFragment {
    let triangle = ray_triangles[index / 3u];
    return ray_fragment(surface_clip(triangle, index % 3u), triangle);
}

@vertex
fn bare_ray_vertex(@builtin(vertex_index) index: u32) -> RayFragment {
    let triangle = ray_triangles[index / 3u];
    return ray_fragment(bare_clip(triangle, index % 3u), triangle);
}

struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// What a pixel's ray is and what it meets; the rays of the pixels to the right and below tell its footprint.
struct Sighting {
    exists: bool,
    // From 1; 0 for the sky.
    triangle: u32,
    specular: bool,
    ray: Ray,
    right: Ray,
    down: Ray,
}

fn ray_at(fragment: RayFragment, place: vec2f) -> Ray {
    let direction = fragment.direction_x * place.x + fragment.direction_y * place.y + fragment.direction_one;
    let origin = fragment.origin_x.xyz * place.x + fragment.origin_y.xyz * place.y + fragment.origin_one;
    // A direction of no length is a ray nowhere.
    let length = inverseSqrt(max(dot(direction.xyz, direction.xyz), 1e-30));
    return Ray(fragment.anchor + origin / direction.w, direction.xyz * length);
}

fn sighting_at(fragment: RayFragment) -> Sighting {
    let seen = textureLoad(triangles_seen, vec2u(fragment.pixel.xy), 0).x;
    let place = fragment.pixel.xy - vec2f(fragment.origin_x.w, fragment.origin_y.w);
    return Sighting(
        fragment.object.y == 1u,
        seen & ~SPECULAR,
        (seen & SPECULAR) != 0u,
        ray_at(fragment, place),
        ray_at(fragment, place + vec2f(1.0, 0.0)),
        ray_at(fragment, place + vec2f(0.0, 1.0)),
    );
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

fn point_seen(sighting: Sighting) -> SurfacePoint {
    let first = 3u * (sighting.triangle - 1u);
    let a = vertices[indices[first]];
    let b = vertices[indices[first + 1u]];
    let c = vertices[indices[first + 2u]];
    let plane = plane_of(position_of(a), position_of(b), position_of(c));
    let position = meeting(plane, sighting.ray);
    let weights = weights_at(plane, position);
    let right = weights_at(plane, meeting(plane, sighting.right)) - weights;
    let down = weights_at(plane, meeting(plane, sighting.down)) - weights;
    let texcoords = mat3x2f(texcoord_of(a), texcoord_of(b), texcoord_of(c));
    var point: SurfacePoint;
    point.position = position;
    point.normal = normalize(mat3x3f(normal_of(a), normal_of(b), normal_of(c)) * weights);
    point.texcoord = texcoords * weights;
    point.texcoord_dx = clamp(texcoords * right, vec2f(-4.0), vec2f(4.0));
    point.texcoord_dy = clamp(texcoords * down, vec2f(-4.0), vec2f(4.0));
    point.color = mat3x3f(color_of(a), color_of(b), color_of(c)) * weights;
    point.object = a.object;
    return point;
}

// A path that meets a second specular surface goes on as if nothing followed.
fn sighted_color(sighting: Sighting) -> vec3f {
    if sighting.triangle == 0u || sighting.specular {
        return sighted_sky(sighting);
    }
    return shade(point_seen(sighting), sighting.ray.direction);
}

fn sighted(sighting: Sighting, specular: u32) -> Seen {
    if !sighting.exists {
        return Seen(vec4f(0.0), seen_flags(specular, STATUS_OUTSIDE), 0.0);
    }
    if sighting.triangle == 0u {
        return Seen(vec4f(sighting.ray.direction, 0.0), seen_flags(specular, STATUS_SKY), 0.0);
    }
    let point = point_seen(sighting);
    let status = select(STATUS_PROJECTED, STATUS_OUTSIDE, sighting.specular);
    return Seen(vec4f(point.position, f32(point.object)), seen_flags(specular, status), 0.0);
}

@fragment
fn surface_color(fragment: RayFragment) -> @location(0) vec4f {
    let sighting = sighting_at(fragment);
    let incident = normalize(viewing_direction(fragment.pixel.xy));
    let turned = 0.5 * length(sighting.ray.direction - incident);
    return vec4f(mirror_reflectance(fragment.object.x, turned) * sighted_color(sighting), 1.0);
}

@fragment
fn surface_seen(fragment: RayFragment) -> Seen {
    return sighted(sighting_at(fragment), fragment.object.x);
}

@fragment
fn bare_color(fragment: RayFragment) -> @location(0) vec4f {
    let sighting = sighting_at(fragment);
    return vec4f(select(vec3f(0.0), sighted_color(sighting), sighting.exists), 1.0);
}

@fragment
fn bare_seen(fragment: RayFragment) -> Seen {
    return sighted(sighting_at(fragment), 0u);
}
