// Planes that cut surfaces open: the part of a question that lies below all of them. Twin of
// intersect/clip.rs and intersect/world/caps.rs.

// Rounding of a height over a plane, relative to the coordinates that it comes from.
const ON_PLANE: f32 = 1e-9;

struct Span {
    is_empty: bool,
    // Where the question enters, and the plane there; NONE where it starts below all of them.
    enter: f32,
    enter_plane: u32,
    // Where it leaves, and the plane there; NONE: nowhere.
    leave: f32,
    leave_plane: u32,
}

fn cut_normal(plane: u32) -> vec3f {
    return words[picture.cuts_at + 2u * plane].xyz;
}

// Height over a plane of a point of two f32.
fn cut_height(plane: u32, point: TwoVec3) -> f32 {
    let at = picture.cuts_at + 2u * plane;
    let word = words[at];
    let products = two_product(point.high, word.xyz);
    let first = two_sum(vec3f(products.high.x), vec3f(products.high.y));
    let second = two_sum(first.high, vec3f(products.high.z));
    let third = two_sum(second.high, vec3f(word.w));
    let low = first.low.x + second.low.x + third.low.x + dot(products.low, vec3f(1.0));
    return third.high.x + (low + dot(point.low, word.xyz) + words[at + 1u].w);
}

fn span_of(question: Question) -> Span {
    var span = Span(false, 0.0, NONE, FAR, NONE);
    for (var plane = 0u; plane < picture.cut_count; plane++) {
        let normal = cut_normal(plane);
        let height = cut_height(plane, TwoVec3(question.origin, question.origin_low));
        let size = size_of(question.origin) + abs(words[picture.cuts_at + 2u * plane].w);
        let is_on_plane = abs(height) <= ON_PLANE * size;
        let rate = dot(question.direction, normal) + dot(question.direction_low, normal);
        let t = -height / rate;
        if rate > 0.0 {
            if is_on_plane || height > 0.0 {
                span.is_empty = true;
            } else if t < span.leave {
                span.leave = t;
                span.leave_plane = plane;
            }
        } else if height > 0.0 && !is_on_plane {
            if rate == 0.0 {
                span.is_empty = true;
            } else if t > span.enter {
                span.enter = t;
                span.enter_plane = plane;
            }
        }
    }
    let is_passed = span.enter_plane != NONE && span.enter >= span.leave;
    span.is_empty = span.is_empty || is_passed;
    return span;
}

// The point of a question at `t`, as a sum of two f32.
fn point_along(question: Question, t: f32) -> TwoVec3 {
    let way = two_product(question.direction, vec3f(t));
    let sum = two_sum(question.origin, way.high);
    let low = sum.low + way.low + question.direction_low * t + question.origin_low;
    return two_sum(sum.high, low);
}

// The question's point on a cut.
fn point_on_cut(question: Question, t: f32, plane: u32) -> TwoVec3 {
    let point = point_along(question, t);
    let onto = two_sum(point.high, -cut_normal(plane) * cut_height(plane, point));
    return two_sum(onto.high, onto.low + point.low);
}
