// The boundary of two clear media, smooth or rough: twin of shade/bsdf/dielectric.rs.

fn refracted(view: vec3f, half: vec3f, cosine: f32, other: f32, eta: f32) -> vec3f {
    return half * (eta * cosine - other) - view * eta;
}

// What makes up for the light that single scattering loses.
fn dielectric_scale(bsdf: Bsdf, view: vec3f) -> f32 {
    if bsdf.table == 0u {
        return 1.0;
    }
    let table = select(bsdf.dense_table, bsdf.table, bsdf.eta < 1.0);
    return 1.0 / max(albedo_at(table, view.z, bsdf.roughness), 0.1);
}

// Facet that takes `light` to `view`, and its Fresnel part times the change of solid angle.
struct Facet {
    half: vec3f,
    part: f32,
    change: f32,
    is_there: bool,
}

fn facet_of(bsdf: Bsdf, view: vec3f, light: vec3f) -> Facet {
    if light.z > 0.0 {
        let half = half_of(view, light);
        let cosine = dot(view, half);
        return Facet(half, dielectric_reflectance(cosine, bsdf.eta).x, 1.0 / (4.0 * cosine), true);
    }
    let sum = view * bsdf.eta + light;
    let size = length(sum);
    let half = sum / size * select(-1.0, 1.0, sum.z >= 0.0);
    let cosine = dot(view, half);
    let other = dot(light, half);
    if !(size > 0.0 && cosine > 0.0 && other < 0.0) {
        return Facet(half, 0.0, 0.0, false);
    }
    let denominator = bsdf.eta * cosine + other;
    let part = 1.0 - dielectric_reflectance(cosine, bsdf.eta).x;
    return Facet(half, part, -other / (denominator * denominator), true);
}

fn dielectric_evaluate(bsdf: Bsdf, view: vec3f, light: vec3f) -> vec3f {
    if is_smooth(bsdf) || light.z == 0.0 {
        return vec3f(0.0);
    }
    return vec3f(
        dielectric_density(bsdf, view, light) * ggx_shadowing(bsdf.widths, view, light)
            * dielectric_scale(bsdf, view)
    );
}

fn dielectric_density(bsdf: Bsdf, view: vec3f, light: vec3f) -> f32 {
    if is_smooth(bsdf) || light.z == 0.0 {
        return 0.0;
    }
    let facet = facet_of(bsdf, view, light);
    if !facet.is_there {
        return 0.0;
    }
    return facet.part * ggx_visible(bsdf.widths, view, facet.half) * facet.change;
}

fn dielectric_sample(bsdf: Bsdf, view: vec3f, choice: f32, u: vec2f) -> BsdfSample {
    let is_mirror = is_smooth(bsdf);
    var half = vec3f(0.0, 0.0, 1.0);
    if !is_mirror {
        half = ggx_sample(bsdf.widths, view, u);
    }
    let cosine = dot(view, half);
    let fresnel = dielectric_reflectance(clamp(cosine, 0.0, 1.0), bsdf.eta);
    var light = half * (2.0 * cosine) - view;
    var scattering = REFLECTED;
    if fresnel.y >= 0.0 && choice >= fresnel.x {
        light = refracted(view, half, cosine, fresnel.y, bsdf.eta);
        scattering = REFRACTED;
    }
    if is_mirror {
        return only_direction(normalize(light), vec3f(1.0), scattering);
    }
    if (light.z > 0.0) != (scattering == REFLECTED) || light.z == 0.0 {
        return no_direction();
    }
    light = normalize(light);
    let density = dielectric_density(bsdf, view, light);
    if !(density > 0.0) {
        return no_direction();
    }
    let weight = ggx_shadowing(bsdf.widths, view, light) * dielectric_scale(bsdf, view);
    return BsdfSample(light, vec3f(weight), density, scattering, true);
}
