// Drawing a map of surfaces, and the pyramid of what is nearest in it.
// needs: gpu/scene.wgsl, gpu/vertices.wgsl

@group(2) @binding(0) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(1) var<storage, read> indices: array<u32>;

// A bit of a triangle's number: it is a specular surface.
const SPECULAR = 0x80000000u;

struct MapFragment {
    @builtin(position) pixel: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
}

@vertex
fn map_vertex(@builtin(vertex_index) index: u32) -> MapFragment {
    let vertex = vertices[indices[index]];
    let specular = select(0u, SPECULAR, is_specular(vertex.object));
    return MapFragment(projection.clip * vec4f(position_of(vertex), 1.0), (index / 3u + 1u) | specular);
}

// The triangle, from 1, and the bits of its depth and of the slopes of that.
@fragment
fn map_surface(fragment: MapFragment) -> @location(0) vec4u {
    let plane = vec3f(fragment.pixel.z, dpdx(fragment.pixel.z), dpdy(fragment.pixel.z));
    return vec4u(fragment.triangle, bitcast<vec3u>(plane));
}
