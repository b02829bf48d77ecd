// A check for the eye: balls where vertex rays hit the scene, and the wireframe of the mesh they leave.
// needs: gpu/scene.wgsl

const WIRE_COLOR = vec3f(1.0, 1.0, 1.0);
// Slices around and stacks from pole to pole of a ball; overlay.py draws 6 vertices for each cell.
const SLICES = 10u;
const STACKS = 6u;

struct BallFragment {
    @builtin(position) pixel: vec4f,
    @location(0) normal: vec3f,
    @location(1) color: vec3f,
}

@vertex
fn ball_vertex(
    @builtin(vertex_index) index: u32, @location(0) ball: vec4f, @location(1) color: vec3f
) -> BallFragment {
    let cell = index / 6u;
    var corners = array<vec2u, 6>(
        vec2u(0u, 0u), vec2u(1u, 0u), vec2u(1u, 1u), vec2u(0u, 0u), vec2u(1u, 1u), vec2u(0u, 1u)
    );
    let place = vec2u(cell % SLICES, cell / SLICES) + corners[index % 6u];
    let around = 6.2831853 * f32(place.x) / f32(SLICES);
    let down = 3.14159265 * f32(place.y) / f32(STACKS);
    let normal = vec3f(sin(down) * cos(around), cos(down), sin(down) * sin(around));
    return BallFragment(projection.clip * vec4f(ball.xyz + ball.w * normal, 1.0), normal, color);
}

@fragment
fn ball_color(fragment: BallFragment) -> @location(0) vec4f {
    let facing = abs(dot(normalize(fragment.normal), normalize(viewing_direction(fragment.pixel.xy))));
    return vec4f(fragment.color * (0.3 + 0.7 * facing), 1.0);
}

@vertex
fn wire_vertex(@location(0) position: vec3f) -> @builtin(position) vec4f {
    var place = projection.clip * vec4f(position, 1.0);
    // Depth is reversed: a little more of it lifts the wires off the mesh.
    place.z *= 1.0005;
    return place;
}

@fragment
fn wire_color() -> @location(0) vec4f {
    return vec4f(WIRE_COLOR, 1.0);
}
