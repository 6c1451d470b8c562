// What all shaders of engine peel know: the field as balls, and one eye's rays in slots.
//
// Rays are grouped by tiles of the film, `TILE` pixels wide and high. Slot after slot of a group is pixel
// after pixel of its tile, row by row.

struct Params {
    threshold: f32,
    // Accuracy of a crossing that is aimed at, as a length.
    tolerance: f32,
    // How far rounding may move a ball along a ray.
    rounding: f32,
    // Crossings this close to a ray's own start take float64.
    near_start: f32,
    // Length of a stretch.
    longest: f32,
    // Slots of all groups.
    rays: u32,
    groups: u32,
    // Balls that a stretch may meet, or that a pixel's list has room for.
    capacity: u32,
    balls: u32,
    // Pairs of a ball and a group that there is room for.
    pairs: u32,
    // Steeper balls are too small for f32.
    fine_beta: f32,
    // No ray is longer: depths are parts of it.
    reach: f32,
    // Film position (x, y) = (film_x · w, film_y · w) / (film_depth · w) for w seen from the eye, in
    // pixels from the middle of the grid.
    film_x: vec4f,
    film_y: vec4f,
    film_depth: vec4f,
    // The eye in the field's coordinates, as a sum of two f32.
    eye: vec4f,
    eye_low: vec4f,
    // Film position of the grid's first tile.
    grid_at: vec2f,
    // Tiles across and down.
    grid_size: vec2u,
    // How far a ray may lie from its pixel's centre, in pixels.
    jitter: f32,
    // Groups side by side where slots are pixels of a texture.
    groups_across: u32,
    // Sides of that texture.
    atlas: vec2u,
}

@group(0) @binding(0) var<uniform> params: Params;

// 1 − q(s) = g₀ − β(s − c)² along a line.
struct AlongLine {
    c: f32,
    beta: f32,
    g0: f32,
}

// A ray in the field's coordinates: clipped to the field's box in f64, its numbers as sums of two f32.
struct LocalRay {
    origin: vec3f,
    // Negative: there is no ray in this slot.
    length: f32,
    origin_low: vec3f,
    flags: u32,
    // Unit length.
    direction: vec3f,
    // From the eye to `origin`, rounded up.
    eye_distance: f32,
    direction_low: vec3f,
    group: u32,
}

// In `flags`: the ray starts inside.
const STARTS_INSIDE: u32 = 1u;
// It starts at the eye, else where it enters the box.
const STARTS_AT_T_MIN: u32 = 2u;
// The side is known for sure, not only stated.
const SIDE_IS_PROVEN: u32 = 4u;
// The side is not known.
const ASKS_SIDE: u32 = 8u;

const NONE: u32 = 0xffffffffu;
const SLOTS_PER_GROUP: u32 = TILE * TILE;

var<private> ray: LocalRay;

// (x, y, z, 1/R).
@group(0) @binding(5) var<storage, read> balls: array<vec4f>;
// (weight, the g at which a ball alone reaches the threshold; above 1 where it never does).
@group(0) @binding(6) var<storage, read> traits: array<vec2f>;

struct BallOnRay {
    line: AlongLine,
    // From the ray's point nearest the centre to the centre.
    aside: vec3f,
}

// A ball along the ray, c counted from `base`. The distance from the ray is what remains of the way to
// the centre; it is taken in two f32, so that neither a long way nor a far centre costs digits.
fn ball_on_ray(ball: vec4f, base: f32) -> BallOnRay {
    let offset = two_sum(ball.xyz, -ray.origin);
    let c = dot(offset.high, ray.direction);
    let shift = two_product(ray.direction, vec3f(c));
    let rest = two_sum(offset.high, -shift.high);
    let low = offset.low - ray.origin_low - shift.low - ray.direction_low * c;
    var aside = rest.high + (rest.low + low);
    let more = dot(aside, ray.direction);
    aside -= more * ray.direction;
    let beta = ball.w * ball.w;
    return BallOnRay(
        AlongLine((c - base) + more, beta, 1.0 - beta * dot(aside, aside)),
        aside,
    );
}
