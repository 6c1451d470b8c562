// Planes, spheres and meshes, the first that are asked: twin of intersect/solids.rs.

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

// Where a question meets a surface.
struct Crossing {
    // −1: nowhere.
    t: f32,
    is_entering: bool,
    // Outward, unit length.
    normal: vec3f,
    // For shading, on the same side.
    shading: vec3f,
    position: TwoVec3,
    // Of a mesh: the triangle, and where the next one is crossed.
    triangle: u32,
    next_t: f32,
    // Whether a plane cuts the surface open there.
    is_cut: bool,
    is_in_doubt: bool,
}

fn no_crossing(is_in_doubt: bool) -> Crossing {
    let nowhere = TwoVec3(vec3f(0.0), vec3f(0.0));
    return Crossing(-1.0, false, vec3f(0.0), vec3f(0.0), nowhere, NONE, FAR, false, is_in_doubt);
}

fn crossing_at(question: Question, t: f32, is_entering: bool, normal: vec3f) -> Crossing {
    return Crossing(t, is_entering, normal, normal, point_along(question, t), NONE, FAR, false, false);
}

// Where a plane cuts a surface open.
fn crossing_at_cut(question: Question, t: f32, plane: u32, is_entering: bool) -> Crossing {
    let normal = cut_normal(plane);
    let position = point_on_cut(question, t, plane);
    return Crossing(t, is_entering, normal, normal, position, NONE, FAR, true, false);
}

fn plane_crossing(question: Question, surface: u32) -> Crossing {
    let at = surface_word(surface);
    var normal = words[at + 1u].xyz;
    var height = dot(question.origin, normal) + words[at + 1u].w;
    height += dot(question.origin_low, normal) + words[at + 2u].w;
    var size = size_of(question.origin) + abs(words[at + 1u].w);
    let way = way_of(surface);
    if way.y > 0u {
        let placement = placement_at(way, question.time);
        if !placement.is_sure {
            return no_crossing(true);
        }
        normal = turned_normal(placement, normal);
        let moved = two_sum(question.origin, -placement.pivot.high);
        let low = moved.low + (question.origin_low - placement.pivot.low);
        height = dot(moved.high, normal) + dot(low, normal);
        size = size_of(question.origin) + size_of(placement.pivot.high);
    }
    let rate = dot(question.direction, normal) + dot(question.direction_low, normal);
    let is_entering = rate < 0.0;
    var t = -height / rate;
    if rate == 0.0 {
        return no_crossing(false);
    }
    let side = stated_side(question, surface);
    if side != SIDE_UNKNOWN && (question.side_of == surface || abs(height) <= ORIGIN_ERROR * size) {
        if contradicts(side, is_entering) {
            return no_crossing(false);
        }
        t = max(t, 0.0);
    }
    return crossing_at(question, select(-1.0, t, t >= 0.0), is_entering, normal);
}

// A question as a sphere of radius 1 around the origin sees it.
fn sphere_ray(question: Question, surface: u32) -> ObjectRay {
    let at = surface_word(surface);
    let sphere = words[at + 1u];
    let moved = two_sum(question.origin, -sphere.xyz);
    let low = moved.low + (question.origin_low - words[at + 2u].xyz);
    return ObjectRay(
        TwoVec3(moved.high / sphere.w, low / sphere.w),
        TwoVec3(question.direction, question.direction_low),
        sphere.w,
    );
}

fn sphere_crossing(question: Question, surface: u32, span: Span) -> Crossing {
    let way = way_of(surface);
    var placement: Placement;
    var ray: ObjectRay;
    if way.y > 0u {
        placement = placement_at(way, question.time);
        if !placement.is_sure {
            return no_crossing(true);
        }
        ray = object_ray(placement, question);
    } else {
        ray = sphere_ray(question, surface);
    }
    let origin = ray.origin.high + ray.origin.low;
    let direction = ray.direction.high;
    let middle = -dot(origin, direction);
    let nearest = origin + direction * middle;
    let discriminant = 1.0 - dot(nearest, nearest);
    if span.is_empty || !(discriminant >= 0.0) {
        return no_crossing(false);
    }
    let half = sqrt(discriminant);
    // Counted from the middle: what is kept of the ray, and where that is inside.
    let start = span.enter / ray.unit - middle;
    let end = in_object(ray, span.leave) - middle;
    if span.enter_plane != NONE && abs(start) < half {
        return crossing_at_cut(question, span.enter, span.enter_plane, true);
    }
    let side = select(SIDE_OUTSIDE, stated_side(question, surface), span.enter_plane == NONE);
    let error = ORIGIN_ERROR * (1.0 + size_of(question.origin) / ray.unit);
    let is_stated = span.enter_plane == NONE && question.side_of == surface;
    let is_own_start = side != SIDE_UNKNOWN
        && (is_stated || abs(length(nearest + direction * start) - 1.0) <= error);
    let may_enter = -half >= start && !(is_own_start && contradicts(side, true));
    let may_leave = half >= start && !(is_own_start && contradicts(side, false));
    let along = select(half, -half, may_enter);
    if (may_enter || may_leave) && along <= end {
        var normal = normalize(nearest + direction * along);
        if way.y > 0u {
            normal = turned_normal(placement, normal);
        }
        return crossing_at(question, (middle + along) * ray.unit, may_enter, normal);
    }
    if span.leave_plane != NONE && side != SIDE_OUTSIDE && abs(end) < half {
        return crossing_at_cut(question, span.leave, span.leave_plane, false);
    }
    return no_crossing(false);
}
