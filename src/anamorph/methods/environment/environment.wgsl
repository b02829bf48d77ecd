// Environment mapping: a cube map looked up by the reflected direction alone.
// needs: methods/environment/cube_map.wgsl

@fragment
fn environment_color(fragment: SceneFragment) -> @location(0) vec4f {
    let normal = normalize(fragment.normal);
    let direction = normalize(fragment.position - projection.eye.xyz);
    let reflected = textureSample(cube_color, cube_sampler, reflect(direction, normal)).rgb;
    return vec4f(mirror_reflectance(fragment.object, dot(normal, direction)) * reflected, 1.0);
}

@fragment
fn environment_seen(fragment: SceneFragment) -> Seen {
    let normal = normalize(fragment.normal);
    let direction = normalize(fragment.position - projection.eye.xyz);
    let reflected = reflect(direction, normal);
    return cube_seen(fragment, cube_point(reflected), reflected);
}
