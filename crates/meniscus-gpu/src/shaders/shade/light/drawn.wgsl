// Lights that are drawn, found and met: the rest of shade/light/mod.rs.

// How much a light deserves to be drawn at a point.
fn importance(emitter: Emitter, point: vec3f) -> f32 {
    switch emitter.kind {
        case SUN: { return luminance(emitter.radiance); }
        case POINT: {
            let way = point - emitter.first;
            return luminance(emitter.radiance) / max(dot(way, way), TINY);
        }
        case BALL: { return luminance(ball_irradiance(emitter, point)); }
        case RECTANGLE: { return luminance(rectangle_irradiance(emitter, point)); }
        case IMAGE: { return emitter.mean; }
        default: { return 0.0; }
    }
}

fn total_importance(point: vec3f) -> f32 {
    var total = 0.0;
    for (var i = 0u; i < picture.emitter_count; i++) {
        total += importance(emitter_of(i), point);
    }
    return total;
}

// Whether directions are drawn towards it.
fn is_drawn(emitter: Emitter) -> bool {
    return emitter.kind != SKY && emitter.kind != CONSTANT;
}

fn light_sample(emitter: Emitter, point: vec3f, u: vec2f) -> LightSample {
    switch emitter.kind {
        case SUN: { return sun_sample(emitter, u); }
        case POINT: { return hard_light(emitter, point); }
        case BALL: { return ball_sample(emitter, point, u); }
        case RECTANGLE: { return rectangle_sample(emitter, point, u); }
        case IMAGE: { return image_sample(emitter, u); }
        default: { return no_light(); }
    }
}

fn light_density(emitter: Emitter, point: vec3f, direction: vec3f) -> f32 {
    switch emitter.kind {
        case SUN: { return sun_density(emitter); }
        case BALL: { return ball_density(emitter, point); }
        case RECTANGLE: { return rectangle_density(emitter, point, direction); }
        case IMAGE: { return image_density(emitter, direction); }
        default: { return 0.0; }
    }
}

// One light and a direction towards it, which counts for all lights.
struct DrawnLight {
    emitter: u32,
    sample: LightSample,
}

fn draw_light(point: vec3f, choice: f32, u: vec2f) -> DrawnLight {
    let total = total_importance(point);
    var drawn = NONE;
    var part = 0.0;
    var rest = choice * total;
    for (var i = 0u; i < picture.emitter_count; i++) {
        let own = importance(emitter_of(i), point);
        if own > 0.0 {
            drawn = i;
            part = own / total;
            if rest < own {
                break;
            }
            rest -= own;
        }
    }
    if drawn == NONE || !(total > 0.0 && total < FAR) {
        return DrawnLight(NONE, no_light());
    }
    var sample = light_sample(emitter_of(drawn), point, u);
    sample.weight /= part;
    if !is_far(sample.density) {
        sample.density *= part;
    }
    return DrawnLight(drawn, sample);
}

// Density with which draw_light draws a direction that finds a light.
fn drawn_density(emitter: Emitter, point: vec3f, direction: vec3f) -> f32 {
    let total = total_importance(point);
    if !(total > 0.0 && total < FAR) {
        return 0.0;
    }
    return importance(emitter, point) / total * light_density(emitter, point, direction);
}

// What a ray sees of a light that leaves everything behind.
fn escaped(emitter: Emitter, direction: vec3f) -> vec3f {
    switch emitter.kind {
        case SUN: { return sun_radiance(emitter, direction); }
        case SKY: { return sky_of(emitter, direction); }
        case CONSTANT: { return emitter.radiance; }
        case IMAGE: { return image_radiance(emitter, direction); }
        default: { return vec3f(0.0); }
    }
}

// The nearest light that a ray meets before `t_max`, and where.
struct MetLight {
    emitter: u32,
    t: f32,
}

fn light_met(origin: vec3f, direction: vec3f, t_max: f32) -> MetLight {
    var nearest = MetLight(NONE, t_max);
    for (var i = 0u; i < picture.emitter_count; i++) {
        let emitter = emitter_of(i);
        var t = -1.0;
        if emitter.kind == BALL {
            t = ball_met(emitter, origin, direction, nearest.t);
        } else if emitter.kind == RECTANGLE {
            t = rectangle_met(emitter, origin, direction, nearest.t);
        }
        if t > 0.0 {
            nearest = MetLight(i, t);
        }
    }
    return nearest;
}
