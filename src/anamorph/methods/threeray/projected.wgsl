// Points projected by three-ray cameras: of each pair of a camera and a point, where the camera sees it.
// needs: raytriangle/points.wgsl, gpu/vertices.wgsl, methods/threeray/three_ray_camera.wgsl
// Source: Mei, Popescu and Sacks 2007, section 5.1. Deviation: all projections that are valid, where the paper's
// hardware gave one.

// The most projections that a pair has: 1 where its camera sees every point once.
override ROOTS: u32 = 3;

@group(1) @binding(0) var<storage, read> vertices: array<StoredVertex>;
@group(1) @binding(1) var<storage, read> indices: array<u32>;
@group(1) @binding(2) var<storage, read> cameras: array<ThreeRayCamera>;
@group(1) @binding(3) var<storage, read> scene_points: array<ScenePoint>;
// Numbers of a camera and a point.
@group(1) @binding(4) var<storage, read> pairs: array<vec2u>;
// Of each pair, `ROOTS`.
@group(1) @binding(5) var<storage, read_write> projected: array<Projected>;
// How many projections there are, pairs that have several, and pairs. No uniform holds the last: software Vulkan would
// compile the shader for its value.
@group(1) @binding(6) var<storage, read_write> counts: array<atomic<u32>, 3>;

fn corner_of(triangle: u32, corner: u32) -> vec3f {
    return position_of(vertices[indices[3u * triangle + corner]]);
}

// Whether a ray would meet the back of the surface that it has just left: rounding and interpolation put it there.
fn is_within(camera: ThreeRayCamera, point: ScenePoint, direction: vec3f, way: f32) -> bool {
    if camera.surface != point.surface || way >= camera.longest {
        return false;
    }
    let a = corner_of(point.triangle, 0u);
    let normal = cross(corner_of(point.triangle, 1u) - a, corner_of(point.triangle, 2u) - a);
    return dot(normal, direction) > 0.0;
}

@compute @workgroup_size(64)
fn project_pairs(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= atomicLoad(&counts[2]) {
        return;
    }
    let pair = pairs[id.x];
    let camera = cameras[pair.x];
    let point = scene_points[pair.y];
    let roots = roots_of(pair.x, Two(point.high, point.low));
    var count = 0u;
    for (var k = 0; k < 3; k++) {
        let root = roots[k];
        var seen = Projected(root.u, root.v, 0.0);
        let weights = weights_of(seen);
        let t = root.t * camera.pace;
        if root.valid && t >= camera.near && all(weights >= vec3f(0.0)) && count < ROOTS {
            let direction = camera.directions * weights;
            seen.way = t * length(direction);
            if !is_within(camera, point, direction, seen.way) {
                projected[ROOTS * id.x + count] = seen;
                count++;
            }
        }
    }
    for (var k = count; k < ROOTS; k++) {
        projected[ROOTS * id.x + k] = Projected(0.0, 0.0, -1.0);
    }
    if count > 0u {
        atomicAdd(&counts[0], count);
    }
    if count > 1u {
        atomicAdd(&counts[1], 1u);
    }
}
