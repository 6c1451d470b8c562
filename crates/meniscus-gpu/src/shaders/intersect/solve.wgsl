// The first change of side along a stretch: eight samples at a time, with a proven bound on what the
// field can do between them; twin of intersect/solve/, where the proof stands.
//
// φ = F − T for a ray outside, T − F for one inside.

// The blobs that the stretches of all rays on their way meet: c (counted from `base` along the ray), β,
// g₀, weight. Lane after lane, so that a workgroup's accesses lie side by side. Not in private memory,
// which would be filled with zeros for each ray.
@group(0) @binding(3) var<storage, read_write> met_blobs: array<vec4f>;
// The word of each.
@group(0) @binding(4) var<storage, read_write> met_words: array<u32>;
// Where this ray's are.
var<private> first_met: u32;
var<private> count: u32;
var<private> base: f32;

var<private> is_inside: bool;

fn met(index: u32) -> vec4f {
    return met_blobs[first_met + index * WORKGROUP];
}

fn met_word(index: u32) -> u32 {
    return met_words[first_met + index * WORKGROUP];
}

fn keep(index: u32, blob: vec4f, word: u32) {
    met_blobs[first_met + index * WORKGROUP] = blob;
    met_words[first_met + index * WORKGROUP] = word;
}

// Relative rounding of a sum of kernels in f32: below this φ has no sign.
const NOISE: f32 = 4e-7;
// Relative rounding of a slope, with a margin.
const SLOPE_NOISE: f32 = 1e-5;
// Kept back of a stretch that is proven, for the rounding of the proof itself.
const KEPT_BACK: f32 = 1e-3;
// Intervals waiting for a closer look; each level of refinement leaves at most one behind.
const PENDING: u32 = 32u;

const SAMPLES: u32 = 8u;
const LAST: u32 = SAMPLES - 1u;

// How the ray came to the start of the segment.
// On the side that is assumed; if the field says otherwise here, the surface lies at this seam.
const CONFIRMED: u32 = 0u;
// At the ray's own start, where rounding may show the other side.
const UNCONFIRMED: u32 = 1u;
// The ray has yet to come to its side.
const RETURNING: u32 = 2u;

struct Verdict {
    kind: u32,
    at: f32,
}

// The surface, at this place.
const CROSSING: u32 = 0u;
// No crossing; the ray was seen on its side.
const STAYS_ON_SIDE: u32 = 1u;
// It takes float64 to tell.
const UNCLEAR: u32 = 2u;
// No crossing: the whole segment lies on the other side.
const NEVER_ON_SIDE: u32 = 3u;

// Numbers at eight places.
struct Eight {
    low: vec4f,
    high: vec4f,
}

fn pick(numbers: Eight, index: u32) -> f32 {
    return select(numbers.low[index & 3u], numbers.high[index & 3u], index > 3u);
}

// Bit i: number i is at least 0.
fn at_least_zero(numbers: Eight) -> u32 {
    let low = select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), numbers.low >= vec4f(0.0));
    let high = select(vec4u(0u), vec4u(16u, 32u, 64u, 128u), numbers.high >= vec4f(0.0));
    let bits = low | high;
    return bits.x | bits.y | bits.z | bits.w;
}

// φ at eight places.
fn sample(at: Eight) -> Eight {
    var low = vec4f(0.0);
    var high = vec4f(0.0);
    for (var i = 0u; i < count; i++) {
        let blob = met(i);
        let away_low = at.low - blob.x;
        let away_high = at.high - blob.x;
        let g_low = max(blob.z - blob.y * away_low * away_low, vec4f(0.0));
        let g_high = max(blob.z - blob.y * away_high * away_high, vec4f(0.0));
        low += blob.w * kernel_of_g(g_low);
        high += blob.w * kernel_of_g(g_high);
    }
    let sign = select(1.0, -1.0, is_inside);
    return Eight((low - params.threshold) * sign, (high - params.threshold) * sign);
}

// Bounds (−φ″, +φ″) over [from_at, to_at], from the blobs whose support meets it.
fn bend(from_at: f32, to_at: f32) -> vec2f {
    var bounds = vec2f(0.0);
    for (var i = 0u; i < count; i++) {
        let blob = met(i);
        let away = clamp(blob.x, from_at, to_at) - blob.x;
        if blob.z - blob.y * away * away > 0.0 {
            let steepness = blob.y * abs(blob.w);
            let g = max(blob.z, 0.0);
            let terms = steepness * vec2f(kernel_concave_bound(g), kernel_convex_bound(g));
            bounds += select(terms, terms.yx, blob.w < 0.0);
        }
    }
    return select(bounds, bounds.yx, is_inside);
}

// Behind this place all blobs recede, so that their field falls; huge where some weight is negative.
fn last_approach() -> f32 {
    var last = -3e38;
    for (var i = 0u; i < count; i++) {
        let blob = met(i);
        if blob.z > 0.0 {
            last = max(last, select(blob.x, 3e38, blob.w < 0.0));
        }
    }
    return last;
}

// φ and its slope at a place, rounded up but for the rounding of positions: twin of Departure.
fn departure(at: f32) -> vec2f {
    var value = 0.0;
    var slope = 0.0;
    var size = 0.0;
    for (var i = 0u; i < count; i++) {
        let blob = met(i);
        let away = at - blob.x;
        let pull = away * blob.y;
        let g = max(blob.z - pull * away, 0.0);
        let term = blob.w * kernel_slope(g) * pull;
        value += blob.w * kernel_of_g(vec4f(g)).x;
        slope -= term;
        size += abs(term);
    }
    let sign = select(1.0, -1.0, is_inside);
    return vec2f(
        sign * (value - params.threshold) + NOISE * max(params.threshold, 1.0),
        sign * 2.0 * slope + 2.0 * SLOPE_NOISE * size,
    );
}

// How far behind the place φ, said to be below 0 there, stays below 0 for sure; negative if it need
// not fall.
fn stays_below_for(start: vec2f, bends: vec2f) -> f32 {
    let extra = max(bends.x, bends.y) * params.rounding;
    let slope = start.y + extra;
    let value = start.x + (abs(slope) + extra) * params.rounding;
    let square = slope * slope - 2.0 * bends.y * value;
    // Less falls below 0 only barely.
    if slope >= 0.0 || square < 0.25 * slope * slope {
        return -1.0;
    }
    if bends.y <= 0.0 {
        return 3e38;
    }
    return (1.0 - KEPT_BACK) * (sqrt(square) - slope) / bends.y;
}

fn first_crossing(segment_from: f32, length: f32, entry: u32, tolerance: f32) -> Verdict {
    // While returning the search is for the side that the ray is said to start on: φ is negated, and
    // what is found is where the search proper begins.
    var returning = entry != CONFIRMED;
    // Seen from outside: where φ has not reached 0 by then it never will.
    var end = length;
    if !is_inside {
        end = min(length, max(last_approach() + params.rounding, segment_from));
    }
    var from_at = segment_from;
    var to_at = length;
    var falls_at_start = false;
    if entry == UNCONFIRMED {
        if end <= segment_from {
            return Verdict(STAYS_ON_SIDE, 0.0);
        }
        let start = departure(segment_from);
        falls_at_start = start.y < 0.0;
        if falls_at_start {
            let safe = stays_below_for(start, bend(segment_from, end));
            if safe >= 0.0 {
                if segment_from + safe >= end {
                    return Verdict(STAYS_ON_SIDE, 0.0);
                }
                from_at = segment_from + safe;
                to_at = end;
                returning = false;
            }
        }
    } else if entry == CONFIRMED {
        to_at = end;
    }

    var waiting: array<vec2f, PENDING>;
    waiting[0] = vec2f(from_at, to_at);
    var depth = 1u;
    var is_aimed = false;
    var aim = 0.0;
    var bends = vec2f(0.0);
    var at_start = true;
    let scale = max(params.threshold, 1.0);
    while depth > 0u {
        depth -= 1u;
        from_at = waiting[depth].x;
        to_at = waiting[depth].y;
        let span = to_at - from_at;
        var at: Eight;
        var gap: Eight;
        if is_aimed {
            let before = aim - from_at;
            let behind = to_at - aim;
            let widest = max(before, behind);
            at = Eight(
                aim + before * vec4f(-1.0, -0.1, -0.01, -0.001),
                aim + behind * vec4f(0.001, 0.01, 0.1, 1.0),
            );
            gap = Eight(
                widest * vec4f(0.9, 0.9, 0.09, 0.009),
                widest * vec4f(0.009, 0.09, 0.9, 0.9),
            );
        } else {
            at = Eight(
                from_at + span * (vec4f(0.0, 1.0, 2.0, 3.0) / 7.0),
                from_at + span * (vec4f(4.0, 5.0, 6.0, 7.0) / 7.0),
            );
            gap = Eight(vec4f(span / 7.0), vec4f(span / 7.0));
            bends = bend(from_at, to_at);
        }
        var phi = sample(at);
        if returning {
            phi = Eight(-phi.low, -phi.high);
        }
        if at_start {
            at_start = false;
            let beyond = phi.low.x >= 0.0;
            if beyond && !returning {
                return Verdict(CROSSING, from_at);
            }
            if beyond {
                phi = Eight(-phi.low, -phi.high);
                returning = false;
            } else if returning && entry == UNCONFIRMED
                && (phi.low.y < 0.0 || !falls_at_start) {
                return Verdict(UNCLEAR, from_at);
            }
        }
        let fall = select(bends.x, bends.y, returning);
        let rise = select(bends.y, bends.x, returning);
        let band = Eight(
            phi.low + gap.low * gap.low * (0.125 * fall),
            phi.high + gap.high * gap.high * (0.125 * fall),
        );
        let candidates = at_least_zero(band);
        is_aimed = false;
        if candidates == 0u {
            continue;
        }
        // The first place is on the near side by construction, whatever rounding says.
        let crossed = at_least_zero(phi) & ~1u;
        let k = firstTrailingBit(candidates);
        let left = max(k, 1u) - 1u;
        let right = select(min(k + 1u, LAST), k, ((crossed >> k) & 1u) == 1u);
        let at_left = select(pick(at, left), from_at, left == 0u);
        let at_right = select(pick(at, right), to_at, right == LAST);
        let width = at_right - at_left;
        let is_sure = ((crossed >> right) & 1u) == 1u;
        // No closer look can tell more than rounding allows.
        let is_fine = 0.125 * fall * width * width <= NOISE * scale
            || width <= 1e-7 * (length - segment_from)
            || depth + 2u > PENDING;
        var next_is_aimed = false;
        if is_sure {
            let low = min(pick(phi, left), 0.0);
            let high = pick(phi, right);
            let most = max(fall, rise);
            if returning {
                // Steep enough to cross only once.
                if is_fine || high - low > 0.5 * most * width * width {
                    returning = false;
                    waiting[0] = vec2f(at_right, length);
                    depth = select(0u, 1u, at_right < length);
                    continue;
                }
            } else {
                let fraction = select(0.0, low / (low - high), high > low);
                if is_fine || most * width * width * width <= 8.0 * tolerance * (high - low) {
                    return Verdict(CROSSING, at_left + width * clamp(fraction, 0.0, 1.0));
                }
                // Not at the very ends, where samples would fall into each other's rounding.
                aim = at_left + width * clamp(fraction, 0.1, 0.9);
                next_is_aimed = true;
            }
        }
        // Kept even where a crossing is sure: rounding may hide it from the closer look.
        if right < LAST && at_right > from_at {
            waiting[depth] = vec2f(at_right, to_at);
            depth += 1u;
        }
        if is_fine && !is_sure {
            continue;
        }
        waiting[depth] = vec2f(at_left, at_right);
        depth += 1u;
        is_aimed = next_is_aimed;
    }
    return Verdict(select(STAYS_ON_SIDE, NEVER_ON_SIDE, returning), 0.0);
}
