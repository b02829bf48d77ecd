// What bounds the rays that leave a tile of samples: a box around their starts, and a cone around their directions.
// needs: gpu/path_end.wgsl

// Samples along each side of a tile.
override SIDE: u32 = 8u;
// The status of a path that will be traced.
const DOUBTFUL = 8u;

struct TileRays {
    low: vec3f,
    // How many rays there are.
    count: u32,
    high: vec3f,
    // Of the angle between the axis and the direction that is farthest from it.
    cosine: f32,
    // Unit.
    axis: vec3f,
    padding: u32,
}

@group(0) @binding(0) var first_texels: texture_2d<u32>;
@group(0) @binding(1) var second_texels: texture_2d<u32>;
// Where the first tile begins, and how many there are along both sides.
@group(0) @binding(2) var<uniform> extent: vec4u;
@group(0) @binding(3) var<storage, read_write> tiles: array<TileRays>;

@compute @workgroup_size(8, 8)
fn bound_rays(@builtin(global_invocation_id) place: vec3u) {
    if any(place.xy >= extent.zw) {
        return;
    }
    let begin = extent.xy + SIDE * place.xy;
    let size = textureDimensions(first_texels);
    var tile = TileRays(vec3f(3e38), 0u, vec3f(-3e38), 1.0, vec3f(0.0), 0u);
    for (var number = 0u; number < SIDE * SIDE; number++) {
        let texel = begin + vec2u(number % SIDE, number / SIDE);
        let end = unpacked(textureLoad(first_texels, texel, 0), textureLoad(second_texels, texel, 0));
        if any(texel >= size) || is_empty(end) || status_of(end) == DOUBTFUL {
            continue;
        }
        tile.count++;
        tile.low = min(tile.low, end.origin);
        tile.high = max(tile.high, end.origin);
        tile.axis += end.direction;
    }
    tile.axis = normalize(select(vec3f(1.0, 0.0, 0.0), tile.axis, any(tile.axis != vec3f(0.0))));
    for (var number = 0u; number < SIDE * SIDE; number++) {
        let texel = begin + vec2u(number % SIDE, number / SIDE);
        let end = unpacked(textureLoad(first_texels, texel, 0), textureLoad(second_texels, texel, 0));
        if all(texel < size) && !is_empty(end) && status_of(end) != DOUBTFUL {
            tile.cosine = min(tile.cosine, dot(tile.axis, end.direction));
        }
    }
    tiles[place.y * extent.z + place.x] = tile;
}
