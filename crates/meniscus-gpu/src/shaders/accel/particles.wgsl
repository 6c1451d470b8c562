// The eight-wide tree over particles: twin of accel/particles/.
//
// A node's words: lower x of its eight boxes (two words), lower y, lower z, upper x, y, z, children
// (two words), and where blobs move the same twelve bounds when the shutter closes. A leaf's:
// (centre, count), (β of what is too fine for f32, –, –, –), then sixteen blobs: shape, motion, turn.

const LEAF: u32 = 0x80000000u;
const CHILDREN_AT: u32 = 12u;
const NODE_WORDS: u32 = CHILDREN_AT + 2u + CLOSING_WORDS;
const LANES: u32 = 16u;
const LEAF_HEADER_WORDS: u32 = 2u;
const BLOB_WORDS: u32 = SHAPE_WORDS + RATE_WORDS;
const LEAF_WORDS: u32 = LEAF_HEADER_WORDS + LANES * BLOB_WORDS;

// A ray in local coordinates: clipped to the tree's box in f64, its numbers as sums of two f32.
struct LocalRay {
    origin: vec3f,
    length: f32,
    origin_low: vec3f,
    flags: u32,
    // Unit length.
    direction: vec3f,
    since_middle_secs: f32,
    direction_low: vec3f,
    // How much of the shutter's time is over, 0 to 1.
    elapsed: f32,
}

// In `flags`: the ray starts inside.
const STARTS_INSIDE: u32 = 1u;
// It starts at the caller's t_min, else where it enters the box.
const STARTS_AT_T_MIN: u32 = 2u;
// The side is known for sure, not only stated.
const SIDE_IS_PROVEN: u32 = 4u;
// The side is not known.
const ASKS_SIDE: u32 = 8u;

var<private> ray: LocalRay;
// 1/direction, finite.
var<private> inverse: vec3f;

const TINY_COMPONENT: f32 = 1e-18;

fn prepare_slabs() {
    let tiny = select(vec3f(TINY_COMPONENT), vec3f(-TINY_COMPONENT), ray.direction < vec3f(0.0));
    inverse = 1.0 / select(ray.direction, tiny, abs(ray.direction) < vec3f(TINY_COMPONENT));
}

// Where the ray enters (first) and leaves (second) the boxes of four children, on one axis.
fn slab(node: u32, axis: u32, half: u32, origin: f32, inverse: f32) -> array<vec4f, 2> {
    let lower = (bounds_at(node, axis * 2u + half) - origin) * inverse;
    let upper = (bounds_at(node, axis * 2u + 6u + half) - origin) * inverse;
    return array(min(lower, upper), max(lower, upper));
}

// The ray's point `along` it, relative to a local point: in two f32, so that neither a long way nor
// a far centre costs digits.
fn point_relative_to(center: vec3f, along: f32) -> vec3f {
    let shift = two_product(ray.direction, vec3f(along));
    let offset = two_sum(ray.origin, -center);
    let sum = two_sum(offset.high, shift.high);
    let low = offset.low + shift.low + ray.direction_low * along + ray.origin_low;
    return sum.high + (sum.low + low);
}
