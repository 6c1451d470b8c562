// k = g², g = 1 − q: twin of kernel/quartic.rs.

fn kernel_of_g(g: vec4f) -> vec4f {
    return g * g;
}

// dk/dg.
fn kernel_slope(g: f32) -> f32 {
    return g * 2.0;
}

// d²k/dg².
fn kernel_curvature(g: f32) -> f32 {
    return 2.0;
}

// −k″(s) ≤ β times this along g(s) = g₀ − β(s − c)².
fn kernel_concave_bound(g: f32) -> f32 {
    return g * 4.0;
}

// +k″(s) ≤ β times this.
fn kernel_convex_bound(g: f32) -> f32 {
    return g * 8.0;
}
