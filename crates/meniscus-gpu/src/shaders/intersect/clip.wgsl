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

// Whose a ray is, how far along it begins, and how far in the world a unit of its length goes.
struct Owner {
    question: u32,
    enter: f32,
    unit: f32,
}

@group(0) @binding(8) var<storage, read_write> local_rays: array<LocalRay>;
@group(0) @binding(9) var<storage, read_write> owners: array<Owner>;
@group(0) @binding(10) var<storage, read_write> hits: array<HitRecord>;

const STARTS_INSIDE: u32 = 1u;
const STARTS_AT_T_MIN: u32 = 2u;
const SIDE_IS_PROVEN: u32 = 4u;
const ASKS_SIDE: u32 = 8u;
const STOPS_INSIDE: u32 = 16u;
const ENDS_AT_CUT: u32 = 32u;
// In a hit's `is_entering`.
const AT_CUT: u32 = 2u;
const HIT: u32 = 1u;
const MISS: u32 = 0u;

// By how much the box is wider, for rounding, in coordinates.
const BOX_MARGIN: f32 = 1e-6;
// Surfaces as close behind the nearest are looked for, too, relative to the distance.
const NEXT_TO: f32 = 1e-5;

// A question as the field sees it that stands upright.
fn upright_ray(question: Question) -> ObjectRay {
    let moved = two_sum(question.origin, -field_place.offset);
    let low = moved.low + (question.origin_low - field_place.offset_low);
    return ObjectRay(
        TwoVec3(moved.high, low), TwoVec3(question.direction, question.direction_low), 1.0,
    );
}

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
    let span = span_of(question);
    if span.is_empty {
        return;
    }
    let way = way_of(field_place.surface);
    var seen_by_field: ObjectRay;
    if way.y > 0u {
        let placement = placement_at(way, question.time);
        if !placement.is_sure {
            answers[place].is_in_doubt = 1u;
            return;
        }
        seen_by_field = object_ray(placement, question);
    } else {
        seen_by_field = upright_ray(question);
    }
    let from_at = seen_by_field.origin;
    let direction = seen_by_field.direction;
    let origin = from_at.high + from_at.low;
    let margin = BOX_MARGIN * (size_of(origin) + max(size_of(field_place.lower), size_of(field_place.upper)));
    let first = in_object(seen_by_field, span.enter);
    let reach = min(question.t_max, known.t * (1.0 + NEXT_TO));
    let last = in_object(seen_by_field, min(reach, span.leave));
    var enter = first;
    var leave = last;
    for (var axis = 0u; axis < 3u; axis++) {
        let lower = field_place.lower[axis] - margin - origin[axis];
        let upper = field_place.upper[axis] + margin - origin[axis];
        let rate = direction.high[axis];
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
    let along = two_product(direction.high, vec3f(enter));
    let start = two_sum(from_at.high, along.high);
    let start_low = start.low + along.low + from_at.low + direction.low * enter;
    let enters_cut = span.enter_plane != NONE;
    let side = select(stated_side(question, field_place.surface), SIDE_UNKNOWN, enters_cut);
    let starts_at = enter <= first;
    var flags = SIDE_IS_PROVEN;
    if side == SIDE_INSIDE {
        flags = STARTS_INSIDE;
    } else if starts_at {
        flags = select(0u, ASKS_SIDE, side == SIDE_UNKNOWN);
    }
    flags |= select(0u, STARTS_AT_T_MIN, starts_at);
    flags |= select(0u, STOPS_INSIDE, starts_at && enters_cut);
    let is_cut_off = span.leave_plane != NONE && span.leave <= reach;
    flags |= select(0u, ENDS_AT_CUT, is_cut_off && leave == last);
    let time = clamp(question.time, field_place.open, field_place.close);
    let open_secs = field_place.close - field_place.open;
    var elapsed = 0.0;
    if open_secs > 0.0 {
        elapsed = (time - field_place.open) / open_secs;
    }
    let ray = atomicAdd(&counters[field_place.kind], 1u);
    owners[ray] = Owner(place, enter, seen_by_field.unit);
    local_rays[ray] = LocalRay(
        start.high, leave - enter, start_low, flags, direction.high,
        time - 0.5 * (field_place.open + field_place.close), direction.low, elapsed,
    );
}

// Where in the world something was hit, and the outward normal.
struct Place {
    position: TwoVec3,
    normal: vec3f,
}

fn place_of(index: u32, hit: HitRecord, cut: u32, t: f32) -> Place {
    let question = questions[owners[index].question];
    if cut != NONE {
        return Place(point_on_cut(question, t, cut), cut_normal(cut));
    }
    let ray = local_rays[index];
    let first = two_product(ray.direction, vec3f(hit.base));
    let second = two_product(ray.direction, vec3f(hit.along));
    let way = two_sum(first.high, second.high);
    let way_low = way.low + first.low + second.low + ray.direction_low * (hit.base + hit.along);
    let local = two_sum(ray.origin, way.high);
    let local_low = local.low + way_low + ray.origin_low;
    let way_there = way_of(field_place.surface);
    var pivot = TwoVec3(field_place.offset, field_place.offset_low);
    var from_pivot = TwoVec3(local.high, local_low);
    var normal = normalize(hit.outward);
    if way_there.y > 0u {
        let placement = placement_at(way_there, question.time);
        pivot = placement.pivot;
        from_pivot = turned_back_exactly(placement, from_pivot);
        normal = turned_normal(placement, normal);
    }
    let there = two_sum(from_pivot.high, pivot.high);
    return Place(two_sum(there.high, there.low + from_pivot.low + pivot.low), normal);
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
    let is_entering = (hit.is_entering & ~AT_CUT) != 0u;
    let is_cut = (hit.is_entering & AT_CUT) != 0u;
    var t = (owner.enter + (hit.base + hit.along)) * owner.unit;
    var cut = NONE;
    if is_cut {
        let span = span_of(questions[owner.question]);
        t = select(span.leave, span.enter, is_entering);
        cut = select(span.leave_plane, span.enter_plane, is_entering);
        if is_next_to(t, answer) {
            answers[owner.question].is_in_doubt = 1u;
            return;
        }
    }
    if t > answer.t {
        answers[owner.question].next_t = min(answer.next_t, t);
        return;
    }
    if answer.surface != NONE {
        answer.next_t = answer.t;
    }
    let point = place_of(index, hit, cut, t);
    answer.position = point.position.high;
    answer.position_low = point.position.low;
    answer.t = t;
    answer.surface = field_place.surface;
    answer.normal = point.normal;
    answer.shading = point.normal;
    answer.blob = hit.strongest;
    answer.is_entering = u32(is_entering);
    answers[owner.question] = answer;
}
