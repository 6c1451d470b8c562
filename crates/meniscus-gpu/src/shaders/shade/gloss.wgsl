// The coat on a diffuse base, of integrator `shaded`: twin of shade/gloss.rs. A coat is (head on, grazing,
// width).

fn coat_reflectance(gloss: vec3f, cosine: f32) -> f32 {
    let x = clamp(1.0 - cosine, 0.0, 1.0);
    let x2 = x * x;
    return gloss.x + (gloss.y - gloss.x) * x2 * x2 * x;
}

fn highlight(gloss: vec3f, nl: f32, nv: f32, nh: f32, vh: f32) -> f32 {
    let a2 = gloss.z * gloss.z;
    let d = nh * nh * (a2 - 1.0) + 1.0;
    return coat_highlight(gloss, a2 / (PI * d * d), vec2f(a2), nl, nv, vh);
}

// With `added` to the squares of the widths along x and y of the frame of the directions, whose z is the normal.
fn widened_highlight(gloss: vec3f, added: vec2f, light: vec3f, view: vec3f, half: vec3f, vh: f32) -> f32 {
    let squares = min(gloss.z * gloss.z + added, vec2f(1.0));
    let d = dot(half.xy * half.xy, 1.0 / squares) + half.z * half.z;
    let distribution = 1.0 / (PI * sqrt(squares.x * squares.y) * d * d);
    let seen_squares = vec2f(seen_square(squares, light), seen_square(squares, view));
    return coat_highlight(gloss, distribution, seen_squares, light.z, view.z, vh);
}

// The squared width that a direction sees.
fn seen_square(squares: vec2f, direction: vec3f) -> f32 {
    let parts = direction.xy * direction.xy;
    return dot(squares, parts) / max(parts.x + parts.y, 1e-37);
}

// From the distribution of normals and the squared widths that light and view see.
fn coat_highlight(gloss: vec3f, distribution: f32, squares: vec2f, nl: f32, nv: f32, vh: f32) -> f32 {
    let masking = nl * sqrt(nv * nv * (1.0 - squares.y) + squares.y)
        + nv * sqrt(nl * nl * (1.0 - squares.x) + squares.x);
    return PI * nl * distribution * coat_reflectance(gloss, vh) * 0.5 / max(masking, 1e-6);
}
