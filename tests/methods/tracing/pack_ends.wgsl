// For test_packing.py: what the device packs, and what it reads from that.
// needs: gpu/path_end.wgsl

struct Packed {
    first: vec4u,
    second: vec4u,
    again: PathEnd,
}

@group(0) @binding(0) var<storage, read> ends: array<PathEnd>;
@group(0) @binding(1) var<storage, read_write> results: array<Packed>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) place: vec3u) {
    if place.x < arrayLength(&results) {
        let end = packed(ends[place.x]);
        results[place.x] = Packed(end.first, end.second, unpacked(end.first, end.second));
    }
}
