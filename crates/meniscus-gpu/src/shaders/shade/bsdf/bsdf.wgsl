// How a surface scatters light: twin of shade/bsdf/mod.rs. Directions are in a frame whose z axis is the
// normal on the viewer's side.

const DIFFUSE: u32 = 0u;
const CONDUCTOR: u32 = 1u;
const COATED: u32 = 2u;
const CLEAR: u32 = 3u;
const SHEET: u32 = 4u;
const FOAM: u32 = 5u;

// GGX widths below this are perfectly smooth.
const SMOOTH: f32 = 1e-3;

struct Bsdf {
    kind: u32,
    color: vec3f,
    roughness: f32,
    // Of facets, along x and y; 0 where there are none.
    widths: vec2f,
    translucency: f32,
    // Of a coat.
    strength: f32,
    coat_ior: f32,
    // Of a coat; or of a boundary seen from its thin side, and from its dense one.
    table: u32,
    dense_table: u32,
    // Index on the viewer's side over that beyond.
    eta: f32,
}

// What a scattered ray counts as.
const SCATTERED: u32 = 0u;
const REFLECTED: u32 = 1u;
const REFRACTED: u32 = 2u;

// BSDF times cosine over density in `weight`; density FAR where the direction is the only one.
struct BsdfSample {
    light: vec3f,
    weight: vec3f,
    density: f32,
    scattering: u32,
    is_there: bool,
}

fn only_direction(light: vec3f, weight: vec3f, scattering: u32) -> BsdfSample {
    return BsdfSample(light, weight, FAR, scattering, true);
}

fn no_direction() -> BsdfSample {
    return BsdfSample(vec3f(0.0), vec3f(0.0), 0.0, SCATTERED, false);
}

fn mirrored(view: vec3f) -> vec3f {
    return vec3f(-view.xy, view.z);
}

fn half_of(view: vec3f, light: vec3f) -> vec3f {
    let sum = view + light;
    let size = length(sum);
    return select(vec3f(0.0, 0.0, 1.0), sum / size, size > 0.0);
}

// Opaque surfaces have at least the roughness `least`; `indices`: on the viewer's side and beyond.
fn bsdf_of(material: Material, least: f32, indices: vec2f) -> Bsdf {
    var roughness = material.roughness;
    if material.scattering == CONDUCTOR || material.scattering == COATED {
        roughness = max(roughness, least);
    }
    let eta = indices.x / indices.y;
    var width = roughness * roughness;
    let is_rough = material.table != 0u && abs(eta - 1.0) > 1e-6;
    if material.scattering == CLEAR && !is_rough {
        width = 0.0;
    }
    return Bsdf(
        material.scattering, material.color, roughness, vec2f(width), material.translucency, material.strength,
        material.coat_ior, material.table, material.dense_table, eta,
    );
}

fn is_smooth(bsdf: Bsdf) -> bool {
    return max(bsdf.widths.x, bsdf.widths.y) < SMOOTH;
}

// The highlight of a coat or metal, wider by `added` to the squares of its widths; others stay as they are.
// What stays a mirror across is made just rough there.
fn widened(bsdf: Bsdf, added: vec2f) -> Bsdf {
    let has_highlight = bsdf.kind == CONDUCTOR || bsdf.kind == COATED;
    if !has_highlight || (!WIDENS_MIRRORS && is_smooth(bsdf)) {
        return bsdf;
    }
    var wider = bsdf;
    let squares = min(bsdf.widths * bsdf.widths + added, vec2f(1.0));
    let least = select(0.0, SMOOTH, sqrt(max(squares.x, squares.y)) >= SMOOTH);
    wider.widths = max(sqrt(squares), vec2f(least));
    wider.roughness = sqrt(sqrt(0.5 * (squares.x + squares.y)));
    return wider;
}

// BSDF times |cos| of the light's angle, without what only one direction has.
fn bsdf_evaluate(bsdf: Bsdf, view: vec3f, light: vec3f) -> vec3f {
    switch bsdf.kind {
        case DIFFUSE: { return diffuse_evaluate(bsdf, light); }
        case CONDUCTOR: { return conductor_evaluate(bsdf, view, light); }
        case COATED: { return plastic_evaluate(bsdf, view, light); }
        case CLEAR: { return dielectric_evaluate(bsdf, view, light); }
        case FOAM: { return foam_evaluate(bsdf, light); }
        default: { return vec3f(0.0); }
    }
}

// Density with which bsdf_sample draws `light`.
fn bsdf_density(bsdf: Bsdf, view: vec3f, light: vec3f) -> f32 {
    switch bsdf.kind {
        case DIFFUSE: { return diffuse_density(light); }
        case CONDUCTOR: { return conductor_density(bsdf, view, light); }
        case COATED: { return plastic_density(bsdf, view, light); }
        case CLEAR: { return dielectric_density(bsdf, view, light); }
        case FOAM: { return foam_density(bsdf, light); }
        default: { return 0.0; }
    }
}

fn bsdf_sample(bsdf: Bsdf, view: vec3f, choice: f32, u: vec2f) -> BsdfSample {
    switch bsdf.kind {
        case DIFFUSE: { return diffuse_sample(bsdf, u); }
        case CONDUCTOR: { return conductor_sample(bsdf, view, choice, u); }
        case COATED: { return plastic_sample(bsdf, view, choice, u); }
        case CLEAR: { return dielectric_sample(bsdf, view, choice, u); }
        case FOAM: { return foam_sample(bsdf, choice, u); }
        default: { return no_direction(); }
    }
}

// Whether light from any but a few single directions counts.
fn is_spread(bsdf: Bsdf) -> bool {
    switch bsdf.kind {
        case DIFFUSE, FOAM: { return true; }
        case CONDUCTOR, CLEAR: { return !is_smooth(bsdf); }
        case COATED: { return any(bsdf.color != vec3f(0.0)) || !is_smooth(bsdf); }
        default: { return false; }
    }
}

// Whether light comes from behind the surface, too.
fn is_two_sided(bsdf: Bsdf) -> bool {
    return bsdf.kind == FOAM || bsdf.kind == CLEAR;
}
