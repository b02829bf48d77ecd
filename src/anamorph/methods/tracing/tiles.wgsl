// Tiles of traced pixels: hits that the CPU found, coloured by the shading that every method uses.
// needs: gpu/scene.wgsl, gpu/vertices.wgsl

// One pixel's path, as methods/tracing/paths.py writes it.
struct PathEnd {
    origin: vec3f,
    // -1: the sky.
    triangle: i32,
    direction: vec3f,
    // Specular object in the low 16 bits, status in the next 8, bounces in the high 8.
    flags: u32,
    throughput: vec3f,
    distance: f32,
    barycentric: vec2f,
    // The row in `line_paths`, from 1, where light of each colour goes its own way; else 0.
    line_row: u32,
    padding: f32,
}

// Whether light of one line of the spectrum, red or blue, is drawn over the image that the d line has made.
override ONE_LINE: bool = false;

// Columns and rows of every tile.
@group(2) @binding(0) var<uniform> tile_size: vec2u;
// First column and row of each tile.
@group(2) @binding(1) var<storage, read> corners: array<vec2u>;
// Tile by tile, each row by row.
@group(2) @binding(2) var<storage, read> paths: array<PathEnd>;
// Paths of that one line.
@group(2) @binding(3) var<storage, read> line_paths: array<PathEnd>;
@group(2) @binding(4) var<storage, read> vertices: array<StoredVertex>;
@group(2) @binding(5) var<storage, read> indices: array<u32>;

struct TileFragment {
    @builtin(position) pixel: vec4f,
    @location(0) @interpolate(flat) tile: u32,
}

// Nearest of all: what is drawn after it leaves a tile alone.
@vertex
fn tile_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) tile: u32) -> TileFragment {
    var quad = array<vec2u, 6>(
        vec2u(0u, 0u), vec2u(1u, 0u), vec2u(1u, 1u), vec2u(0u, 0u), vec2u(1u, 1u), vec2u(0u, 1u)
    );
    let place = vec2f(corners[tile] + quad[index] * tile_size) / projection.size.xy;
    return TileFragment(vec4f(place * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 1.0, 1.0), tile);
}

struct Triangle {
    corner: vec3f,
    edge_1: vec3f,
    edge_2: vec3f,
    texcoord: vec2f,
    texcoord_1: vec2f,
    texcoord_2: vec2f,
}

// The d line's path of a pixel in a tile.
fn middle_path(tile: u32, place: vec2u) -> PathEnd {
    return paths[(tile * tile_size.y + place.y) * tile_size.x + place.x];
}

// The path of the light that is drawn: one of all colours where nothing disperses them.
fn path_at(tile: u32, place: vec2u) -> PathEnd {
    let path = middle_path(tile, place);
    if ONE_LINE && path.line_row > 0u {
        return line_paths[path.line_row - 1u];
    }
    return path;
}

// The place of a fragment in its tile.
fn tile_place(fragment: TileFragment) -> vec2u {
    return vec2u(fragment.pixel.xy) - corners[fragment.tile];
}

// Whether any light arrives: not in pixels without a ray, whose direction is none.
fn arrives(path: PathEnd) -> bool {
    return any(path.throughput > vec3f(0.0));
}

// The path of a pixel beside this one by `step`, if it takes the same way: its ray is then this pixel's footprint.
fn beside(fragment: TileFragment, step: vec2i, path: PathEnd) -> PathEnd {
    let place = vec2i(tile_place(fragment)) + step;
    if all(place >= vec2i(0)) && all(place < vec2i(tile_size)) {
        let other = path_at(fragment.tile, vec2u(place));
        let way = 0xFF00FFFFu;
        if (other.flags & way) == (path.flags & way) && arrives(other) {
            return other;
        }
    }
    return path;
}

// How the texture coordinates change from this path to another that hits the same plane.
fn texcoord_change(triangle: Triangle, path: PathEnd, other: PathEnd) -> vec2f {
    let normal = cross(triangle.edge_1, triangle.edge_2);
    let slant = dot(normal, other.direction);
    let limit = 1e-6 * length(normal);
    let along = dot(normal, triangle.corner - other.origin) / select(slant, limit, abs(slant) < limit);
    let offset = other.origin + along * other.direction - triangle.corner;
    let weights = vec2f(dot(cross(offset, triangle.edge_2), normal), dot(cross(triangle.edge_1, offset), normal))
        / max(dot(normal, normal), 1e-30);
    let change = weights - path.barycentric;
    return clamp(change.x * triangle.texcoord_1 + change.y * triangle.texcoord_2, vec2f(-4.0), vec2f(4.0));
}

fn path_color(fragment: TileFragment) -> vec3f {
    let path = path_at(fragment.tile, tile_place(fragment));
    if !arrives(path) {
        return vec3f(0.0);
    }
    // One step each way: the way back serves where the way on leads elsewhere.
    var right = beside(fragment, vec2i(1, 0), path);
    if all(right.direction == path.direction) {
        right = beside(fragment, vec2i(-1, 0), path);
    }
    var down = beside(fragment, vec2i(0, 1), path);
    if all(down.direction == path.direction) {
        down = beside(fragment, vec2i(0, -1), path);
    }
    let spread = max(length(right.direction - path.direction), length(down.direction - path.direction));
    // A path that has met too many specular surfaces goes on as if nothing followed.
    if path.triangle < 0 || ((path.flags >> 16u) & 0xFFu) == STATUS_OUTSIDE {
        return path.throughput * sky_color(path.direction, spread);
    }
    let first = 3u * u32(path.triangle);
    let a = vertices[indices[first]];
    let b = vertices[indices[first + 1u]];
    let c = vertices[indices[first + 2u]];
    let corner = position_of(a);
    let triangle = Triangle(
        corner,
        position_of(b) - corner,
        position_of(c) - corner,
        texcoord_of(a),
        texcoord_of(b) - texcoord_of(a),
        texcoord_of(c) - texcoord_of(a),
    );
    let weights = vec3f(1.0 - path.barycentric.x - path.barycentric.y, path.barycentric);
    var point: SurfacePoint;
    point.position = corner + weights.y * triangle.edge_1 + weights.z * triangle.edge_2;
    point.normal = normalize(weights.x * normal_of(a) + weights.y * normal_of(b) + weights.z * normal_of(c));
    point.texcoord = triangle.texcoord + weights.y * triangle.texcoord_1 + weights.z * triangle.texcoord_2;
    point.texcoord_dx = texcoord_change(triangle, path, right);
    point.texcoord_dy = texcoord_change(triangle, path, down);
    point.color = weights.x * color_of(a) + weights.y * color_of(b) + weights.z * color_of(c);
    point.object = a.object;
    return path.throughput * shade(point, path.direction);
}

@fragment
fn traced_color(fragment: TileFragment) -> @location(0) vec4f {
    if ONE_LINE && middle_path(fragment.tile, tile_place(fragment)).line_row == 0u {
        discard;
    }
    return vec4f(path_color(fragment), 1.0);
}

@fragment
fn traced_seen(fragment: TileFragment) -> Seen {
    let path = middle_path(fragment.tile, tile_place(fragment));
    let flags = path.flags & 0xFFFFFFu;
    if path.triangle < 0 {
        return Seen(vec4f(path.direction, 0.0), flags, 0.0);
    }
    let object = vertices[indices[3u * u32(path.triangle)]].object;
    return Seen(vec4f(path.origin + path.distance * path.direction, f32(object)), flags, 0.0);
}
