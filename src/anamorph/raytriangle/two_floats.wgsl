// Numbers as sums of two floats: 48 bits where f32 has 24. Three at a time; what is not needed of them costs nothing.
// needs: raytriangle/points.wgsl
// Source: Dekker 1971, Knuth's two-sum. `sealing` returns 0u, read from a buffer.

struct Two {
    hi: vec3f,
    lo: vec3f,
}

// x itself. Compilers may take a sum apart, put it together in another order or fuse it with a product, each of which
// undoes what follows; of a number that has been through this, they know nothing.
fn sealed(x: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(x) ^ vec3u(sealing()));
}

fn exact_sum(a: vec3f, b: vec3f) -> Two {
    let sum = sealed(a + b);
    let second = sealed(sum - a);
    return Two(sum, sealed(a - sealed(sum - second)) + sealed(b - second));
}

// Where |a| >= |b|, or a is 0.
fn ordered_sum(a: vec3f, b: vec3f) -> Two {
    let sum = sealed(a + b);
    return Two(sum, b - sealed(sum - a));
}

fn exact_product(a: vec3f, b: vec3f) -> Two {
    let product = sealed(a * b);
    // Halves of 12 bits, whose products are exact. Not with fma(), which may round twice.
    let a_hi = bitcast<vec3f>(bitcast<vec3u>(a) & vec3u(0xfffff000u));
    let b_hi = bitcast<vec3f>(bitcast<vec3u>(b) & vec3u(0xfffff000u));
    let a_lo = sealed(a - a_hi);
    let b_lo = sealed(b - b_hi);
    let most = sealed(sealed(a_hi * b_hi) - product);
    return Two(product, sealed(sealed(most + sealed(a_hi * b_lo)) + sealed(a_lo * b_hi)) + a_lo * b_lo);
}

fn two(x: vec3f) -> Two {
    return Two(x, vec3f());
}

fn plus(a: Two, b: Two) -> Two {
    let high = exact_sum(a.hi, b.hi);
    let low = exact_sum(a.lo, b.lo);
    let sum = ordered_sum(high.hi, high.lo + low.hi);
    return ordered_sum(sum.hi, sum.lo + low.lo);
}

fn minus(a: Two, b: Two) -> Two {
    return plus(a, Two(-b.hi, -b.lo));
}

fn times(a: Two, b: Two) -> Two {
    let product = exact_product(a.hi, b.hi);
    return ordered_sum(product.hi, product.lo + (a.hi * b.lo + a.lo * b.hi));
}

// By a power of two, which is exact.
fn scaled(a: Two, power: f32) -> Two {
    return Two(a.hi * power, a.lo * power);
}

// The scalar product, in all three places.
fn inner(a: Two, b: Two) -> Two {
    let p = times(a, b);
    return plus(plus(Two(p.hi.xxx, p.lo.xxx), Two(p.hi.yyy, p.lo.yyy)), Two(p.hi.zzz, p.lo.zzz));
}

fn vector_product(a: Two, b: Two) -> Two {
    let first = times(Two(a.hi.yzx, a.lo.yzx), Two(b.hi.zxy, b.lo.zxy));
    return minus(first, times(Two(a.hi.zxy, a.lo.zxy), Two(b.hi.yzx, b.lo.yzx)));
}

// The greatest power of two that is not greater than x, and 1 for 0.
fn power_of_two(x: f32) -> f32 {
    let power = bitcast<f32>(bitcast<u32>(x) & 0x7f800000u);
    return select(1.0, power, power > 0.0);
}
