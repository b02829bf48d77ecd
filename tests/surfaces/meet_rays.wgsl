// `meet` for many rays.
// needs: surfaces/meet.wgsl

override SURFACE: u32;

struct Given {
    point: vec3f,
    u: f32,
    direction: vec3f,
    v: f32,
    facing: vec3f,
}

struct Found {
    normal: vec3f,
    step: f32,
    met: u32,
}

@group(0) @binding(0) var<storage, read> rays: array<Given>;
@group(0) @binding(1) var<storage, read_write> found: array<Found>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&found) {
        let ray = rays[id.x];
        let hit = meet(SURFACE, 0u, ray.point, ray.direction, vec2f(ray.u, ray.v), ray.facing);
        found[id.x] = Found(hit.normal, hit.step, u32(hit.met));
    }
}
