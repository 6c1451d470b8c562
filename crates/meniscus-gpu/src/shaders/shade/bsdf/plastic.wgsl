// A clear coat on a diffuse base: twin of shade/bsdf/plastic.rs.

// Reflectance of a facet of the coat.
fn coat_facet(bsdf: Bsdf, cosine: f32) -> f32 {
    return bsdf.strength * dielectric_reflectance(clamp(cosine, 0.0, 1.0), 1.0 / bsdf.coat_ior).x;
}

// What the coat reflects in all at a cosine.
fn coat_albedo(bsdf: Bsdf, cosine: f32) -> f32 {
    return clamp(albedo_at(bsdf.table, cosine, bsdf.roughness), 0.0, 1.0);
}

// Probability that a sample goes to the coat.
fn coat_share(bsdf: Bsdf, view: vec3f) -> f32 {
    let coat = coat_albedo(bsdf, view.z);
    let base = luminance(bsdf.color) * (1.0 - coat);
    if coat + base > 0.0 {
        return coat / (coat + base);
    }
    return 0.0;
}

// The base alone, times cosine.
fn plastic_base(bsdf: Bsdf, view: vec3f, light: vec3f) -> vec3f {
    let rest = 1.0 - albedo_mean(bsdf.table, bsdf.roughness);
    if rest < 1e-6 {
        return vec3f(0.0);
    }
    let through = (1.0 - coat_albedo(bsdf, view.z)) * (1.0 - coat_albedo(bsdf, light.z)) / rest;
    return bsdf.color * (through * light.z * FRAC_1_PI);
}

fn plastic_facets(bsdf: Bsdf, view: vec3f, half: vec3f) -> f32 {
    return ggx_visible(bsdf.widths, view, half) / (4.0 * dot(view, half));
}

fn plastic_evaluate(bsdf: Bsdf, view: vec3f, light: vec3f) -> vec3f {
    if light.z <= 0.0 {
        return vec3f(0.0);
    }
    let base = plastic_base(bsdf, view, light);
    if is_smooth(bsdf) {
        return base;
    }
    let half = half_of(view, light);
    let coat = coat_facet(bsdf, dot(view, half)) * plastic_facets(bsdf, view, half)
        * ggx_shadowing(bsdf.widths, view, light);
    return base + coat;
}

fn plastic_density(bsdf: Bsdf, view: vec3f, light: vec3f) -> f32 {
    if light.z <= 0.0 {
        return 0.0;
    }
    let share = coat_share(bsdf, view);
    let base = (1.0 - share) * light.z * FRAC_1_PI;
    if is_smooth(bsdf) {
        return base;
    }
    return base + share * plastic_facets(bsdf, view, half_of(view, light));
}

fn plastic_sample(bsdf: Bsdf, view: vec3f, choice: f32, u: vec2f) -> BsdfSample {
    let share = coat_share(bsdf, view);
    let goes_to_coat = choice < share;
    if goes_to_coat && is_smooth(bsdf) {
        return only_direction(mirrored(view), vec3f(coat_facet(bsdf, view.z) / share), REFLECTED);
    }
    var light = cosine_lobe(u);
    if goes_to_coat {
        let half = ggx_sample(bsdf.widths, view, u);
        light = normalize(half * (2.0 * dot(view, half)) - view);
    }
    let density = plastic_density(bsdf, view, light);
    if !(light.z > 0.0 && density > 0.0) {
        return no_direction();
    }
    let scattering = select(SCATTERED, REFLECTED, goes_to_coat);
    return BsdfSample(light, plastic_evaluate(bsdf, view, light) / density, density, scattering, true);
}
