// Questions about one blob surface: clipped to the box of its field, and what its tree's walk found put
// beside what is known. Twin of intersect/solve/local.rs and uploaded.rs.

// A ray as the tree's shaders read it.
struct LocalRay {
    origin: vec3f,
    length: f32,
    origin_low: vec3f,
    flags: u32,
    direction: vec3f,
    since_middle_secs: f32,
    direction_low: vec3f,
    elapsed: f32,
}

struct HitRecord {
    status: u32,
    base: f32,
    along: f32,
    strongest: u32,
    outward: vec3f,
    is_entering: u32,
}

// Whose a ray is, and how far along the question it begins.
struct Owner {
    question: u32,
    enter: f32,
}

@group(0) @binding(8) var<storage, read_write> local_rays: array<LocalRay>;
@group(0) @binding(9) var<storage, read_write> owners: array<Owner>;
@group(0) @binding(10) var<storage, read_write> hits: array<HitRecord>;

const STARTS_INSIDE: u32 = 1u;
const STARTS_AT_T_MIN: u32 = 2u;
const SIDE_IS_PROVEN: u32 = 4u;
const ASKS_SIDE: u32 = 8u;
const HIT: u32 = 1u;
const MISS: u32 = 0u;

// By how much the box is wider, for rounding, in coordinates.
const BOX_MARGIN: f32 = 1e-6;
// Surfaces as close behind the nearest are looked for, too, relative to the distance.
const NEXT_TO: f32 = 1e-5;

@compute @workgroup_size(WORKGROUP)
fn clip(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if index >= picture.count {
        return;
    }
    let place = field_place.kind * lights_at() + index;
    let question = questions[place];
    let known = answers[place];
    // That there is something is enough before lights, unless light walks on through it.
    let is_blocked = field_place.kind == 1u && picture.light_walks == 0u && known.surface != NONE;
    let is_settled = known.is_in_doubt != 0u || is_blocked;
    if (question.flags & IS_ASKED) == 0u || is_settled {
        return;
    }
    let moved = two_sum(question.origin, -field_place.offset);
    let low = moved.low + (question.origin_low - field_place.offset_low);
    let origin = moved.high + low;
    let margin = BOX_MARGIN * (size_of(origin) + max(size_of(field_place.lower), size_of(field_place.upper)));
    var enter = 0.0;
    var leave = min(question.t_max, known.t * (1.0 + NEXT_TO));
    for (var axis = 0u; axis < 3u; axis++) {
        let lower = field_place.lower[axis] - margin - origin[axis];
        let upper = field_place.upper[axis] + margin - origin[axis];
        let rate = question.direction[axis];
        if abs(rate) < 1e-18 {
            if lower > 0.0 || upper < 0.0 {
                return;
            }
            continue;
        }
        enter = max(enter, min(lower / rate, upper / rate));
        leave = min(leave, max(lower / rate, upper / rate));
    }
    if !(enter <= leave) {
        return;
    }
    let way = two_product(question.direction, vec3f(enter));
    let start = two_sum(moved.high, way.high);
    let start_low = start.low + way.low + low + question.direction_low * enter;
    let side = stated_side(question, field_place.surface);
    let starts_at = enter <= 0.0;
    var flags = SIDE_IS_PROVEN;
    if side == SIDE_INSIDE {
        flags = STARTS_INSIDE;
    } else if starts_at {
        flags = select(0u, ASKS_SIDE, side == SIDE_UNKNOWN);
    }
    flags |= select(0u, STARTS_AT_T_MIN, starts_at);
    let time = clamp(question.time, field_place.open, field_place.close);
    let open_secs = field_place.close - field_place.open;
    var elapsed = 0.0;
    if open_secs > 0.0 {
        elapsed = (time - field_place.open) / open_secs;
    }
    let ray = atomicAdd(&counters[field_place.kind], 1u);
    owners[ray] = Owner(place, enter);
    local_rays[ray] = LocalRay(
        start.high, leave - enter, start_low, flags, question.direction,
        time - 0.5 * (field_place.open + field_place.close), question.direction_low, elapsed,
    );
}

@compute @workgroup_size(WORKGROUP)
fn merge(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if index >= atomicLoad(&counters[field_place.kind]) {
        return;
    }
    let hit = hits[index];
    if hit.status == MISS {
        return;
    }
    let owner = owners[index];
    if hit.status != HIT {
        answers[owner.question].is_in_doubt = 1u;
        return;
    }
    var answer = answers[owner.question];
    if field_place.kind == 1u && picture.light_walks == 0u {
        answers[owner.question].surface = field_place.surface;
        return;
    }
    let t = owner.enter + (hit.base + hit.along);
    if t > answer.t {
        answers[owner.question].next_t = min(answer.next_t, t);
        return;
    }
    if answer.surface != NONE {
        answer.next_t = answer.t;
    }
    let ray = local_rays[index];
    let first = two_product(ray.direction, vec3f(hit.base));
    let second = two_product(ray.direction, vec3f(hit.along));
    let way = two_sum(first.high, second.high);
    let way_low = way.low + first.low + second.low + ray.direction_low * (hit.base + hit.along);
    let local = two_sum(ray.origin, way.high);
    let there = two_sum(local.high, field_place.offset);
    let low = there.low + local.low + way_low + ray.origin_low + field_place.offset_low;
    let position = two_sum(there.high, low);
    answer.position = position.high;
    answer.position_low = position.low;
    answer.t = t;
    answer.surface = field_place.surface;
    answer.normal = normalize(hit.outward);
    answer.blob = hit.strongest;
    answer.is_entering = hit.is_entering;
    answers[owner.question] = answer;
}
