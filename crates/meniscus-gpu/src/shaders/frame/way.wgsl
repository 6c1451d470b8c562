// Where instances are that turn, stretch or move: twin of frame/way.rs.

// The vectors of an instance's way.
const WAY_VECTORS: u32 = 4u;

// A map from the world around a point into an object around it.
struct Placement {
    pivot: TwoVec3,
    linear: mat3x3f,
    // Whether it could be told.
    is_sure: bool,
}

// Where the way of a surface begins, and how many pieces it has; 0: it is upright and stands still.
fn way_of(surface: u32) -> vec2u {
    return vec2u(words[surface_word(surface)].zw);
}

fn placement_at(way: vec2u, time: f32) -> Placement {
    var part = 0.0;
    if picture.shutter_secs > 0.0 {
        part = clamp((time - picture.shutter_open) / picture.shutter_secs, 0.0, 1.0);
    }
    let there = piece_there(way.x, way.y, WAY_VECTORS, part);
    let pivot = vector_there(there, 0u);
    let x = vector_there(there, 1u).high;
    let y = vector_there(there, 2u).high;
    let z = vector_there(there, 3u).high;
    return Placement(pivot, mat3x3f(x, y, z), there.is_close);
}

// A vector of two f32 in the object: the same map for what is far and what is near.
fn turned(placement: Placement, v: TwoVec3) -> TwoVec3 {
    let x = two_product(placement.linear[0], vec3f(v.high.x));
    let y = two_product(placement.linear[1], vec3f(v.high.y));
    let z = two_product(placement.linear[2], vec3f(v.high.z));
    let first = two_sum(x.high, y.high);
    let second = two_sum(first.high, z.high);
    let low = first.low + second.low + x.low + y.low + z.low + placement.linear * v.low;
    return two_sum(second.high, low);
}

// A point in the object, relative to the pivot.
fn point_in_object(placement: Placement, point: TwoVec3) -> TwoVec3 {
    let moved = two_sum(point.high, -placement.pivot.high);
    return turned(placement, TwoVec3(moved.high, moved.low + (point.low - placement.pivot.low)));
}

// From a vector in the object to the one in the world.
fn turned_back(placement: Placement, v: vec3f) -> vec3f {
    let m = placement.linear;
    let volume = dot(m[0], cross(m[1], m[2]));
    // Rows of the inverse.
    let back = vec3f(dot(cross(m[1], m[2]), v), dot(cross(m[2], m[0]), v), dot(cross(m[0], m[1]), v));
    return back / volume;
}

// The same of two f32, so that the way there and back ends where it began.
fn turned_back_exactly(placement: Placement, v: TwoVec3) -> TwoVec3 {
    let back = turned_back(placement, v.high);
    let there = turned(placement, TwoVec3(back, vec3f(0.0)));
    let rest = two_sum(v.high, -there.high);
    return two_sum(back, turned_back(placement, rest.high + (rest.low + (v.low - there.low))));
}

// A normal of the object in the world.
fn turned_normal(placement: Placement, normal: vec3f) -> vec3f {
    return normalize(normal * placement.linear);
}

// A question in an object: where it starts relative to the pivot, its unit direction, and how far in the
// world a unit of length along it goes.
struct ObjectRay {
    origin: TwoVec3,
    direction: TwoVec3,
    unit: f32,
}

fn object_ray(placement: Placement, question: Question) -> ObjectRay {
    let way = turned(placement, TwoVec3(question.direction, question.direction_low));
    let unit = 1.0 / length(way.high);
    let direction = two_product(way.high, vec3f(unit));
    return ObjectRay(
        point_in_object(placement, TwoVec3(question.origin, question.origin_low)),
        two_sum(direction.high, direction.low + way.low * unit),
        unit,
    );
}

// A length in the world in that of an object's ray; infinity stays what it is.
fn in_object(ray: ObjectRay, t: f32) -> f32 {
    return select(t / ray.unit, t, is_far(t));
}

// A point from a placement's pivot.
fn point_from_pivot(placement: Placement, answer: Answer) -> vec3f {
    let moved = answer.position - placement.pivot.high;
    return moved + (answer.position_low - placement.pivot.low);
}

// How a placement changes per second.
struct PlacementRate {
    pivot: vec3f,
    linear: mat3x3f,
}

fn placement_rate(way: vec2u, time: f32) -> PlacementRate {
    if picture.shutter_secs <= 0.0 {
        return PlacementRate(vec3f(0.0), mat3x3f());
    }
    let part = clamp((time - picture.shutter_open) / picture.shutter_secs, 0.0, 1.0);
    let there = piece_there(way.x, way.y, WAY_VECTORS, part);
    let rate = 1.0 / picture.shutter_secs;
    let x = vector_change(there, 1u);
    let y = vector_change(there, 2u);
    let z = vector_change(there, 3u);
    return PlacementRate(vector_change(there, 0u) * rate, mat3x3f(x, y, z) * rate);
}

// How a point that stays in the world moves in the object, per second.
fn drift_of(placement: Placement, rate: PlacementRate, from_pivot: vec3f) -> vec3f {
    return rate.linear * from_pivot - placement.linear * rate.pivot;
}

// The covector in an object that is a normal of the world there.
fn object_normal(placement: Placement, normal: vec3f) -> vec3f {
    let m = placement.linear;
    let back = mat3x3f(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
    return back * normal / dot(m[0], cross(m[1], m[2]));
}
