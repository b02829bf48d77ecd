// The one place where a surface point gets a colour.

struct Light {
    // Directional: unit vector toward the light. Point: its position.
    place: vec3f,
    // 0: directional, 1: point.
    kind: u32,
    color: vec3f,
    // 1 for the last one.
    last: u32,
}

// Nothing in here that is at a fixed place may decide a branch or end a loop: software Vulkan then compiles the shader
// for its value, and keeps what it has compiled for every buffer that it ever saw.
struct Lighting {
    ambient_sky: vec3f,
    padding_0: f32,
    ambient_ground: vec3f,
    padding_1: f32,
    zenith: vec3f,
    padding_2: f32,
    horizon: vec3f,
    padding_3: f32,
    nadir: vec3f,
    padding_4: f32,
    lights: array<Light, 1024>,
}

// Taps of the texture filter: footprints up to so many times as long as wide stay sharp.
const MAXIMUM_TAPS = 8.0;

// Images are half floats; what is beyond the largest would be infinite on some devices, and NaN after a blend.
const LARGEST_HALF = 65504.0;

// 0 where it is known that no image replaces the sky's gradient, and that no object has a texture: constants, because
// software runs what a branch leaves out.
override SKY_IMAGE: i32 = 1;
override TEXTURES: i32 = 1;

// kind of an object
const DIFFUSE = 0u;
const MIRROR = 1u;

// Of what a texture_layer holds.
const LAYER_BITS = 0xffffu;
const WRAP_ACROSS_SHIFT = 16u;
const WRAP_DOWN_SHIFT = 18u;
const WRAP_BITS = 3u;

// What lies beyond a texture's edges: the texture again, the texels of the edge, or the texture turned over.
const CLAMP = 1u;
const MIRRORED = 2u;

struct Object {
    color: vec3f,
    // Layer of the texture array, in LAYER_BITS; layer 0 is white. Above: what lies beyond its edges, across and down.
    texture_layer: u32,
    tint: vec3f,
    // A mirror's reflectance at normal incidence, a glass's refractive index.
    parameter: f32,
    kind: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

struct SurfacePoint {
    position: vec3f,
    normal: vec3f,
    texcoord: vec2f,
    // How the texture coordinates change to the next pixel.
    texcoord_dx: vec2f,
    texcoord_dy: vec2f,
    color: vec3f,
    object: u32,
}

// What colours the points of an object.
struct Paint {
    color: vec3f,
    texture_layer: u32,
}

@group(0) @binding(0) var<uniform> lighting: Lighting;
// Indexed by object number less one.
@group(0) @binding(1) var<storage, read> objects: array<Object>;
@group(0) @binding(2) var diffuse_textures: texture_2d_array<f32>;
@group(0) @binding(3) var diffuse_sampler: sampler;
@group(0) @binding(4) var sky_texture: texture_2d<f32>;
@group(0) @binding(5) var sky_sampler: sampler;

// The place in the first copy of a texture that shows what `place` does, along one axis. The sampler repeats: where a
// texture does not, no place is nearer to its edge than half a texel, and so none is blended with the far edge.
fn wrapped(place: f32, wrap: u32, half_texel: f32) -> f32 {
    let folded = select(place, 1.0 - abs(1.0 - (place - 2.0 * floor(0.5 * place))), wrap == MIRRORED);
    return select(clamp(folded, half_texel, 1.0 - half_texel), place, wrap == 0u);
}

// The texture's mean over the pixel's slanted footprint: taps along its longer axis, each as wide as its shorter one.
// The sampler's own anisotropic filter is the same idea, but ten times slower on software Vulkan.
fn filtered_texel(point: SurfacePoint, texture_layer: u32) -> vec3f {
    let size = f32(textureDimensions(diffuse_textures).x);
    let dx = point.texcoord_dx;
    let dy = point.texcoord_dy;
    let longer = select(dy, dx, dot(dx, dx) > dot(dy, dy));
    let major = max(length(longer), 1e-12);
    let minor = abs(dx.x * dy.y - dx.y * dy.x) / major;
    // No more taps than texels: a magnified texture needs one.
    let taps = clamp(ceil(min(major / max(minor, 1e-12), major * size)), 1.0, MAXIMUM_TAPS);
    let level = log2(max(major / taps, minor) * size);
    let layer = texture_layer & LAYER_BITS;
    let wrap_across = (texture_layer >> WRAP_ACROSS_SHIFT) & WRAP_BITS;
    let wrap_down = (texture_layer >> WRAP_DOWN_SHIFT) & WRAP_BITS;
    // Of the coarser one of the two levels that are blended.
    let half_texel = min(0.5 * exp2(ceil(max(level, 0.0))) / size, 0.5);
    var sum = vec3f(0.0);
    var tap = 0.5;
    // The test comes last, here and at the lights: software runs what a loop holds once more when it begins with one.
    loop {
        let place = point.texcoord + longer * (tap / taps - 0.5);
        let across = wrapped(place.x, wrap_across, half_texel);
        let down = wrapped(place.y, wrap_down, half_texel);
        sum += textureSampleLevel(diffuse_textures, diffuse_sampler, vec2f(across, down), layer, level).rgb;
        tap += 1.0;
        // Of a footprint without end the taps may be no number.
        if !(tap < taps) {
            break;
        }
    }
    return sum / taps;
}

fn paint_of(object: u32) -> Paint {
    return Paint(objects[object - 1u].color, objects[object - 1u].texture_layer);
}

// Diffuse colour of a point whose normal is turned to the side it is seen from.
fn shade(point: SurfacePoint, direction: vec3f) -> vec3f {
    return shade_painted(point, paint_of(point.object), direction);
}

// The same where the object's paint is known: to look it up for each fragment is slow on software Vulkan.
fn shade_painted(point: SurfacePoint, paint: Paint, direction: vec3f) -> vec3f {
    let normal = faceForward(point.normal, direction, point.normal);
    var light = mix(lighting.ambient_ground, lighting.ambient_sky, 0.5 + 0.5 * normal.y);
    var i = 0u;
    // Where there is no light, there is a black one.
    loop {
        let source = lighting.lights[i];
        var toward = source.place;
        var strength = 1.0;
        if source.kind == 1u {
            let offset = source.place - point.position;
            let square = max(dot(offset, offset), 1e-8);
            toward = offset * inverseSqrt(square);
            strength = 1.0 / square;
        }
        light += source.color * (strength * max(dot(normal, toward), 0.0));
        if source.last == 1u {
            break;
        }
        i++;
    }
    var color = light * paint.color * point.color;
    if TEXTURES == 1 && paint.texture_layer > 0u {
        color *= filtered_texel(point, paint.texture_layer);
    }
    return min(color, vec3f(LARGEST_HALF));
}

// What a ray sees that hits nothing; `spread` is the angle of a pixel, radians.
fn sky_color(direction: vec3f, spread: f32) -> vec3f {
    let unit = normalize(direction);
    let width = f32(textureDimensions(sky_texture).x);
    // Without an image, the texture is a single texel wide.
    if SKY_IMAGE == 1 && width > 1.0 {
        let level = max(log2(spread * width / 6.2831853), 0.0);
        let u = 0.5 + atan2(unit.x, -unit.z) / 6.2831853;
        let v = acos(clamp(unit.y, -1.0, 1.0)) / 3.14159265;
        return textureSampleLevel(sky_texture, sky_sampler, vec2f(u, v), level).rgb;
    }
    return mix(lighting.horizon, select(lighting.nadir, lighting.zenith, unit.y > 0.0), sqrt(abs(unit.y)));
}

// Whether an object is a mirror or of glass.
fn is_specular(number: u32) -> bool {
    return objects[number - 1u].kind != DIFFUSE;
}

fn is_mirror(number: u32) -> bool {
    return objects[number - 1u].kind == MIRROR;
}

// The tint of a mirror or of glass.
fn tint_of(number: u32) -> vec3f {
    return objects[number - 1u].tint;
}

// A mirror's tint, and its reflectance at normal incidence.
fn silver_of(number: u32) -> vec4f {
    return vec4f(tint_of(number), objects[number - 1u].parameter);
}

// Tint and Schlick's reflectance of a mirror at the cosine between its normal and the ray.
fn schlick(silver: vec4f, cosine: f32) -> vec3f {
    let rest = pow(1.0 - clamp(abs(cosine), 0.0, 1.0), 5.0);
    return silver.rgb * (silver.w + (1.0 - silver.w) * rest);
}

fn mirror_reflectance(number: u32, cosine: f32) -> vec3f {
    return schlick(silver_of(number), cosine);
}

// What glass lets through of the light that crosses it twice, but for Fresnel's share.
fn lens_tint(number: u32) -> vec3f {
    let tint = objects[number - 1u].tint;
    return tint * tint;
}

// What glass lets in of light at the cosine between its normal and the ray: tint, and Fresnel's transmittance.
fn glass_transmittance(number: u32, cosine: f32) -> vec3f {
    let object = objects[number - 1u];
    let outer = abs(cosine);
    let square = object.parameter * object.parameter;
    let inner = sqrt(square + outer * outer - 1.0);
    let reflected = vec2f((outer - inner) / (outer + inner), (square * outer - inner) / (square * outer + inner));
    return object.tint * (1.0 - 0.5 * dot(reflected, reflected));
}

// The front of a mirror where no method draws it: the sky alone. Glass never gets here: whoever draws it draws it all.
fn specular_stand_in(number: u32, normal: vec3f, direction: vec3f, spread: f32) -> vec3f {
    return mirror_reflectance(number, dot(normal, direction)) * sky_color(reflect(direction, normal), spread);
}
