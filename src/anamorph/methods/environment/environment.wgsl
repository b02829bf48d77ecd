// Environment mapping: a cube map looked up by the reflected direction alone.
// needs: gpu/map.wgsl

@group(2) @binding(0) var<storage, read> faces: array<Projection, 6>;
@group(2) @binding(1) var cube_color: texture_cube<f32>;
@group(2) @binding(2) var cube_sampler: sampler;
@group(2) @binding(3) var cube_depth: texture_2d_array<f32>;

// The face and the place on it (0 to 1, y down) that a direction meets.
struct CubePlace {
    face: i32,
    place: vec2f,
}

fn cube_place(direction: vec3f) -> CubePlace {
    let face = cube_face(direction);
    let basis = faces[face];
    let along = dot(direction, basis.base.xyz);
    let place = vec2f(dot(direction, basis.right.xyz), dot(direction, basis.up.xyz)) / along;
    return CubePlace(face, place * vec2f(0.5, -0.5) + 0.5);
}

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
    let found = cube_place(reflected);
    let depth = textureLoad(cube_depth, map_texel(faces[found.face], found.place), found.face, 0);
    let point = map_point(faces[found.face], found.place, depth);
    let toward = select(point.xyz - fragment.position, point.xyz, point.w == 0.0);
    return Seen(point, seen_flags(fragment.object, select(STATUS_WARPED, STATUS_SKY, point.w == 0.0)), angle_between(toward, reflected));
}
