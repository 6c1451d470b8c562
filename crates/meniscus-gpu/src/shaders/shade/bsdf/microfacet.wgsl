// The GGX distribution of microfacets of one width: twin of shade/bsdf/microfacet.rs.

fn ggx_normals(width: f32, half: vec3f) -> f32 {
    let flat = half.xy / width;
    let d = dot(flat, flat) + half.z * half.z;
    return 1.0 / (PI * width * width * d * d);
}

fn ggx_lambda(width: f32, direction: vec3f) -> f32 {
    let flat = width * direction.xy;
    let slope_squared = dot(flat, flat) / (direction.z * direction.z);
    // √(1 + s) − 1 without loss of digits.
    return 0.5 * slope_squared / (sqrt(1.0 + slope_squared) + 1.0);
}

// Part of the facets that both directions see, over the part that `view` sees.
fn ggx_shadowing(width: f32, view: vec3f, light: vec3f) -> f32 {
    let seen = 1.0 + ggx_lambda(width, view);
    return seen / (seen + ggx_lambda(width, light));
}

// Draws a facet normal as `view` sees them (Heitz 2018).
fn ggx_sample(width: f32, view: vec3f, u: vec2f) -> vec3f {
    let stretched = normalize(vec3f(width * view.xy, view.z));
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
    return normalize(vec3f(width * half.xy, max(half.z, 1e-12)));
}

// Density of ggx_sample per solid angle of the facet normal.
fn ggx_visible(width: f32, view: vec3f, half: vec3f) -> f32 {
    let masking = 1.0 / (1.0 + ggx_lambda(width, view));
    return masking * max(dot(view, half), 0.0) * ggx_normals(width, half) / view.z;
}
