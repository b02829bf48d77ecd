// A cube map: its colours by direction, and the points that it sees.
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

// The world point (w: object number), or the unit direction (w: 0), that the map shows in a direction.
fn cube_point(direction: vec3f) -> vec4f {
    let found = cube_place(direction);
    let depth = textureLoad(cube_depth, map_texel(faces[found.face], found.place), found.face, 0);
    return map_point(faces[found.face], found.place, depth);
}

// What a fragment whose ray goes on in the direction `reflected` sees at such a point.
fn cube_seen(fragment: SceneFragment, point: vec4f, reflected: vec3f) -> Seen {
    let toward = select(point.xyz - fragment.position, point.xyz, point.w == 0.0);
    let status = select(STATUS_WARPED, STATUS_SKY, point.w == 0.0);
    return Seen(point, seen_flags(fragment.object, status), angle_between(toward, reflected));
}
