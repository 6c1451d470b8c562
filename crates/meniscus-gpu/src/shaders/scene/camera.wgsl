// The camera: from a place on the film to the direction through it, as a sum of two f32. Twin of
// scene/camera/.

// A camera at one time: its eye, its axes, the side of a pixel at distance 1.
struct View {
    eye: TwoVec3,
    forward: TwoVec3,
    right: TwoVec3,
    above: TwoVec3,
    pixel_side: vec2f,
    // Whether it could be told.
    is_sure: bool,
}

// The vectors of a camera's way.
const CAMERA_VECTORS: u32 = 5u;

// When `part` of the shutter's time is over.
fn view_at(part: f32) -> View {
    if picture.camera_pieces == 0u {
        return View(
            TwoVec3(picture.eye, picture.eye_low),
            TwoVec3(picture.forward, picture.forward_low),
            TwoVec3(picture.right, picture.right_low),
            TwoVec3(picture.above, picture.above_low),
            vec2f(picture.pixel_side, picture.pixel_side_low),
            true,
        );
    }
    let there = piece_there(picture.camera_at, picture.camera_pieces, CAMERA_VECTORS, part);
    let side = vector_there(there, 4u);
    return View(
        vector_there(there, 0u), vector_there(there, 1u), vector_there(there, 2u), vector_there(there, 3u),
        vec2f(side.high.x, side.low.x), there.is_close,
    );
}

// A place on the film at distance 1, from its middle, by right and above.
fn film_place(view: View, pixel: vec2u, offset: vec2f) -> vec2f {
    let half_size = vec2f(picture.half_width, picture.half_height);
    return (vec2f(pixel) + 0.5 - half_size + offset) * vec2f(1.0, -1.0) * view.pixel_side.x;
}

// The change of a unit direction along (right, above, 1) by a step of what it is made of.
fn direction_change(direction: vec3f, size: f32, step: vec3f) -> vec3f {
    return (step - direction * dot(direction, step)) / size;
}

// How the eye's rays change from pixel to pixel and per second.
fn eye_differential(view: View, pixel: vec2u, offset: vec2f, part: f32) -> Differential {
    let at = film_place(view, pixel, offset);
    let size = sqrt(1.0 + dot(at, at));
    let towards = view.forward.high + view.right.high * at.x + view.above.high * at.y;
    let direction = towards / size;
    var eye_rate = vec3f(0.0);
    var rate = vec3f(0.0);
    if picture.camera_pieces > 0u && picture.shutter_secs > 0.0 {
        let there = piece_there(picture.camera_at, picture.camera_pieces, CAMERA_VECTORS, part);
        let growth = vector_change(there, 4u).x / view.pixel_side.x;
        let turned = vector_change(there, 1u) + vector_change(there, 2u) * at.x + vector_change(there, 3u) * at.y;
        let grown = (view.right.high * at.x + view.above.high * at.y) * growth;
        rate = (turned + grown) / picture.shutter_secs;
        eye_rate = vector_change(there, 0u) / picture.shutter_secs;
    }
    let x = direction_change(direction, size, view.right.high * view.pixel_side.x);
    let y = direction_change(direction, size, view.above.high * -view.pixel_side.x);
    let t = direction_change(direction, size, rate);
    return Differential(mat3x3f(vec3f(0.0), vec3f(0.0), eye_rate), mat3x3f(x, y, t), 1u);
}

fn direction_through(view: View, pixel: vec2u, offset: vec2f) -> TwoVec3 {
    let half_size = vec2f(picture.half_width, picture.half_height);
    let from_middle = vec3f((vec2f(pixel) + 0.5 - half_size) * vec2f(1.0, -1.0), 0.0);
    let more = vec3f(offset * vec2f(1.0, -1.0), 0.0) * view.pixel_side.x;
    let side = two_product(from_middle, vec3f(view.pixel_side.x));
    let sum = two_sum(side.high, more);
    let at = sum.high;
    let at_low = sum.low + side.low + from_middle * view.pixel_side.y;
    let rightwards = two_product(view.right.high, vec3f(at.x));
    let upwards = two_product(view.above.high, vec3f(at.y));
    let first = two_sum(view.forward.high, rightwards.high);
    let second = two_sum(first.high, upwards.high);
    let low = first.low + second.low + rightwards.low + upwards.low
        + (view.forward.low + view.right.low * at.x + view.above.low * at.y)
        + (view.right.high * at_low.x + view.above.high * at_low.y);
    // Any factor keeps the direction.
    let scale = vec3f(inverseSqrt(1.0 + dot(at, at)));
    let unit = two_product(second.high, scale);
    return two_sum(unit.high, unit.low + low * scale);
}
