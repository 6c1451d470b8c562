// Where light comes from: twin of shade/light/mod.rs and shade/integrator/ambient.rs.

struct Emitter {
    kind: u32,
    a: f32,
    b: f32,
    at: f32,
    radiance: vec3f,
    // Luminance of an image's mean.
    mean: f32,
    first: vec3f,
    second: vec3f,
    third: vec3f,
}

const SUN: u32 = 0u;
const POINT: u32 = 1u;
const BALL: u32 = 2u;
const RECTANGLE: u32 = 3u;
const SKY: u32 = 4u;
const CONSTANT: u32 = 5u;
const IMAGE: u32 = 6u;

// Light that comes from a drawn direction: radiance over density in `weight`; density FAR where there is
// but one direction.
struct LightSample {
    towards: vec3f,
    distance: f32,
    weight: vec3f,
    density: f32,
    is_there: bool,
}

fn no_light() -> LightSample {
    return LightSample(vec3f(0.0), 0.0, vec3f(0.0), 0.0, false);
}

fn emitter_of(index: u32) -> Emitter {
    let at = picture.emitters_at + index * EMITTER_WORDS;
    let head = words[at];
    let radiance = words[at + 1u];
    return Emitter(
        u32(head.x), head.y, head.z, head.w, radiance.xyz, radiance.w,
        words[at + 2u].xyz, words[at + 3u].xyz, words[at + 4u].xyz,
    );
}

fn luminance(color: vec3f) -> f32 {
    return dot(color, vec3f(0.2126, 0.7152, 0.0722));
}

// Smallest square of a distance.
const TINY: f32 = 1e-37;

fn hard_at(position: vec3f, point: vec3f, irradiance: vec3f) -> LightSample {
    let way = position - point;
    let distance = length(way);
    if !(distance > 0.0) {
        return no_light();
    }
    return LightSample(way / distance, distance, irradiance * PI, FAR, true);
}

// A light as a single direction, for hard shadows.
fn hard_light(emitter: Emitter, point: vec3f) -> LightSample {
    switch emitter.kind {
        case SUN: {
            return sun_middle(emitter);
        }
        case POINT: {
            let way = point - emitter.first;
            return hard_at(emitter.first, point, emitter.radiance / max(dot(way, way), TINY));
        }
        case BALL: {
            return hard_at(emitter.first, point, ball_irradiance(emitter, point));
        }
        case RECTANGLE: {
            return hard_at(emitter.first, point, rectangle_irradiance(emitter, point));
        }
        default: {
            return no_light();
        }
    }
}

fn sky_of(emitter: Emitter, direction: vec3f) -> vec3f {
    return sky_radiance(emitter.first, emitter.second, emitter.third, dot(direction, picture.up));
}

// Radiance from all that surrounds the scene but suns.
fn surroundings(direction: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < picture.emitter_count; i++) {
        let emitter = emitter_of(i);
        if emitter.kind == SKY {
            sum += sky_of(emitter, direction);
        } else if emitter.kind == CONSTANT {
            sum += emitter.radiance;
        } else if emitter.kind == IMAGE {
            sum += image_radiance(emitter, direction);
        }
    }
    return sum;
}

// What surrounds the scene, or a default sky.
fn backdrop(direction: vec3f) -> vec3f {
    if picture.has_surroundings != 0u {
        return surroundings(direction);
    }
    let at = picture.ambient_at + 14u;
    return sky_radiance(words[at].xyz, words[at + 1u].xyz, words[at + 2u].xyz, dot(direction, picture.up));
}

const BACKGROUND_SKY: u32 = 0u;
const BACKGROUND_TRANSPARENT: u32 = 1u;

// What the eye's own rays see where no surface is.
fn behind(direction: vec3f) -> vec3f {
    if picture.background == BACKGROUND_SKY {
        return backdrop(direction);
    }
    return vec3f(0.0);
}

// Radiance of a white diffuse surface that nothing shades.
fn ambient(normal: vec3f) -> vec3f {
    let at = picture.ambient_at;
    let h = dot(normal, picture.up);
    let a = words[at + 1u].xyz;
    let b = words[at + 2u].xyz;
    let c = words[at + 3u].xyz;
    let d = words[at + 4u].xyz;
    let sky = max(a + (b + (c + d * (h * h)) * h) * h, vec3f(0.0));
    var basis = array(
        0.28209479, 0.48860251 * normal.y, 0.48860251 * normal.z, 0.48860251 * normal.x,
        1.09254843 * normal.x * normal.y, 1.09254843 * normal.y * normal.z,
        0.31539157 * (3.0 * normal.z * normal.z - 1.0), 1.09254843 * normal.x * normal.z,
        0.54627422 * (normal.x * normal.x - normal.y * normal.y),
    );
    var image = vec3f(0.0);
    for (var k = 0u; k < 9u; k++) {
        image += words[at + 5u + k].xyz * basis[k];
    }
    return words[at].xyz + sky + max(image, vec3f(0.0));
}
