// F − T between two events as a polynomial in Bézier form: twin of intersect/sweep/bezier.rs.

const DEGREE: u32 = 2u * POWER;

// Its coefficients, φ = F − T seen from outside and T − F from inside.
var<private> curve: array<f32, DEGREE + 1u>;
// Those of a part of it.
var<private> part: array<f32, DEGREE + 1u>;
// Sizes of what was summed up.
var<private> sizes: f32;

// Relative rounding of a sum of kernels.
const NOISE: f32 = 4e-7;

fn g_at(line: AlongLine, along: f32) -> f32 {
    let away = along - line.c;
    return max(line.g0 - line.beta * away * away, 0.0);
}

// The curve over an interval, from the balls in the slot's list. g of one ball has the coefficients
// g(from), g₀ − β(from − c)(to − c), g(to); coefficients times binomials multiply like those of
// polynomials, which makes k(g) a Horner scheme.
fn expand(from_at: f32, to_at: f32) {
    for (var i = 0u; i <= DEGREE; i++) {
        curve[i] = 0.0;
    }
    sizes = 0.0;
    let length = to_at - from_at;
    for (var index = 0u; index < listed; index++) {
        let ball = ball_in_list(index);
        // Counted from the interval's start.
        let line = ball_on_ray(balls[ball], from_at).line;
        let middle = line.g0 - line.beta * line.c * (line.c - length);
        let g = vec3f(g_at(line, 0.0), 2.0 * max(middle, 0.0), g_at(line, length));
        var k: array<f32, DEGREE + 1u>;
        k[0] = IN_G[POWER];
        for (var power = POWER; power > 0u; power--) {
            // As many are in use.
            let factors = 2u * (POWER - power) + 1u;
            // Times g, in place from the highest down; what is not in use yet is 0.
            for (var i = factors + 1u; i > 0u; i--) {
                var sum = k[i] * g.x + k[i - 1u] * g.y;
                if i > 1u {
                    sum += k[i - 2u] * g.z;
                }
                k[i] = sum;
            }
            k[0] *= g.x;
            let constant = IN_G[power - 1u];
            if constant != 0.0 {
                var binomial = 1.0;
                for (var i = 0u; i <= factors + 1u; i++) {
                    k[i] += constant * binomial;
                    binomial *= f32(factors + 1u - i) / f32(i + 1u);
                }
            }
        }
        let weight = traits[ball].x;
        for (var i = 0u; i <= DEGREE; i++) {
            curve[i] += weight * k[i];
        }
        sizes += abs(weight * kernel_of_g(vec4f(max(line.g0, 0.0))).x);
    }
    let sign = select(1.0, -1.0, is_inside);
    var binomial = 1.0;
    for (var i = 0u; i <= DEGREE; i++) {
        curve[i] = sign * (curve[i] / binomial - params.threshold);
        binomial *= f32(DEGREE - i) / f32(i + 1u);
    }
}

// Sets `part` to the curve over [low, high] by de Casteljau's algorithm.
fn take_part(low: f32, high: f32) {
    part = curve;
    // What lies left of `high`, then of that what lies right of `low`.
    for (var level = DEGREE; level > 0u; level--) {
        for (var i = DEGREE; i > DEGREE - level; i--) {
            part[i] = mix(part[i - 1u], part[i], high);
        }
    }
    let share = select(0.0, low / high, high > 0.0);
    for (var level = DEGREE; level > 0u; level--) {
        for (var i = 0u; i < level; i++) {
            part[i] = mix(part[i], part[i + 1u], share);
        }
    }
}

// Where the hull of the part's control points meets the axis; both signs must occur.
fn hull_on_axis() -> vec2f {
    var low = 1.0;
    var high = 0.0;
    for (var i = 0u; i < DEGREE; i++) {
        for (var j = i + 1u; j <= DEGREE; j++) {
            if (part[i] > 0.0) != (part[j] > 0.0) {
                let share = part[i] / (part[i] - part[j]);
                let x = (f32(i) + f32(j - i) * share) / f32(DEGREE);
                low = min(low, x);
                high = max(high, x);
            }
        }
    }
    return vec2f(low, high);
}

// How often the part's control values change sign, 0 counting as negative.
fn sign_changes() -> u32 {
    var changes = 0u;
    for (var i = 0u; i < DEGREE; i++) {
        changes += u32((part[i] > 0.0) != (part[i + 1u] > 0.0));
    }
    return changes;
}
