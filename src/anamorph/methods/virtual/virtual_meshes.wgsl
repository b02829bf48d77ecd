// Virtual objects, as in the paper: a reflector's images of meshes, drawn as meshes of their own.
// needs: gpu/scene.wgsl, gpu/vertices.wgsl, gpu/path_end.wgsl
// Estalella et al. 2005, sections 3 and 6.1.

struct Reflected {
    place: vec3f,
    error: f32,
    behind: vec3f,
    // Negative where the reflector hides the point, 0 inside of it.
    length: f32,
}

// Mirrors that are one body, by object number; and the number of the body that is drawn.
override BODY: u32 = 0u;

@group(2) @binding(0) var first_texels: texture_2d<u32>;
@group(2) @binding(1) var second_texels: texture_2d<u32>;
@group(2) @binding(2) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(3) var<storage, read> indices: array<u32>;
@group(2) @binding(4) var<storage, read> reflected: array<Reflected>;
@group(2) @binding(5) var<storage, read> bodies: array<u32>;

struct VirtualFragment {
    @builtin(position) pixel: vec4f,
    // Of the scene's triangle.
    @location(0) point: vec3f,
    // From 1.
    @location(1) @interpolate(flat) triangle: u32,
    @location(2) @interpolate(flat) object: u32,
}

@vertex
fn virtual_vertex(@builtin(vertex_index) index: u32) -> VirtualFragment {
    let first = index / 3u * 3u;
    let a = indices[first];
    let b = indices[first + 1u];
    let c = indices[first + 2u];
    let own = indices[index];
    let vertex = vertices[own];
    // What the reflector hides as a whole, what reaches into it or is its own, and what turns its back has no image.
    let lengths = vec3f(reflected[a].length, reflected[b].length, reflected[c].length);
    let hidden = all(lengths < vec3f(0.0)) || any(lengths == vec3f(0.0));
    let corner = position_of(vertices[a]);
    let normal = cross(position_of(vertices[b]) - corner, position_of(vertices[c]) - corner);
    let turned = max(
        dot(normal, reflected[a].place - corner),
        max(dot(normal, reflected[b].place - corner), dot(normal, reflected[c].place - corner))
    ) < 0.0;
    var clip = projection.clip * vec4f(reflected[own].behind, 1.0);
    if hidden || turned || bodies[vertex.object] == BODY {
        clip = vec4f(0.0, 0.0, 2.0, 1.0);
    }
    return VirtualFragment(clip, position_of(vertex), index / 3u + 1u, vertex.object);
}

@fragment
fn virtual_end(fragment: VirtualFragment) -> PackedPathEnd {
    let texel = vec2u(fragment.pixel.xy);
    let end = unpacked(textureLoad(first_texels, texel, 0), textureLoad(second_texels, texel, 0));
    if is_empty(end) || bodies[end.flags & 0xFFFFu] != BODY || status_of(end) == STATUS_DOUBTFUL {
        discard;
    }
    // From here on the pixel's own ray is left for the one to the point that is shown.
    let status = select(STATUS_PROJECTED, STATUS_DOUBTFUL, is_specular(fragment.object));
    let flags = (end.flags & 0xFF00FFFFu) | (status << 16u);
    return packed(PathEnd(end.origin, fragment.triangle, normalize(fragment.point - end.origin), flags, end.throughput));
}
