// Lambert's law: twin of shade/bsdf/diffuse.rs.

fn diffuse_evaluate(bsdf: Bsdf, light: vec3f) -> vec3f {
    return bsdf.color * diffuse_density(light);
}

fn diffuse_density(light: vec3f) -> f32 {
    return max(light.z, 0.0) * FRAC_1_PI;
}

fn diffuse_sample(bsdf: Bsdf, u: vec2f) -> BsdfSample {
    let light = cosine_lobe(u);
    return BsdfSample(light, bsdf.color, diffuse_density(light), SCATTERED, light.z > 0.0);
}
