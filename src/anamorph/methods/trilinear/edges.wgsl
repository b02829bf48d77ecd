// Several samples a pixel: where they do not all see the same, each thing seen is coloured once.
// needs: methods/trilinear/trilinear.wgsl

const SAMPLES = 4u;

fn sample_at(texel: vec2u, sample: u32) -> vec2u {
    return 2u * texel + vec2u(sample & 1u, sample >> 1u);
}

// Where colours have to be mixed.
@fragment
fn edge_mark(@builtin(position) pixel: vec4f) -> @builtin(frag_depth) f32 {
    let texel = vec2u(pixel.xy);
    let owner = textureLoad(owners, texel, 0).x;
    let seen = textureLoad(triangles_seen, texel, 0).x;
    var differs = false;
    for (var sample = 0u; sample < SAMPLES; sample++) {
        let fine = sample_at(texel, sample);
        let other = textureLoad(samples_seen, fine, 0).x;
        // Rays are continuous from one ray triangle to the next: all that matters is that there are any.
        let none = (textureLoad(sample_owners, fine, 0).x == 0u) != (owner == 0u);
        differs = differs || other != seen || none;
    }
    if !differs {
        discard;
    }
    return 1.0;
}

@fragment
fn edge_color_mixed(fragment: RayFragment) -> @location(0) vec4f {
    let texel = vec2u(fragment.pixel.xy);
    let place = place_of(fragment);
    var seen = array<u32, 4>();
    var offset = array<vec2f, 4>();
    var count = array<f32, 4>();
    var kinds = 0u;
    for (var sample = 0u; sample < SAMPLES; sample++) {
        let fine = sample_at(texel, sample);
        if textureLoad(sample_owners, fine, 0).x == 0u {
            continue;
        }
        let own = textureLoad(samples_seen, fine, 0).x;
        var kind = 0u;
        while kind < kinds && seen[kind] != own {
            kind++;
        }
        kinds = max(kinds, kind + 1u);
        seen[kind] = own;
        offset[kind] += 0.5 * vec2f(vec2u(sample & 1u, sample >> 1u)) - 0.25;
        count[kind] += 1.0;
    }
    var sum = vec4f(0.0);
    for (var kind = 0u; kind < kinds; kind++) {
        let found = sighting(fragment, place + offset[kind] / count[kind], seen[kind]);
        var color = sighted_sky(found);
        if found.triangle > 0u && !found.specular {
            color = shade(point_seen(found, texel), found.ray.direction);
        }
        sum += count[kind] * arriving(fragment, found, color);
    }
    if sum.a == 0.0 {
        discard;
    }
    return sum / sum.a;
}
