// Metals: twin of shade/bsdf/conductor.rs.

// What single scattering leaves for the light that is scattered again.
fn conductor_lost(bsdf: Bsdf, cosine: f32) -> f32 {
    return clamp(1.0 - albedo_at(picture.full_at, cosine, bsdf.roughness), 0.0, 1.0);
}

// BRDF of the light scattered more than once, without the two parts that are lost.
fn conductor_again(bsdf: Bsdf) -> vec3f {
    let kept = albedo_mean(picture.full_at, bsdf.roughness);
    let lost = 1.0 - kept;
    if lost < 1e-6 {
        return vec3f(0.0);
    }
    let mean = schlick_mean(bsdf.color);
    return mean * mean * kept / (1.0 - mean * lost) * (FRAC_1_PI / lost);
}

fn conductor_evaluate(bsdf: Bsdf, view: vec3f, light: vec3f) -> vec3f {
    if is_smooth(bsdf) || light.z <= 0.0 {
        return vec3f(0.0);
    }
    let half = half_of(view, light);
    let cosine = dot(view, half);
    let facets = ggx_visible(bsdf.widths, view, half) / (4.0 * cosine)
        * ggx_shadowing(bsdf.widths, view, light);
    let again = conductor_lost(bsdf, view.z) * conductor_lost(bsdf, light.z) * light.z;
    return schlick(bsdf.color, cosine) * facets + conductor_again(bsdf) * again;
}

fn conductor_density(bsdf: Bsdf, view: vec3f, light: vec3f) -> f32 {
    if is_smooth(bsdf) || light.z <= 0.0 {
        return 0.0;
    }
    let half = half_of(view, light);
    let facets = ggx_visible(bsdf.widths, view, half) / (4.0 * dot(view, half));
    let lost = conductor_lost(bsdf, view.z);
    return facets * (1.0 - lost) + light.z * FRAC_1_PI * lost;
}

fn conductor_sample(bsdf: Bsdf, view: vec3f, choice: f32, u: vec2f) -> BsdfSample {
    if is_smooth(bsdf) {
        return only_direction(mirrored(view), schlick(bsdf.color, view.z), REFLECTED);
    }
    var light = cosine_lobe(u);
    if choice >= conductor_lost(bsdf, view.z) {
        let half = ggx_sample(bsdf.widths, view, u);
        light = normalize(half * (2.0 * dot(view, half)) - view);
    }
    let density = conductor_density(bsdf, view, light);
    if !(light.z > 0.0 && density > 0.0) {
        return no_direction();
    }
    return BsdfSample(light, conductor_evaluate(bsdf, view, light) / density, density, REFLECTED, true);
}
