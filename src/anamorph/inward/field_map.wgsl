// Drawing the near and the far field of rays that converge: which triangle is nearest on each, in one depth buffer.
// needs: gpu/scene.wgsl, gpu/vertices.wgsl

struct Convergence {
    point: vec3f,
    // What is farther from the point lies before all rays.
    reach: f32,
}

@group(2) @binding(0) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(1) var<storage, read> indices: array<u32>;
@group(2) @binding(2) var<uniform> convergence: Convergence;

struct FieldFragment {
    @builtin(position) pixel: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
    // From the point of convergence.
    @location(1) offset: vec3f,
}

struct FieldTexel {
    // From 1.
    @location(0) triangle: u32,
    @builtin(frag_depth) depth: f32,
}

@vertex
fn field_vertex(@builtin(vertex_index) index: u32) -> FieldFragment {
    let position = position_of(vertices[indices[index]]);
    return FieldFragment(projection.clip * vec4f(position, 1.0), index / 3u + 1u, position - convergence.point);
}

// Before the point what is farther from it is nearer to the ray's start, and nearer than all that lies beyond. The
// distance itself is the depth: the projection's own is too coarse.
@fragment
fn near_field(fragment: FieldFragment) -> FieldTexel {
    let distance = length(fragment.offset) / convergence.reach;
    if distance > 1.0 {
        discard;
    }
    return FieldTexel(fragment.triangle, 0.5 + 0.5 * distance);
}

@fragment
fn far_field(fragment: FieldFragment) -> FieldTexel {
    return FieldTexel(fragment.triangle, 0.5 / (1.0 + length(fragment.offset) / convergence.reach));
}
