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
    let masking = nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2);
    return PI * nl * (a2 / (PI * d * d)) * coat_reflectance(gloss, vh) * 0.5 / max(masking, 1e-6);
}
