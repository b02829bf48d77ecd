// Trilinear projection: what the rays of an image's ray triangles see, coloured.
// needs: methods/trilinear/sighting.wgsl

// 1 where some surfaces seen may be specular fronts.
override MEETS_SPECULAR: bool = false;
// 1 where some ray triangles are on lenses.
override GLASS: bool = false;
// 1 where the rays are sent on by what others see.
override FOLLOWS: bool = false;

fn from_axis(lens: Lens, point: vec3f) -> vec3f {
    let offset = point - lens.middle.xyz;
    return offset - dot(offset, lens.axis.xyz) * lens.axis.xyz;
}

// Whether a ray leaves its lens by the edge.
fn by_edge(fragment: RayFragment, sighting: Sighting) -> bool {
    let lens = lenses[max(fragment.numbers.z, 1u) - 1u];
    return fragment.numbers.z > 0u && length(from_axis(lens, sighting.ray.origin)) > lens.axis.w;
}

// The diffuse edge, seen from within the glass.
fn edge_color(lens: Lens, ray: Ray) -> vec3f {
    var point: SurfacePoint;
    point.position = ray.origin;
    point.normal = normalize(from_axis(lens, ray.origin));
    point.color = vec3f(1.0);
    point.object = u32(max(lens.middle.w, 1.0));
    return select(vec3f(0.0), shade(point, ray.direction), lens.middle.w > 0.0);
}

fn incident(fragment: RayFragment) -> vec3f {
    let place = place_of(fragment);
    return normalize(fragment.incident_x.xyz * place.x + fragment.incident_y * place.y + fragment.incident_one);
}

// What share of the light that is seen reaches the eye, by colour.
fn transmitted(fragment: RayFragment, sighting: Sighting) -> vec3f {
    var transmittance = vec3f(1.0);
    if fragment.numbers.x > 0u {
        transmittance = mirror_reflectance(fragment.numbers.x, 0.5 * length(sighting.ray.direction - incident(fragment)));
        if GLASS && fragment.numbers.z > 0u {
            transmittance = sighting.transmittance * lens_tint(fragment.numbers.x);
        }
    }
    if FOLLOWS {
        transmittance *= textureLoad(throughput, vec2u(fragment.pixel.xy), 0).rgb;
    }
    return transmittance;
}

// The light of a colour that is seen, as it reaches the eye.
fn arriving(fragment: RayFragment, sighting: Sighting, color: vec3f) -> vec4f {
    if GLASS && fragment.numbers.z > 0u && (by_edge(fragment, sighting) || fragment.numbers.w == TOTAL) {
        let cosine = dot(incident(fragment), normalize(fragment.normal));
        let edge = edge_color(lenses[fragment.numbers.z - 1u], sighting.ray);
        return vec4f(glass_transmittance(fragment.numbers.x, cosine) * edge, 1.0);
    }
    return vec4f(transmitted(fragment, sighting) * color, 1.0);
}

// Specular fronts look as if nothing followed, until what follows is drawn over them.
fn end_color(sighting: Sighting, texel: vec2u) -> vec3f {
    var color = shade(point_seen(sighting, texel), sighting.ray.direction);
    if MEETS_SPECULAR {
        color = select(color, sighted_sky(sighting), sighting.specular);
    }
    return color;
}

@fragment
fn surface_color(fragment: RayFragment) -> @location(0) vec4f {
    if !is_own(fragment) {
        discard;
    }
    let sighting = pixel_sighting(fragment);
    return arriving(fragment, sighting, end_color(sighting, vec2u(fragment.pixel.xy)));
}

@fragment
fn sky_seen_color(fragment: RayFragment) -> @location(0) vec4f {
    if !is_own(fragment) {
        discard;
    }
    let sighting = pixel_sighting(fragment);
    return arriving(fragment, sighting, sighted_sky(sighting));
}

// For the rays that go on from specular fronts.
@fragment
fn throughput_color(fragment: RayFragment) -> @location(0) vec4f {
    let sighting = pixel_sighting(fragment);
    if !is_own(fragment) || !sighting.specular {
        discard;
    }
    return vec4f(transmitted(fragment, sighting), 1.0);
}

// Where a ray's path ends, and how.
struct End {
    point: vec4f,
    status: u32,
}

fn end_of(fragment: RayFragment, sighting: Sighting) -> End {
    let nowhere = vec4f(sighting.ray.direction, 0.0);
    if !is_own(fragment) {
        return End(nowhere, STATUS_OUTSIDE);
    }
    if GLASS && fragment.numbers.z > 0u && (by_edge(fragment, sighting) || fragment.numbers.w == TOTAL) {
        let edge = vec4f(sighting.ray.origin, lenses[fragment.numbers.z - 1u].middle.w);
        return End(edge, select(STATUS_TOTAL_REFLECTION, STATUS_PROJECTED, by_edge(fragment, sighting)));
    }
    if GLASS && fragment.numbers.w == ENDS {
        return End(vec4f(sighting.ray.origin, f32(fragment.numbers.x)), STATUS_OUTSIDE);
    }
    if sighting.triangle == 0u {
        return End(nowhere, STATUS_SKY);
    }
    let point = point_seen(sighting, vec2u(fragment.pixel.xy));
    return End(vec4f(point.position, f32(point.object)), select(STATUS_PROJECTED, STATUS_OUTSIDE, sighting.specular));
}

@fragment
fn end_seen(fragment: RayFragment) -> Seen {
    if FOLLOWS && !is_own(fragment) {
        discard;
    }
    let end = end_of(fragment, pixel_sighting(fragment));
    return Seen(end.point, seen_flags(fragment.first, end.status), 0.0);
}
