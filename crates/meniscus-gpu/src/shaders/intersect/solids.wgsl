// Planes and spheres, the first that are asked: twin of intersect/solids.rs.

// How far rounding may move a point, relative to the coordinates that it went through.
const ORIGIN_ERROR: f32 = 4e-6;

// Whether a crossing goes to the side on which the ray says to start.
fn contradicts(side: u32, is_entering: bool) -> bool {
    return (side == SIDE_OUTSIDE && !is_entering) || (side == SIDE_INSIDE && is_entering);
}

// The side that a question states of a surface.
fn stated_side(question: Question, surface: u32) -> u32 {
    let is_about = question.side_of == NONE || question.side_of == surface;
    return select(SIDE_UNKNOWN, question.flags >> SIDE_SHIFT, is_about);
}

// Where a question meets a plane, and whether it enters; −1: nowhere.
fn plane_crossing(question: Question, surface: u32) -> vec2f {
    let at = surface_word(surface);
    let plane = words[at + 1u];
    let rate = dot(question.direction, plane.xyz) + dot(question.direction_low, plane.xyz);
    let above = dot(question.origin, plane.xyz) + plane.w;
    let height = above + (dot(question.origin_low, plane.xyz) + words[at + 2u].w);
    let is_entering = rate < 0.0;
    var t = -height / rate;
    if rate == 0.0 {
        return vec2f(-1.0, 0.0);
    }
    let side = stated_side(question, surface);
    let error = ORIGIN_ERROR * (size_of(question.origin) + abs(plane.w));
    if side != SIDE_UNKNOWN && (question.side_of == surface || abs(height) <= error) {
        if contradicts(side, is_entering) {
            return vec2f(-1.0, 0.0);
        }
        t = max(t, 0.0);
    }
    return vec2f(select(-1.0, t, t >= 0.0), select(0.0, 1.0, is_entering));
}

// The same of a sphere.
fn sphere_crossing(question: Question, surface: u32) -> vec2f {
    let at = surface_word(surface);
    let sphere = words[at + 1u];
    let from_center = two_sum(question.origin, -sphere.xyz);
    let low = from_center.low + (question.origin_low - words[at + 2u].xyz);
    let origin = (from_center.high + low) / sphere.w;
    let middle = -dot(origin, question.direction);
    let nearest = origin + question.direction * middle;
    let discriminant = 1.0 - dot(nearest, nearest);
    if !(discriminant >= 0.0) {
        return vec2f(-1.0, 0.0);
    }
    let half = sqrt(discriminant);
    let side = stated_side(question, surface);
    let error = ORIGIN_ERROR * (1.0 + size_of(question.origin) / sphere.w);
    let is_own_start = side != SIDE_UNKNOWN
        && (question.side_of == surface || abs(length(origin) - 1.0) <= error);
    let first = middle - half;
    if first >= 0.0 && !(is_own_start && contradicts(side, true)) {
        return vec2f(first * sphere.w, 1.0);
    }
    let second = middle + half;
    if second >= 0.0 && !(is_own_start && contradicts(side, false)) {
        return vec2f(second * sphere.w, 0.0);
    }
    return vec2f(-1.0, 0.0);
}

// The point of a question at `t`, as a sum of two f32.
fn point_along(question: Question, t: f32) -> TwoVec3 {
    let way = two_product(question.direction, vec3f(t));
    let sum = two_sum(question.origin, way.high);
    let low = sum.low + way.low + question.direction_low * t + question.origin_low;
    return two_sum(sum.high, low);
}

@compute @workgroup_size(WORKGROUP)
fn solids(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if index >= picture.count {
        return;
    }
    for (var kind = 0u; kind < 2u; kind++) {
        let place = kind * lights_at() + index;
        let question = questions[place];
        if (question.flags & IS_ASKED) == 0u {
            continue;
        }
        var answer = nothing_there(question.t_max);
        for (var surface = 0u; surface < picture.surface_count; surface++) {
            let shape = u32(words[surface_word(surface)].x);
            var crossing = vec2f(-1.0, 0.0);
            if shape == PLANE {
                crossing = plane_crossing(question, surface);
            } else if shape == SPHERE {
                crossing = sphere_crossing(question, surface);
            }
            if crossing.x < 0.0 || crossing.x > answer.t {
                if crossing.x >= 0.0 {
                    answer.next_t = min(answer.next_t, crossing.x);
                }
                continue;
            }
            if answer.surface != NONE {
                answer.next_t = answer.t;
            }
            let point = point_along(question, crossing.x);
            answer.position = point.high;
            answer.position_low = point.low;
            answer.t = crossing.x;
            answer.surface = surface;
            answer.is_entering = u32(crossing.y);
            let shape_word = words[surface_word(surface) + 1u];
            if shape == PLANE {
                answer.normal = shape_word.xyz;
            } else {
                answer.normal = normalize(point.high - shape_word.xyz);
            }
        }
        answers[place] = answer;
    }
}
