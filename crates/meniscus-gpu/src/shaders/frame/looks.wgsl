// A picture and its frame's looks, as the library packs them: twin of shade/stages/ and
// render/stages.rs.

struct Picture {
    // Positions are relative to the origin of the stages.
    eye: vec3f,
    pixel_side: f32,
    eye_low: vec3f,
    pixel_side_low: f32,
    // The camera's axes as sums of two f32; half the picture's size in pixels.
    forward: vec3f,
    half_width: f32,
    forward_low: vec3f,
    half_height: f32,
    right: vec3f,
    shutter_open: f32,
    right_low: vec3f,
    shutter_secs: f32,
    above: vec3f,
    // Of `ao`.
    reach: f32,
    above_low: vec3f,
    // Of `path`; below 0: none.
    clamp: f32,
    // Of the world.
    up: vec3f,
    has_surroundings: u32,
    ground_center: vec3f,
    ground_radius: f32,
    ground_surface: u32,
    // 0 the sky, 1 nothing, 2 a colour.
    background: u32,
    eye_side: u32,
    has_caustics: u32,
    // The block of samples.
    region: vec4u,
    first_sample: u32,
    first_pixel: u32,
    count: u32,
    spp: u32,
    seed: u32,
    // Strata of the shutter's time.
    time_strata: f32,
    media: u32,
    medium_count: u32,
    surfaces_at: u32,
    materials_at: u32,
    emitters_at: u32,
    ambient_at: u32,
    full_at: u32,
    filter_at: u32,
    surface_count: u32,
    emitter_count: u32,
    ao_samples: u32,
    depth: u32,
    diffuse_depth: u32,
    glossy_depth: u32,
    transmission_depth: u32,
    // Whether light may pass clear surfaces on its way, so that those are looked for one by one.
    light_walks: u32,
    // The camera's way in pieces, where it moves.
    camera_at: u32,
    camera_pieces: u32,
    // Planes that cut: (normal, height of the origin over it), (–, –, –, low part of the height).
    cuts_at: u32,
    cut_count: u32,
    // What a sample stands for where highlights are widened: twin of SpecularFilter. 0: they are not.
    pixel_variance: f32,
    time_variance: f32,
}

@group(0) @binding(0) var<uniform> picture: Picture;
@group(0) @binding(1) var<storage, read> words: array<vec4f>;

// Stands for infinity.
const FAR: f32 = 3e38;

fn is_far(x: f32) -> bool {
    return x > 1e38;
}

// The largest coordinate.
fn size_of(v: vec3f) -> f32 {
    return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

// Number `index` of those that begin at a word.
fn number(at: u32, index: u32) -> f32 {
    return words[at + (index >> 2u)][index & 3u];
}

const PLANE: u32 = 1u;
const SPHERE: u32 = 2u;
const MESH: u32 = 3u;

fn surface_word(surface: u32) -> u32 {
    return picture.surfaces_at + surface * SURFACE_WORDS;
}

struct Material {
    color: vec3f,
    translucency: f32,
    absorption: vec3f,
    ior: f32,
    // Head on, grazing, width; width 0: none.
    gloss: vec3f,
    scattering: u32,
    roughness: f32,
    strength: f32,
    coat_ior: f32,
    table: u32,
    dense_table: u32,
    priority: f32,
    is_medium: bool,
    varies: u32,
}

// In `varies`: colour or roughness follow particles' attributes; absorption does.
const LOOK_VARIES: u32 = 1u;
const ABSORPTION_VARIES: u32 = 2u;

fn material_word(surface: u32) -> u32 {
    return picture.materials_at + u32(words[surface_word(surface)].y) * MATERIAL_WORDS;
}

fn material_of(surface: u32) -> Material {
    let at = material_word(surface);
    let color = words[at];
    let inside = words[at + 1u];
    let gloss = words[at + 2u];
    let scattering = words[at + 3u];
    let rest = words[at + 4u];
    return Material(
        color.xyz, color.w, inside.xyz, inside.w, gloss.xyz,
        u32(scattering.x), scattering.y, scattering.z, scattering.w,
        u32(rest.x), u32(rest.y), rest.z, rest.w > 0.5, u32(gloss.w),
    );
}

// How much of a surface's own look is left at a point.
fn opacity_of(surface: u32, position: vec3f) -> f32 {
    if surface != picture.ground_surface {
        return 1.0;
    }
    let far = length(position - picture.ground_center) / picture.ground_radius;
    let t = clamp((4.0 - far) / 3.0, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}
