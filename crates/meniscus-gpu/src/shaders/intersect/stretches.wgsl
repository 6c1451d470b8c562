// The first crossing stretch by stretch. `gather` lists the blobs that the ray meets between `from` and the
// end of the stretch, which lies a fixed length behind the first support met. The end only ever moves
// towards the ray's start, so the list is whole wherever the gathering ends. Where it is full the end
// moves nearer still.

// A blob at a place of the stretch.
struct BlobThere {
    // 1 − q.
    g: f32,
    weight: f32,
    index: u32,
    // −∇g/2.
    downhill: vec3f,
}

// A ray that takes more stretches than this would hold up all others, and llvmpipe ends any loop after
// 65535 rounds.
const MOST_STRETCHES: u32 = 4096u;
// After so many stretches in a row without a crossing, each is twice as long as the one before, as long
// as few blobs are met: a large blob among small ones would be walked through in their steps.
const QUIET_STRETCHES: u32 = 4u;
const FEW_BLOBS: u32 = 24u;
// Halvings of a stretch whose blobs do not fit.
const MOST_HALVINGS: u32 = 12u;
// g this little below 0 may be rounding.
const NEXT_TO: f32 = 1e-3;
// Of F, relative: what float64 has to decide.
const SIDE_NOISE: f32 = 2e-5;

// The stretch.
var<private> stretch_start: f32;
var<private> stretch_end: f32;
// MISS as long as the walk is whole.
var<private> trouble: u32;

// Whether a blob reaches the ray between two places, counted from `base`.
fn reaches(blob: vec4f, from_at: f32, to_at: f32) -> bool {
    let away = clamp(blob.x, from_at, to_at) - blob.x;
    return blob.z - blob.y * away * away > 0.0;
}

// Drops what does not reach the stretch behind `from_at`.
fn drop_what_is_beyond(from_at: f32) {
    let low = from_at - base;
    let high = stretch_end - base;
    var kept = 0u;
    for (var i = 0u; i < count; i++) {
        let blob = met(i);
        if reaches(blob, low, high) {
            if kept != i {
                keep(kept, blob, met_word(i));
            }
            kept++;
        }
    }
    count = kept;
}

fn make_room(from_at: f32) {
    drop_what_is_beyond(from_at);
    for (var i = 0u; i < MOST_HALVINGS && count == params.capacity; i++) {
        let middle = stretch_start + 0.5 * (stretch_end - stretch_start);
        if !(middle > from_at) {
            break;
        }
        stretch_end = middle;
        drop_what_is_beyond(from_at);
    }
    if count == params.capacity {
        trouble = NO_ROOM;
    }
}

// F at a place, and the sum of the sizes of its parts.
fn field_at(along: f32) -> vec2f {
    var sums = vec2f(0.0);
    for (var i = 0u; i < count; i++) {
        let blob = met(i);
        let away = along - blob.x;
        let g = max(blob.z - blob.y * away * away, 0.0);
        let part = blob.w * kernel_of_g(vec4f(g)).x;
        sums += vec2f(part, abs(part));
    }
    return sums;
}

// An upper bound of the field between two places.
fn upper_bound(from_at: f32, to_at: f32) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < count; i++) {
        let blob = met(i);
        let away = clamp(blob.x, from_at, to_at) - blob.x;
        let most = max(blob.z - blob.y * away * away, 0.0);
        sum += max(blob.w, 0.0) * kernel_of_g(vec4f(most)).x;
    }
    return sum;
}

// −∇F and the strongest blob at a place of the stretch.
fn surface_at(along: f32) -> HitRecord {
    var outward = vec3f(0.0);
    var strongest = NONE;
    var strength = -1.0;
    for (var i = 0u; i < count; i++) {
        let blob = met(i);
        let away = along - blob.x;
        if blob.z - blob.y * away * away < -NEXT_TO {
            continue;
        }
        let there = blob_there(met_word(i), along);
        let g = max(there.g, 0.0);
        let part = abs(there.weight * kernel_of_g(vec4f(g)).x);
        outward += (2.0 * there.weight * kernel_slope(g)) * there.downhill;
        if part > strength {
            strength = part;
            strongest = there.index;
        }
    }
    return HitRecord(HIT, base, along, strongest, outward, select(1u, 0u, is_inside));
}

// Where a search begins.
struct Start {
    at: f32,
    // That the side is the stated one need not show there: it is where the caller's ray starts, or a crossing.
    is_own: bool,
    side_is_proven: bool,
    asks_side: bool,
    // The side has to show a little farther on: where it does not, there are crossings that f32 cannot tell.
    must_show: bool,
}

fn start_of_ray() -> Start {
    prepare();
    is_inside = (ray.flags & STARTS_INSIDE) != 0u;
    let is_own = (ray.flags & STARTS_AT_T_MIN) != 0u;
    let side_is_proven = (ray.flags & SIDE_IS_PROVEN) != 0u;
    return Start(0.0, is_own, side_is_proven, (ray.flags & ASKS_SIDE) != 0u, false);
}

// Behind a crossing, as a ray that leaves a surface.
fn start_behind(crossing: HitRecord) -> Start {
    is_inside = !is_inside;
    return Start(crossing.base + crossing.along, true, false, false, true);
}

// Whether the field is surely on the ray's side near a start; its stretch is gathered.
fn shows_side(start: Start) -> bool {
    let sums = field_at(min(start.at + params.near_start, stretch_end) - base);
    let above = sums.x - params.threshold;
    let is_clear = abs(above) > SIDE_NOISE * max(max(params.threshold, 1.0), sums.y);
    return is_clear && (above > 0.0) == is_inside;
}

// In a ray's flags: where it starts inside, and where it is inside at its end, its field is cut open.
const STOPS_INSIDE: u32 = 16u;
const ENDS_AT_CUT: u32 = 32u;
// In a hit's `is_entering`.
const AT_CUT: u32 = 2u;

// Where the field is cut open.
fn at_cut(along: f32, entering: u32, wants_any: bool) -> HitRecord {
    if wants_any {
        return nothing(HIT);
    }
    var record = surface_at(along);
    record.is_entering = AT_CUT | entering;
    return record;
}

// The end of a ray that met nothing.
fn at_end(on_stated_side: bool, wants_any: bool) -> HitRecord {
    if (ray.flags & ENDS_AT_CUT) == 0u || !is_inside {
        return nothing(MISS);
    }
    if !on_stated_side {
        return nothing(IN_DOUBT);
    }
    return at_cut(ray.length - base, 0u, wants_any);
}

fn first_behind(start: Start, wants_any: bool) -> HitRecord {
    var side_is_proven = start.side_is_proven;
    var asks_side = start.asks_side;
    var on_stated_side = side_is_proven && !start.is_own;
    // Up to here the ray is solved.
    var solved = start.at;
    var reach = params.longest;
    var quiet = 0u;
    for (var step = 0u; step < MOST_STRETCHES; step++) {
        gather(solved, reach);
        if trouble != MISS {
            return nothing(trouble);
        }
        if asks_side {
            let sums = field_at(-base);
            let above = sums.x - params.threshold;
            if abs(above) <= SIDE_NOISE * max(max(params.threshold, 1.0), sums.y) {
                return nothing(IN_DOUBT);
            }
            is_inside = above > 0.0;
            side_is_proven = true;
            asks_side = false;
            if is_inside && (ray.flags & STOPS_INSIDE) != 0u {
                return at_cut(-base, 1u, wants_any);
            }
        }
        if step == 0u && start.must_show && !shows_side(start) {
            return nothing(IN_DOUBT);
        }
        if count == 0u {
            return nothing(MISS);
        }
        // No support reaches the ray before.
        let is_away = stretch_start > max(solved, start.at + params.rounding);
        if is_away && !(is_inside && on_stated_side) {
            solved = stretch_start;
            on_stated_side = on_stated_side || !is_inside;
        }
        if !(stretch_end > solved) {
            if stretch_end >= ray.length {
                return at_end(on_stated_side, wants_any);
            }
            // Supports below the rounding of places along the ray.
            return nothing(IN_DOUBT);
        }
        drop_what_is_beyond(solved);
        let from_at = solved - base;
        let to_at = stretch_end - base;
        quiet++;
        if count > FEW_BLOBS {
            reach = params.longest;
            quiet = 0u;
        } else if quiet > QUIET_STRETCHES {
            reach *= 2.0;
        }
        if !is_inside && upper_bound(from_at, to_at) < params.threshold {
            on_stated_side = true;
        } else {
            let away_from_start = solved > start.at + params.rounding || !start.is_own;
            var entry = UNCONFIRMED;
            if side_is_proven || (on_stated_side && away_from_start) {
                entry = CONFIRMED;
            } else if away_from_start {
                entry = RETURNING;
            }
            let own_reach =
                select(-1.0, start.at + params.near_start, start.is_own && !side_is_proven);
            // That there is a crossing is enough.
            let any_place = wants_any && solved > own_reach;
            let tolerance = select(params.tolerance, 3e38, any_place);
            let verdict = first_crossing(from_at, to_at, entry, tolerance);
            if verdict.kind == CROSSING {
                if base + verdict.at <= own_reach {
                    return nothing(IN_DOUBT);
                }
                if wants_any {
                    return nothing(HIT);
                }
                return surface_at(verdict.at);
            }
            if verdict.kind == UNCLEAR {
                return nothing(IN_DOUBT);
            }
            on_stated_side = on_stated_side || verdict.kind == STAYS_ON_SIDE;
        }
        solved = stretch_end;
        if solved >= ray.length {
            return at_end(on_stated_side, wants_any);
        }
    }
    return nothing(IN_DOUBT);
}

fn trace(wants_any: bool) -> HitRecord {
    return first_behind(start_of_ray(), wants_any);
}

fn number_of(group: vec3u, groups: vec3u, lane: u32) -> u32 {
    return (group.y * groups.x + group.x) * WORKGROUP + lane;
}

@compute @workgroup_size(WORKGROUP)
fn closest(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if index < params.rays {
        ray = rays[index];
        first_met = (index - lane) * params.capacity + lane;
        hits[index] = if_whole(trace(false));
    }
}

@compute @workgroup_size(WORKGROUP)
fn occluded(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if index < params.rays {
        ray = rays[index];
        first_met = (index - lane) * params.capacity + lane;
        hits[index] = if_whole(trace(true));
    }
}
