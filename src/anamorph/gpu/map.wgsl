// Reading a map: what its projection saw at a place in it.
// needs: gpu/scene.wgsl

// The world point (w: object number), or the unit direction (w: 0), that a map sees at `place` (0 to 1, y down).
// `depth` is the map's texel there, as scene_depth wrote it.
fn map_point(seen_by: Projection, place: vec2f, depth: vec4f) -> vec4f {
    let pixel = place * seen_by.size.xy;
    let ndc = place * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    if depth.w == 0.0 {
        return vec4f(normalize(seen_by.base.xyz + ndc.x * seen_by.right.xyz + ndc.y * seen_by.up.xyz), 0.0);
    }
    // Depth is linear in the image on a triangle, so its slopes carry it from the texel's centre to the place.
    let offset = pixel - min(floor(pixel), seen_by.size.xy - 1.0) - 0.5;
    let point = seen_by.unclip * vec4f(ndc, depth.x + dot(depth.yz, offset), 1.0);
    return vec4f(point.xyz / point.w, depth.w);
}

// The texel that holds `place`, in the texture of which the map is a part.
fn map_texel(seen_by: Projection, place: vec2f) -> vec2i {
    return vec2i(seen_by.size.zw + clamp(place * seen_by.size.xy, vec2f(0.0), seen_by.size.xy - 1.0));
}

// The face of a cube map, in the order +x, -x, +y, -y, +z, -z, that a direction meets.
fn cube_face(direction: vec3f) -> i32 {
    let size = abs(direction);
    if size.x >= size.y && size.x >= size.z {
        return select(1, 0, direction.x > 0.0);
    }
    if size.y >= size.z {
        return select(3, 2, direction.y > 0.0);
    }
    return select(5, 4, direction.z > 0.0);
}
