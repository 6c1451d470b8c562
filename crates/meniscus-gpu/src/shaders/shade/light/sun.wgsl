// A disk at infinity: twin of shade/light/sun.rs. Numbers: 1 − cos of half its angle; 0: one direction.

fn sun_disk(emitter: Emitter) -> vec3f {
    let height = emitter.a;
    return emitter.radiance / (height * (2.0 - height));
}

fn sun_density(emitter: Emitter) -> f32 {
    return select(1.0 / (TAU * emitter.a), 0.0, emitter.a == 0.0);
}

fn sun_middle(emitter: Emitter) -> LightSample {
    return LightSample(emitter.first, FAR, emitter.radiance * PI, FAR, true);
}

fn sun_sample(emitter: Emitter, u: vec2f) -> LightSample {
    if emitter.a == 0.0 {
        return sun_middle(emitter);
    }
    let density = sun_density(emitter);
    let towards = uniform_cap(emitter.first, emitter.a, u);
    return LightSample(towards, FAR, sun_disk(emitter) / density, density, true);
}

fn sun_radiance(emitter: Emitter, direction: vec3f) -> vec3f {
    let away = direction - emitter.first;
    let height = 0.5 * dot(away, away);
    if emitter.a == 0.0 || height > emitter.a {
        return vec3f(0.0);
    }
    return sun_disk(emitter);
}
