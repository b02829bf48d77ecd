// Trilinear projection: what the rays of a picture's ray triangles see, coloured. Follows visibility.wgsl.

// The scene triangle that each pixel sees, from 1, and whether it is the front of a specular surface; 0 for the sky.
@group(3) @binding(1) var triangles_seen: texture_2d<u32>;
// What has been made of that; it is bound alone.
@group(3) @binding(0) var colors: texture_2d<f32>;

// 1 where some surfaces seen may be specular fronts, behind which the path goes on.
override GOES_ON: bool = false;
// 1 for a bare ray mesh, which takes nothing from the light.
override BARE: bool = false;
// 1 to draw all ray triangles at no depth. There the depth of what is seen decides: above it are surfaces, at it the sky.
override LEVEL: bool = false;

struct RayFragment {
    @builtin(position) @invariant pixel: vec4f,
    // Of the ray triangle, as functions of the place; behind them the scale's three terms, and the center.
    @location(0) @interpolate(flat) direction_x: vec4f,
    @location(1) @interpolate(flat) direction_y: vec4f,
    @location(2) @interpolate(flat) direction_one: vec4f,
    @location(3) @interpolate(flat) origin_x: vec4f,
    @location(4) @interpolate(flat) origin_y: vec4f,
    @location(5) @interpolate(flat) origin_one: vec3f,
    @location(6) @interpolate(flat) anchor: vec3f,
    @location(7) @interpolate(flat) incident_x: vec3f,
    @location(8) @interpolate(flat) incident_y: vec3f,
    @location(9) @interpolate(flat) incident_one: vec3f,
    // The object number, and the ray triangle's own, from 1; 0 where it has no rays.
    @location(10) @interpolate(flat) numbers: vec2u,
}

fn ray_fragment(clip: vec4f, number: u32) -> RayFragment {
    let triangle = ray_triangles[number];
    return RayFragment(
        vec4f(clip.xy, select(clip.z, 0.0, LEVEL), clip.w),
        vec4f(triangle.direction_x, triangle.scale_x),
        vec4f(triangle.direction_y, triangle.scale_y),
        vec4f(triangle.direction_one, triangle.scale_one),
        vec4f(triangle.origin_x, triangle.center_x),
        vec4f(triangle.origin_y, triangle.center_y),
        triangle.origin_one,
        triangle.anchor,
        triangle.incident_x,
        triangle.incident_y,
        triangle.incident_one,
        vec2u(triangle.object, (number + 1u) * triangle.valid),
    );
}

@vertex
fn surface_ray_vertex(@builtin(vertex_index) index: u32) -> RayFragment {
    return ray_fragment(surface_clip(ray_triangles[index / 3u], index % 3u), index / 3u);
}

@vertex
fn bare_ray_vertex(@builtin(vertex_index) index: u32) -> RayFragment {
    return ray_fragment(bare_clip(ray_triangles[index / 3u], index % 3u), index / 3u);
}

struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// What a pixel's ray is and what it meets; the rays of the pixels to the right and below tell its footprint.
struct Sighting {
    // Whether the pixel is this ray triangle's.
    own: bool,
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
    let owner = textureLoad(owners, vec2u(fragment.pixel.xy), 0).x;
    let place = fragment.pixel.xy - vec2f(fragment.origin_x.w, fragment.origin_y.w);
    return Sighting(
        owner == fragment.numbers.y && owner > 0u,
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

fn sighted(sighting: Sighting, specular: u32) -> Seen {
    if !sighting.own {
        return Seen(vec4f(0.0), seen_flags(specular, STATUS_OUTSIDE), 0.0);
    }
    if sighting.triangle == 0u {
        return Seen(vec4f(sighting.ray.direction, 0.0), seen_flags(specular, STATUS_SKY), 0.0);
    }
    let point = point_seen(sighting);
    let status = select(STATUS_PROJECTED, STATUS_OUTSIDE, sighting.specular);
    return Seen(vec4f(point.position, f32(point.object)), seen_flags(specular, status), 0.0);
}

// What of the light that is seen in a specular surface reaches the eye.
fn reflectance(fragment: RayFragment, sighting: Sighting) -> vec3f {
    if BARE {
        return vec3f(1.0);
    }
    let place = fragment.pixel.xy - vec2f(fragment.origin_x.w, fragment.origin_y.w);
    let incident = fragment.incident_x * place.x + fragment.incident_y * place.y + fragment.incident_one;
    return mirror_reflectance(fragment.numbers.x, 0.5 * length(sighting.ray.direction - normalize(incident)));
}

@fragment
fn surface_color(fragment: RayFragment) -> @location(0) vec4f {
    let sighting = sighting_at(fragment);
    if !sighting.own {
        discard;
    }
    var color = shade(point_seen(sighting), sighting.ray.direction);
    if GOES_ON {
        // As if nothing followed.
        color = select(color, sighted_sky(sighting), sighting.specular);
    }
    return vec4f(reflectance(fragment, sighting) * color, 1.0);
}

@fragment
fn surface_sky(fragment: RayFragment) -> @location(0) vec4f {
    let sighting = sighting_at(fragment);
    if !sighting.own {
        discard;
    }
    return vec4f(reflectance(fragment, sighting) * sighted_sky(sighting), 1.0);
}

@fragment
fn surface_seen(fragment: RayFragment) -> Seen {
    return sighted(sighting_at(fragment), fragment.numbers.x);
}

// The colours, where they belong in the picture.
@fragment
fn composed_color(fragment: OwnerFragment) -> @location(0) vec4f {
    return textureLoad(colors, vec2u(fragment.pixel.xy), 0);
}
