// The scene's vertices as shaders read them from storage.

struct StoredVertex {
    x: f32, y: f32, z: f32,
    normal_x: f32, normal_y: f32, normal_z: f32,
    u: f32, v: f32,
    color_red_green: u32, color_blue: u32,
    object: u32,
}

fn position_of(vertex: StoredVertex) -> vec3f {
    return vec3f(vertex.x, vertex.y, vertex.z);
}

fn normal_of(vertex: StoredVertex) -> vec3f {
    return vec3f(vertex.normal_x, vertex.normal_y, vertex.normal_z);
}

fn texcoord_of(vertex: StoredVertex) -> vec2f {
    return vec2f(vertex.u, vertex.v);
}

fn color_of(vertex: StoredVertex) -> vec3f {
    return vec3f(unpack2x16unorm(vertex.color_red_green), unpack2x16unorm(vertex.color_blue).x);
}
