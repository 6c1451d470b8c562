// k = (5g² + 4g³)/9, g = 1 − q: twin of kernel/wyvill.rs.

fn kernel_of_g(g: vec4f) -> vec4f {
    return g * g * (g * (4.0 / 9.0) + 5.0 / 9.0);
}

// dk/dg.
fn kernel_slope(g: f32) -> f32 {
    return g * (g * (12.0 / 9.0) + 10.0 / 9.0);
}

// d²k/dg².
fn kernel_curvature(g: f32) -> f32 {
    return g * (24.0 / 9.0) + 10.0 / 9.0;
}

// −k″(s) ≤ β times this along g(s) = g₀ − β(s − c)².
fn kernel_concave_bound(g: f32) -> f32 {
    return g * (g * (24.0 / 9.0) + 20.0 / 9.0);
}

// +k″(s) ≤ β times this.
fn kernel_convex_bound(g: f32) -> f32 {
    return g * (g * (19.2 / 9.0) + 40.0 / 9.0);
}
