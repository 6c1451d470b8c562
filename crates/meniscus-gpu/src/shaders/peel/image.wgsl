// Where a ball is seen.

struct Image {
    // Film positions, in pixels from the middle of the grid.
    low: vec2f,
    high: vec2f,
    // No ray from the eye meets the ball nearer than this.
    nearest: f32,
    // Whether any of the ball lies before the eye.
    is_before: bool,
}

const FAR: f32 = 1e30;
// Images are this much wider than they are, for rounding: in pixels, and of the radius and the distance.
const IMAGE_MARGIN: f32 = 0.02;
const RADIUS_MARGIN: f32 = 1e-5;
const DISTANCE_MARGIN: f32 = 2e-6;

// The least and the largest (row · x) / (depth · x) over a ball before the eye: where the plane
// (row − m depth) · x = 0 touches it, (row·w − m depth·w)² = R² |row − m depth|².
fn side_of_image(row: vec3f, depth: vec3f, center: vec3f, radius: f32) -> vec2f {
    let a = dot(row, center);
    let b = dot(depth, center);
    let row_reach = radius * length(row);
    let depth_reach = radius * length(depth);
    if b <= 1.001 * depth_reach {
        // It reaches the plane through the eye: only the sign of its side helps.
        if a - row_reach > 0.0 {
            return vec2f((a - row_reach) / (b + depth_reach), FAR);
        }
        if a + row_reach < 0.0 {
            return vec2f(-FAR, (a + row_reach) / (b + depth_reach));
        }
        return vec2f(-FAR, FAR);
    }
    let slant = a * depth - b * row;
    let square = dot(slant, slant)
        - radius * radius * (dot(row, row) * dot(depth, depth) - pow(dot(row, depth), 2.0));
    let middle = a * b - radius * radius * dot(row, depth);
    let half = radius * sqrt(max(square, 0.0));
    return vec2f(middle - half, middle + half) / ((b - depth_reach) * (b + depth_reach));
}

fn image_of(ball: vec4f) -> Image {
    let offset = two_sum(ball.xyz, -params.eye.xyz);
    let center = offset.high + (offset.low - params.eye_low.xyz);
    let distance = length(center);
    let radius = (1.0 + RADIUS_MARGIN) / ball.w + DISTANCE_MARGIN * distance;
    let depth = params.film_depth.xyz;
    let x = side_of_image(params.film_x.xyz, depth, center, radius);
    let y = side_of_image(params.film_y.xyz, depth, center, radius);
    let margin = IMAGE_MARGIN + params.jitter;
    return Image(
        vec2f(x.x, y.x) - margin,
        vec2f(x.y, y.y) + margin,
        max(distance - radius, 0.0),
        dot(depth, center) + radius * length(depth) > 0.0,
    );
}
