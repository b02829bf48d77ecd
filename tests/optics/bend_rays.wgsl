// `mirrored` and `through_lens` for many rays.
// needs: optics/bend_lens.wgsl

override LENS: i32 = 0;

struct Given {
    eye: vec3f,
    side: u32,
    direction: vec3f,
    line: u32,
    corners: mat3x3f,
    normals: mat3x3f,
    parameters: mat3x2f,
}

@group(0) @binding(0) var<storage, read> rays: array<Given>;
@group(0) @binding(1) var<storage, read_write> found: array<BentRay>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&found) {
        return;
    }
    let ray = rays[id.x];
    let hit = flat_hit(ray.side, ray.eye, ray.direction, ray.corners, ray.normals, ray.parameters);
    if LENS == 1 {
        let index = exact_sides[ray.side].indices[ray.line];
        found[id.x] = through_lens(ray.side, hit, lens_entry(ray.side, hit), index);
    } else {
        found[id.x] = mirrored(ray.side, hit);
    }
}
