// A thin clear sheet with parallel faces: twin of shade/bsdf/sheet.rs.

struct Sheet {
    reflected: vec3f,
    transmitted: vec3f,
}

// `eta`: the index around the sheet over its own; `depth`: the optical depth of its thickness.
fn sheet_of(cosine: f32, eta: f32, depth: vec3f) -> Sheet {
    let fresnel = dielectric_reflectance(clamp(cosine, 0.0, 1.0), eta);
    let face = fresnel.x;
    if !(fresnel.y > 0.0 && face < 1.0) {
        return Sheet(vec3f(1.0), vec3f(0.0));
    }
    let once = exp(-depth / fresnel.y);
    let transmitted = (1.0 - face) * (1.0 - face) * once / (1.0 - (face * once) * (face * once));
    return Sheet(face * (1.0 + once * transmitted), transmitted);
}

// The way straight through, taken for certain.
fn sheet_through(sheet: Sheet, view: vec3f) -> BsdfSample {
    return only_direction(-view, sheet.transmitted, REFRACTED);
}

// One of both ways.
fn sheet_sample(sheet: Sheet, view: vec3f, choice: f32) -> BsdfSample {
    let reflected = luminance(sheet.reflected);
    let part = reflected / (reflected + luminance(sheet.transmitted));
    if choice < part {
        return only_direction(mirrored(view), sheet.reflected / part, REFLECTED);
    }
    return only_direction(-view, sheet.transmitted / (1.0 - part), REFRACTED);
}
