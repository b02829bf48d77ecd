// Trilinear projection: what the rays of a picture's ray triangles see, coloured. Follows visibility.wgsl.

// The scene triangle that each pixel sees, from 1, and whether it is the front of a specular surface; 0 for the sky.
@group(3) @binding(1) var triangles_seen: texture_2d<u32>;

struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// What a pixel's ray is and what it meets; the rays of the pixels to the right and below tell its footprint.
struct Sighting {
    // From 1; 0 where there is no ray.
    ray_triangle: u32,
    // From 1; 0 for the sky.
    triangle: u32,
    specular: bool,
    ray: Ray,
    right: Ray,
    down: Ray,
}

fn ray_at(triangle: RayTriangle, place: vec2f) -> Ray {
    let direction = triangle.direction_x * place.x + triangle.direction_y * place.y + triangle.direction_one;
    let origin = triangle.origin_x * place.x + triangle.origin_y * place.y + triangle.origin_one;
    let scale = triangle.scale_x * place.x + triangle.scale_y * place.y + triangle.scale_one;
    // A direction of no length is a ray nowhere.
    return Ray(triangle.anchor + origin / scale, direction * inverseSqrt(max(dot(direction, direction), 1e-30)));
}

fn sighting_at(pixel: vec4f) -> Sighting {
    let texel = vec2u(pixel.xy);
    let owner = textureLoad(owners, texel, 0).x;
    let triangle = ray_triangles[max(owner, 1u) - 1u];
    let seen = textureLoad(triangles_seen, texel, 0).x;
    let place = pixel.xy - vec2f(triangle.center_x, triangle.center_y);
    return Sighting(
        owner,
        seen & ~SPECULAR,
        (seen & SPECULAR) != 0u,
        ray_at(triangle, place),
        ray_at(triangle, place + vec2f(1.0, 0.0)),
        ray_at(triangle, place + vec2f(0.0, 1.0)),
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
    if sighting.ray_triangle == 0u {
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
fn reflected_color(fragment: SceneFragment) -> @location(0) vec4f {
    let sighting = sighting_at(fragment.pixel);
    let incident = normalize(viewing_direction(fragment.pixel.xy));
    let turned = 0.5 * length(sighting.ray.direction - incident);
    return vec4f(mirror_reflectance(fragment.object, turned) * sighted_color(sighting), 1.0);
}

@fragment
fn reflected_seen(fragment: SceneFragment) -> Seen {
    return sighted(sighting_at(fragment.pixel), fragment.object);
}

@fragment
fn ray_mesh_color(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let sighting = sighting_at(pixel);
    return vec4f(select(sighted_color(sighting), vec3f(0.0), sighting.ray_triangle == 0u), 1.0);
}

@fragment
fn ray_mesh_seen(@builtin(position) pixel: vec4f) -> Seen {
    return sighted(sighting_at(pixel), 0u);
}
