// Thin froth: twin of shade/bsdf/foam.rs.

fn foam_density(bsdf: Bsdf, light: vec3f) -> f32 {
    let part = select(bsdf.translucency, 1.0 - bsdf.translucency, light.z > 0.0);
    return part * abs(light.z) * FRAC_1_PI;
}

fn foam_evaluate(bsdf: Bsdf, light: vec3f) -> vec3f {
    return bsdf.color * foam_density(bsdf, light);
}

fn foam_sample(bsdf: Bsdf, choice: f32, u: vec2f) -> BsdfSample {
    var light = cosine_lobe(u);
    if choice < bsdf.translucency {
        light.z = -light.z;
    }
    return BsdfSample(light, bsdf.color, foam_density(bsdf, light), SCATTERED, light.z != 0.0);
}
