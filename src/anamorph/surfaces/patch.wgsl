// Where a ray meets a patch: patch_search.py on the device, over the polynomials of nurbs_pieces.py.
// needs: surfaces/numbers.wgsl
//
// The numbers of a patch: degrees along u and v, counts of pieces along u and v, its extent, its sign, the borders of
// the pieces along u and along v, and for each piece its middle and the coefficients of its numerators and denominator.
// Numerators are those of the offset from the middle, so that only what is small is rounded.

const PATCH_HEAD = 6u;
const MOST_TRIALS = 16;
// Of the patch's extent: what rounding leaves, what counts as met, and how far from the mesh that may be.
const SMALL = 1e-7;
const NEAR = 4e-6;
const SAME_SHEET = 0.25;

struct PatchPoint {
    position: vec3f,
    along_u: vec3f,
    along_v: vec3f,
}

// Which of `count` pieces holds a parameter, its coordinate there from -1 to 1, and that coordinate's slope.
struct InPieces {
    piece: u32,
    coordinate: f32,
    slope: f32,
}

fn place_in_pieces(first: u32, count: u32, parameter: f32) -> InPieces {
    var low = 0u;
    var high = count;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if surface_numbers[first + middle] <= parameter {
            low = middle;
        } else {
            high = middle;
        }
    }
    let start = surface_numbers[first + low];
    let slope = 2.0 / (surface_numbers[first + low + 1u] - start);
    return InPieces(low, (parameter - start) * slope - 1.0, slope);
}

// At parameters from 0 to 1 over the patch; the position is from `origin`.
fn patch_point(first: u32, uv: vec2f, origin: vec3f) -> PatchPoint {
    let degree = vec2u(u32(surface_numbers[first]), u32(surface_numbers[first + 1u]));
    let count = vec2u(u32(surface_numbers[first + 2u]), u32(surface_numbers[first + 3u]));
    let u = place_in_pieces(first + PATCH_HEAD, count.x, uv.x);
    let v = place_in_pieces(first + PATCH_HEAD + count.x + 1u, count.y, uv.y);
    let size = 3u + 4u * (degree.x + 1u) * (degree.y + 1u);
    let piece = first + PATCH_HEAD + count.x + count.y + 2u + (u.piece * count.y + v.piece) * size;
    var value = vec4f(0.0);
    var along_u = vec4f(0.0);
    var along_v = vec4f(0.0);
    var at = piece + size;
    for (var i = 0u; i <= degree.x; i++) {
        var row = vec4f(0.0);
        var slope = vec4f(0.0);
        for (var j = 0u; j <= degree.y; j++) {
            at -= 4u;
            slope = slope * v.coordinate + row;
            row = row * v.coordinate + vec4f(vector_at(at), surface_numbers[at + 3u]);
        }
        along_u = along_u * u.coordinate + value;
        value = value * u.coordinate + row;
        along_v = along_v * u.coordinate + slope;
    }
    let offset = value.xyz / value.w;
    return PatchPoint(
        vector_at(piece) - origin + offset,
        (along_u.xyz - along_u.w * offset) * (u.slope / value.w),
        (along_v.xyz - along_v.w * offset) * (v.slope / value.w),
    );
}

// Newton's steps in the parameters, halved where they lead away, until the patch's point is on the ray.
fn meet_patch(first: u32, point: vec3f, direction: vec3f, start: vec2f) -> Met {
    let extent = surface_numbers[first + 4u];
    let aside = select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(direction.x) < 0.6);
    let across_1 = normalize(cross(direction, aside));
    let across = mat2x3f(across_1, cross(direction, across_1));
    var uv = start;
    var here = patch_point(first, uv, point);
    var off = here.position * across;
    let started = dot(here.position, direction);
    var share = 1.0;
    for (var trial = 0; trial < MOST_TRIALS; trial++) {
        let along_u = here.along_u * across;
        let along_v = here.along_v * across;
        let determinant = along_u.x * along_v.y - along_v.x * along_u.y;
        if length(off) <= SMALL * extent || share < 0.1 || abs(determinant) <= 1e-9 * extent * extent {
            break;
        }
        let change = vec2f(off.x * along_v.y - along_v.x * off.y, along_u.x * off.y - off.x * along_u.y);
        // A little beyond the border, because the mesh there may stand before the neighbouring patch.
        let next = clamp(uv - share / determinant * change, vec2f(-0.05), vec2f(1.05));
        let there = patch_point(first, next, point);
        let next_off = there.position * across;
        if dot(next_off, next_off) < dot(off, off) {
            uv = next;
            here = there;
            off = next_off;
            share = min(2.0 * share, 1.0);
        } else {
            share *= 0.5;
        }
    }
    let step = dot(here.position, direction);
    let normal = surface_numbers[first + 5u] * cross(here.along_u, here.along_v);
    // Far from where the mesh was hit lies another sheet of the patch; a vanishing normal is a pole.
    let met = length(off) <= NEAR * extent && abs(step - started) <= SAME_SHEET * extent
        && length(normal) > 1e-6 * extent * extent;
    return Met(met, step, normalize(normal));
}
