// Random numbers that depend only on pixel, sample and draw, and the shapes drawn with them: twin of
// math/sampling.rs, whose numbers these are to the last bit. Words of 64 bits are (low, high).

const PI: f32 = 3.14159265358979;
const TAU: f32 = 6.28318530717959;
const FRAC_1_PI: f32 = 0.318309886183791;

struct PixelSampler {
    seed: vec2u,
    index: u32,
}

fn product_of(a: u32, b: u32) -> vec2u {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let first = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let second = (a & 0xffffu) * (b >> 16u) + (first & 0xffffu);
    let high = (a >> 16u) * (b >> 16u) + (first >> 16u) + (second >> 16u);
    return vec2u((second << 16u) | (low & 0xffffu), high);
}

fn times(a: vec2u, b: vec2u) -> vec2u {
    let product = product_of(a.x, b.x);
    return vec2u(product.x, product.y + a.x * b.y + a.y * b.x);
}

fn plus(a: vec2u, b: vec2u) -> vec2u {
    let low = a.x + b.x;
    return vec2u(low, a.y + b.y + select(0u, 1u, low < a.x));
}

fn shifted_right(a: vec2u, bits: u32) -> vec2u {
    return vec2u((a.x >> bits) | (a.y << (32u - bits)), a.y >> bits);
}

// The finaliser of SplitMix64.
fn mix_bits(given: vec2u) -> vec2u {
    var bits = plus(given, vec2u(0x7f4a7c15u, 0x9e3779b9u));
    bits = times(bits ^ shifted_right(bits, 30u), vec2u(0x1ce4e5b9u, 0xbf58476du));
    bits = times(bits ^ shifted_right(bits, 27u), vec2u(0x133111ebu, 0x94d049bbu));
    return bits ^ shifted_right(bits, 31u);
}

const SEQUENCE_LENGTH: u32 = 65536u;

fn pixel_sampler(pixel: vec2u, sample: u32, seed: u32) -> PixelSampler {
    let series = vec2u(seed, sample / SEQUENCE_LENGTH);
    return PixelSampler(mix_bits(mix_bits(pixel) ^ series), sample % SEQUENCE_LENGTH);
}

// The seed of draw `draw`, from 0.
fn draw_seed(sampler: PixelSampler, draw: u32) -> u32 {
    return mix_bits(sampler.seed ^ vec2u(draw + 1u, 0u)).y;
}

// Sobol points, scrambled as in the crate sobol_burley (Burley 2020).
fn scrambled(given: u32, scramble: u32) -> u32 {
    var bits = given ^ (given * 0x3d20adeau);
    bits = (bits + scramble) * ((scramble >> 16u) | 1u);
    bits ^= bits * 0x05526c56u;
    return bits ^ (bits * 0x53a22864u);
}

fn hashed(given: u32) -> u32 {
    var bits = given ^ 0xe6fe3bebu;
    bits = (bits ^ (bits >> 16u)) * 0x7feb352du;
    bits = (bits ^ (bits >> 15u)) * 0x846ca68bu;
    return bits ^ (bits >> 16u);
}

fn unit_of(bits: u32) -> f32 {
    return bitcast<f32>((bits >> 9u) | 0x3f800000u) - 1.0;
}

// Rows of Pascal's triangle modulo 2: the direction vectors of the second dimension.
fn second_dimension(index: u32) -> u32 {
    var row = 1u;
    var sum = 0u;
    for (var bit = 0u; bit < 16u; bit++) {
        if ((index >> bit) & 1u) != 0u {
            sum ^= row;
        }
        row ^= row << 1u;
    }
    return sum;
}

fn sobol(index: u32, seed: u32, two: bool) -> vec2f {
    let shuffled = scrambled(reverseBits(index), hashed(seed ^ 0x79c68e4au));
    let place = reverseBits(shuffled & 0xffff0000u);
    let scramble = seed * 0x9c8f2d3bu;
    let x = unit_of(reverseBits(scrambled(place, hashed(scramble ^ 0x912f69bau))));
    if !two {
        return vec2f(x, 0.0);
    }
    let second = second_dimension(place);
    return vec2f(x, unit_of(reverseBits(scrambled(second, hashed(scramble ^ 0x174f18abu)))));
}

fn draw_1d(sampler: PixelSampler, draw: u32) -> f32 {
    return sobol(sampler.index, draw_seed(sampler, draw), false).x;
}

// Of which nothing is known from other samples' numbers.
fn draw_unordered(sampler: PixelSampler, draw: u32) -> f32 {
    let bits = mix_bits(sampler.seed ^ vec2u(draw + 1u, sampler.index + 1u)).y;
    return f32(bits >> 8u) * (1.0 / 16777216.0);
}

fn draw_2d(sampler: PixelSampler, draw: u32) -> vec2f {
    return sobol(sampler.index, draw_seed(sampler, draw), true);
}

// Point `k` of the `count` that draw `draw` is.
fn draw_2d_of(sampler: PixelSampler, draw: u32, count: u32, k: u32) -> vec2f {
    var seed = draw_seed(sampler, draw);
    let place = sampler.index * count + k;
    let series = place / SEQUENCE_LENGTH;
    if series != 0u {
        seed = mix_bits(vec2u(seed, series)).x;
    }
    return sobol(place % SEQUENCE_LENGTH, seed, true);
}

// Cosine and sine of an angle of a few turns at most, to some ulps on every driver: WGSL allows its own an
// error of 2⁻¹¹, a thousand times what decides where a ray goes. Polynomials of the Cephes library.
fn cos_sin(angle: f32) -> vec2f {
    let quarter = round(angle * (4.0 / TAU));
    // A quarter turn in two parts, so that the product is exact.
    let x = (angle - quarter * 1.5703125) - quarter * 4.8382679e-4;
    let z = x * x;
    let s = ((-1.9515296e-4 * z + 8.3321609e-3) * z - 0.16666655) * z * x + x;
    let c = ((2.4433157e-5 * z - 1.3887316e-3) * z + 4.1666646e-2) * z * z - 0.5 * z + 1.0;
    switch i32(quarter) & 3 {
        case 0: { return vec2f(c, s); }
        case 1: { return vec2f(-s, c); }
        case 2: { return vec2f(-c, -s); }
        default: { return vec2f(s, -c); }
    }
}

// The angle of (x, y) from the x axis, −π to π, as exact.
fn arc_tan2(y: f32, x: f32) -> f32 {
    let least = min(abs(x), abs(y));
    let most = max(abs(x), abs(y));
    if most == 0.0 {
        return 0.0;
    }
    var t = least / most;
    var angle = 0.0;
    if t > 0.41421356 {
        t = (t - 1.0) / (t + 1.0);
        angle = 0.25 * PI;
    }
    let z = t * t;
    angle += (((8.0537445e-2 * z - 0.13877686) * z + 0.19977711) * z - 0.33332949) * z * t + t;
    angle = select(angle, 0.5 * PI - angle, abs(y) > abs(x));
    angle = select(angle, PI - angle, x < 0.0);
    return select(angle, -angle, y < 0.0);
}

fn uniform_disk(u: vec2f) -> vec2f {
    let p = 2.0 * u - 1.0;
    if p.x == 0.0 && p.y == 0.0 {
        return vec2f(0.0);
    }
    var radius = p.y;
    var angle = 0.5 * PI - 0.25 * PI * (p.x / p.y);
    if abs(p.x) > abs(p.y) {
        radius = p.x;
        angle = 0.25 * PI * (p.y / p.x);
    }
    return radius * cos_sin(angle);
}

// A unit direction around z, with density cos θ/π.
fn cosine_lobe(u: vec2f) -> vec3f {
    let p = uniform_disk(u);
    return normalize(vec3f(p, sqrt(max(1.0 - dot(p, p), 0.0))));
}

fn cosine_hemisphere(normal: vec3f, u: vec2f) -> vec3f {
    let local = cosine_lobe(u);
    let frame = tangents(normal);
    return normalize(frame[0] * local.x + frame[1] * local.y + normal * local.z);
}

fn uniform_sphere(u: vec2f) -> vec3f {
    let z = 1.0 - 2.0 * u.x;
    let radius = sqrt(max(1.0 - z * z, 0.0));
    return vec3f(radius * cos_sin(TAU * u.y), z);
}

// Two unit vectors that complete a unit vector to a right-handed frame (Duff et al. 2017).
fn tangents(normal: vec3f) -> array<vec3f, 2> {
    let sign = select(-1.0, 1.0, normal.z >= 0.0);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    return array(
        vec3f(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        vec3f(b, sign + normal.y * normal.y * a, -normal.y),
    );
}

// A direction within 1 − cos = `height` of an axis, uniform by solid angle.
fn uniform_cap(axis: vec3f, height: f32, u: vec2f) -> vec3f {
    let part = u.x * height;
    // 1 − z² without loss of digits.
    let radius = sqrt(max(part * (2.0 - part), 0.0));
    let frame = tangents(axis);
    let turn = cos_sin(TAU * u.y);
    let around = frame[0] * turn.x + frame[1] * turn.y;
    return normalize(around * radius + axis * (1.0 - part));
}
