// Bézier clipping and halving where nothing is left out without a proof.

// Parts narrower than this are settled by their ends.
const NARROWEST: f32 = 1e-6;
// Clipping that leaves more than this of a part is followed by halving.
const SLOW: f32 = 0.6;
// What clipping leaves beside the hull's crossings for rounding (Campagna et al. 1997).
const CLIP_MARGIN: f32 = 1e-5;
// Each halving leaves at most one part behind, and no part is halved more often than this.
const PENDING: u32 = 24u;
// Parts that are looked at.
const MOST_PARTS: u32 = 400u;

// The first crossing between two neighbouring events; negative: there is none.
fn first_crossing(from_at: f32, to_at: f32) -> f32 {
    if listed == 0u || !(to_at > from_at) {
        return -1.0;
    }
    expand(from_at, to_at);
    let noise = NOISE * (params.threshold + sizes);
    let root = first_rise(noise);
    return select(-1.0, from_at + (to_at - from_at) * root, root >= 0.0);
}

fn first_rise(noise: f32) -> f32 {
    if curve[0] > noise {
        // The surface lies at the seam of two intervals.
        return 0.0;
    }
    // Low, high, and whether the curve ends above 0.
    var pending: array<vec3f, PENDING>;
    pending[0] = vec3f(0.0, 1.0, f32(curve[DEGREE] > 0.0));
    var height = 1u;
    for (var round = 0u; height > 0u && round < MOST_PARTS; round++) {
        height--;
        let low = pending[height].x;
        let high = pending[height].y;
        let ends_above = pending[height].z > 0.0;
        take_part(low, high);
        // The ends' signs are known; rounding does not turn them.
        part[0] = min(part[0], 0.0);
        part[DEGREE] = select(min(part[DEGREE], 0.0), max(part[DEGREE], 1e-30), ends_above);
        // A rise that falls back within rounding is a touch.
        let allowed = select(noise, 0.0, ends_above);
        var most = part[0];
        for (var i = 1u; i <= DEGREE; i++) {
            most = max(most, part[i]);
        }
        if most <= allowed {
            continue;
        }
        let width = high - low;
        if ends_above && sign_changes() == 1u {
            return low + width * only_root();
        }
        if width <= NARROWEST || height + 2u > PENDING {
            if ends_above {
                return high;
            }
            continue;
        }
        let hull = hull_on_axis();
        let near = max(hull.x - CLIP_MARGIN, 0.0);
        let far = min(hull.y + CLIP_MARGIN, 1.0);
        if far - near <= SLOW {
            pending[height] = vec3f(low + width * near, low + width * far, f32(ends_above));
            height++;
            continue;
        }
        let middle = 0.5 * (low + high);
        let is_above = value_at(0.5) > 0.0;
        if !is_above {
            pending[height] = vec3f(middle, high, f32(ends_above));
            height++;
        }
        pending[height] = vec3f(low, middle, f32(is_above));
        height++;
    }
    return -1.0;
}

fn value_at(u: f32) -> f32 {
    var values = part;
    for (var level = DEGREE; level > 0u; level--) {
        for (var i = 0u; i < level; i++) {
            values[i] = mix(values[i], values[i + 1u], u);
        }
    }
    return values[0];
}

// The root of a part that rises once: false position kept within the bracket, by halves where it is slow
// (the Illinois rule).
fn only_root() -> f32 {
    var low = 0.0;
    var high = 1.0;
    var at_low = part[0];
    var at_high = part[DEGREE];
    for (var i = 0u; i < 40u && high - low > NARROWEST; i++) {
        let share = clamp(at_low / (at_low - at_high), 0.02, 0.98);
        let middle = mix(low, high, share);
        let value = value_at(middle);
        if value > 0.0 {
            high = middle;
            at_high = value;
            at_low *= 0.5;
        } else {
            low = middle;
            at_low = value;
            at_high *= 0.5;
        }
    }
    return high;
}

fn full_list(at: f32) -> HitRecord {
    return nothing(NO_ROOM);
}
