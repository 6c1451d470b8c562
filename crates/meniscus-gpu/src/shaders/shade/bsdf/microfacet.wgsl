// The GGX distribution of microfacets, of a width along x and one along y: twin of shade/bsdf/microfacet.rs.

fn ggx_normals(widths: vec2f, half: vec3f) -> f32 {
    let flat = half.xy / widths;
    let d = dot(flat, flat) + half.z * half.z;
    return 1.0 / (PI * widths.x * widths.y * d * d);
}

fn ggx_lambda(widths: vec2f, direction: vec3f) -> f32 {
    let flat = widths * direction.xy;
    let slope_squared = dot(flat, flat) / (direction.z * direction.z);
    // √(1 + s) − 1 without loss of digits.
    return 0.5 * slope_squared / (sqrt(1.0 + slope_squared) + 1.0);
}

// Part of the facets that both directions see, over the part that `view` sees.
fn ggx_shadowing(widths: vec2f, view: vec3f, light: vec3f) -> f32 {
    let seen = 1.0 + ggx_lambda(widths, view);
    return seen / (seen + ggx_lambda(widths, light));
}

// Draws a facet normal as `view` sees them (Heitz 2018).
fn ggx_sample(widths: vec2f, view: vec3f, u: vec2f) -> vec3f {
    let stretched = normalize(vec3f(widths * view.xy, view.z));
    let flat = dot(stretched.xy, stretched.xy);
    var first = vec3f(1.0, 0.0, 0.0);
    if flat > 0.0 {
        first = vec3f(-stretched.y, stretched.x, 0.0) / sqrt(flat);
    }
    let second = cross(stretched, first);
    let radius = sqrt(u.x);
    let turn = cos_sin(TAU * u.y);
    let x = radius * turn.x;
    let s = 0.5 * (1.0 + stretched.z);
    let y = (1.0 - s) * sqrt(max(1.0 - x * x, 0.0)) + s * radius * turn.y;
    let z = sqrt(max(1.0 - x * x - y * y, 0.0));
    let half = first * x + second * y + stretched * z;
    return normalize(vec3f(widths * half.xy, max(half.z, 1e-12)));
}

// Density of ggx_sample per solid angle of the facet normal.
fn ggx_visible(widths: vec2f, view: vec3f, half: vec3f) -> f32 {
    let masking = 1.0 / (1.0 + ggx_lambda(widths, view));
    return masking * max(dot(view, half), 0.0) * ggx_normals(widths, half) / view.z;
}
