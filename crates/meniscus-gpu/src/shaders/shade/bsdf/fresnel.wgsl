// How much light a boundary reflects: twin of shade/bsdf/fresnel.rs.

// Reflectance, and the cosine on the other side; below 0 where all light is reflected.
fn dielectric_reflectance(cosine: f32, eta: f32) -> vec2f {
    let sine_squared = eta * eta * (1.0 - cosine * cosine);
    if sine_squared >= 1.0 && eta > 1.0 {
        return vec2f(1.0, -1.0);
    }
    let other = sqrt(max(1.0 - sine_squared, 0.0));
    let first = cosine + eta * other;
    let second = eta * cosine + other;
    if !(first > 0.0 && second > 0.0) {
        // Grazing light on a boundary of equal indices.
        return vec2f(0.0, other);
    }
    let parallel = (cosine - eta * other) / first;
    let perpendicular = (eta * cosine - other) / second;
    return vec2f(0.5 * (parallel * parallel + perpendicular * perpendicular), other);
}

fn schlick(head_on: vec3f, cosine: f32) -> vec3f {
    let x = clamp(1.0 - cosine, 0.0, 1.0);
    let x2 = x * x;
    return head_on + (1.0 - head_on) * (x2 * x2 * x);
}

fn schlick_mean(head_on: vec3f) -> vec3f {
    return (head_on * 20.0 + 1.0) / 21.0;
}
