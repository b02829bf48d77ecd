// A cube map looked up where the reflected ray meets the box around the scene, as seen from the map's centre.
// needs: methods/environment/cube_map.wgsl

struct Box {
    // Its lowest and highest corner, and the cube map's centre.
    low: vec3f,
    high: vec3f,
    center: vec3f,
}

@group(3) @binding(0) var<uniform> scene_box: Box;

// The direction to look up for a ray that starts in the box; outside of it, the ray's own.
fn corrected(origin: vec3f, direction: vec3f) -> vec3f {
    let ends = max((scene_box.low - origin) / direction, (scene_box.high - origin) / direction);
    let end = origin + min(min(ends.x, ends.y), ends.z) * direction;
    let within = all(origin >= scene_box.low) && all(origin <= scene_box.high);
    return select(direction, end - scene_box.center, within);
}

@fragment
fn parallax_color(fragment: SceneFragment) -> @location(0) vec4f {
    let normal = normalize(fragment.normal);
    let direction = normalize(fragment.position - projection.eye.xyz);
    let lookup = corrected(fragment.position, reflect(direction, normal));
    let seen = textureSample(cube_color, cube_sampler, lookup).rgb;
    return vec4f(mirror_reflectance(fragment.object, dot(normal, direction)) * seen, 1.0);
}

@fragment
fn parallax_seen(fragment: SceneFragment) -> Seen {
    let direction = normalize(fragment.position - projection.eye.xyz);
    let reflected = reflect(direction, normalize(fragment.normal));
    return cube_seen(fragment, cube_point(corrected(fragment.position, reflected)), reflected);
}
