// What all shaders know of a field: twin of field/ and primitive/mod.rs.

struct Params {
    threshold: f32,
    // Accuracy of a crossing that is aimed at, as a length.
    tolerance: f32,
    // How far rounding may move a blob along a ray.
    rounding: f32,
    // Crossings this close to a ray's own start take float64.
    near_start: f32,
    // Length of a stretch.
    longest: f32,
    rays: u32,
    // Word of the first leaf.
    leaves_at: u32,
    // Blobs that a stretch may meet.
    capacity: u32,
    // The middle of the shutter.
    middle_secs: f32,
}

// 1 − q(s) = g₀ − β(s − c)² along a line.
struct AlongLine {
    c: f32,
    beta: f32,
    g0: f32,
}
