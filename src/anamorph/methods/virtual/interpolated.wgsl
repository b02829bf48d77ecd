// Vertices whose virtual points are interpolated between the corners of a grid's cells.
// Estalella et al. 2005, section 5.

// In place of a length: the vertex has to be searched for itself.
const UNKNOWN = 3e38;

struct Reflected {
    place: vec3f,
    error: f32,
    behind: vec3f,
    // Negative where the reflector hides the point, 0 inside of it.
    length: f32,
}

struct GridVertex {
    // The points around it, x changes first.
    corners: array<u32, 8>,
    // Where it is between them, 0 to 1 along each axis.
    place: vec3f,
    padding: u32,
}

@group(0) @binding(0) var<storage, read> known: array<Reflected>;
@group(0) @binding(1) var<storage, read> grid_vertices: array<GridVertex>;
@group(0) @binding(2) var<storage, read_write> reflected: array<Reflected>;

@compute @workgroup_size(64)
fn interpolate_vertices(@builtin(global_invocation_id) number: vec3u) {
    if number.x >= arrayLength(&reflected) {
        return;
    }
    let vertex = grid_vertices[number.x];
    var sum = Reflected(vec3f(0.0), 0.0, vec3f(0.0), 0.0);
    var shown = 0u;
    for (var corner = 0u; corner < 8u; corner++) {
        let far = vec3<bool>((corner & 1u) != 0u, (corner & 2u) != 0u, (corner & 4u) != 0u);
        let shares = select(1.0 - vertex.place, vertex.place, far);
        let share = shares.x * shares.y * shares.z;
        let found = known[vertex.corners[corner]];
        sum.place += share * found.place;
        sum.error += share * found.error;
        sum.behind += share * found.behind;
        sum.length += share * found.length;
        shown += select(0u, 1u, found.length > 0.0);
    }
    // Of a cell across the reflector's horizon virtual points are not nearly linear.
    if shown > 0u && shown < 8u {
        sum.length = UNKNOWN;
    }
    reflected[number.x] = sum;
}
