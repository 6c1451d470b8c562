// The camera: from a place on the film to the direction through it, as a sum of two f32. Twin of
// scene/camera/.

fn direction_through(pixel: vec2u, offset: vec2f) -> TwoVec3 {
    let half_size = vec2f(picture.half_width, picture.half_height);
    let from_middle = vec3f((vec2f(pixel) + 0.5 - half_size) * vec2f(1.0, -1.0), 0.0);
    let more = vec3f(offset * vec2f(1.0, -1.0), 0.0) * picture.pixel_side;
    let side = two_product(from_middle, vec3f(picture.pixel_side));
    let sum = two_sum(side.high, more);
    let at = sum.high;
    let at_low = sum.low + side.low + from_middle * picture.pixel_side_low;
    let rightwards = two_product(picture.right, vec3f(at.x));
    let upwards = two_product(picture.above, vec3f(at.y));
    let first = two_sum(picture.forward, rightwards.high);
    let second = two_sum(first.high, upwards.high);
    let low = first.low + second.low + rightwards.low + upwards.low
        + (picture.forward_low + picture.right_low * at.x + picture.above_low * at.y)
        + (picture.right * at_low.x + picture.above * at_low.y);
    // Any factor keeps the direction.
    let scale = vec3f(inverseSqrt(1.0 + dot(at, at)));
    let unit = two_product(second.high, scale);
    return two_sum(unit.high, unit.low + low * scale);
}
