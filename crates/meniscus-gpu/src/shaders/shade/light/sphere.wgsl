// A ball that shines: twin of shade/light/sphere.rs. Numbers: its radius; vectors: its centre.

// sin² of half the angle under which it is seen; 1 or more inside.
fn ball_sine_squared(emitter: Emitter, point: vec3f) -> f32 {
    let away = emitter.first - point;
    return emitter.a * emitter.a / dot(away, away);
}

// 1 − cos of half that angle.
fn ball_height(emitter: Emitter, point: vec3f) -> f32 {
    let sine_squared = ball_sine_squared(emitter, point);
    return sine_squared / (1.0 + sqrt(max(1.0 - sine_squared, 0.0)));
}

fn ball_irradiance(emitter: Emitter, point: vec3f) -> vec3f {
    return emitter.radiance * min(ball_sine_squared(emitter, point), 1.0);
}

fn ball_density(emitter: Emitter, point: vec3f) -> f32 {
    if ball_sine_squared(emitter, point) >= 1.0 {
        return 0.25 / PI;
    }
    return 1.0 / (TAU * ball_height(emitter, point));
}

// Where a ray meets it; below 0: nowhere.
fn ball_met(emitter: Emitter, origin: vec3f, direction: vec3f, t_max: f32) -> f32 {
    let to_center = emitter.first - origin;
    let along = dot(to_center, direction);
    let miss = to_center - direction * along;
    let square = emitter.a * emitter.a - dot(miss, miss);
    if !(square >= 0.0) {
        return -1.0;
    }
    let half = sqrt(square);
    let t = select(along + half, along - half, along - half > 0.0);
    return select(-1.0, t, t > 0.0 && t < t_max);
}

fn ball_sample(emitter: Emitter, point: vec3f, u: vec2f) -> LightSample {
    var towards = uniform_sphere(u);
    let to_center = emitter.first - point;
    if ball_sine_squared(emitter, point) < 1.0 {
        towards = uniform_cap(normalize(to_center), ball_height(emitter, point), u);
    }
    var distance = ball_met(emitter, point, towards, FAR);
    if distance < 0.0 {
        distance = dot(to_center, towards);
    }
    let density = ball_density(emitter, point);
    return LightSample(towards, distance, emitter.radiance / density, density, true);
}
