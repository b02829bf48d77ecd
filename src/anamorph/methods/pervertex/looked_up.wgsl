// Which texels of a map are looked up. Depth is nearest everywhere else, so that nothing is shaded there.
// needs: methods/pervertex/lens.wgsl

// 1 for lenses, which have rays beside their lookups.
override REFRACTS: i32 = 0;

// Texels around what a triangle looks up that filtering may touch.
const MARGIN = 2.0;

@vertex
fn nowhere_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 1.0);
}

// A box around the places that each triangle looks up, as two triangles.
@vertex
fn looked_up_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let triangle = triangles[index / 6u];
    let colors = select(1u, 3u, (triangle.flags & THREE_COLORS) != 0u);
    var low = vec2f(1.0);
    var high = vec2f(0.0);
    for (var number = 0u; number < 3u * colors; number++) {
        let of_lens = 2u + (colors + 2u) * (number / colors) + number % colors;
        let lookup = corner_data[triangle.data + select(number, of_lens, REFRACTS == 1)];
        low = min(low, lookup.xy / lookup.z);
        high = max(high, lookup.xy / lookup.z);
    }
    let margin = MARGIN / projection.size.xy;
    let corner = index % 6u;
    let place = select(low - margin, high + margin, vec2<bool>(corner % 2u == 1u, corner > 1u && corner < 5u));
    return vec4f(place * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0);
}
