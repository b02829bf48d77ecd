// Traced paths put into the visibility buffer, each a point.
// needs: gpu/scene.wgsl, gpu/path_end.wgsl

struct TracedPath {
    first: vec4u,
    second: vec4u,
}

// The pixels, by column and row, and their paths' ends.
@group(2) @binding(0) var<storage, read> pixels: array<vec2u>;
@group(2) @binding(1) var<storage, read> traced: array<TracedPath>;

struct TracedPoint {
    @builtin(position) pixel: vec4f,
    @location(0) @interpolate(flat) first: vec4u,
    @location(1) @interpolate(flat) second: vec4u,
}

@vertex
fn traced_vertex(@builtin(vertex_index) index: u32) -> TracedPoint {
    let place = (vec2f(pixels[index]) + 0.5) / projection.size.xy * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    return TracedPoint(vec4f(place, 1.0, 1.0), traced[index].first, traced[index].second);
}

@fragment
fn traced_end(point: TracedPoint) -> PackedPathEnd {
    return PackedPathEnd(point.first, point.second);
}
