// A parallelogram that shines on one side: twin of shade/light/rectangle.rs. Vectors: centre, edges.

// Its unit normal and area.
fn rectangle_face(emitter: Emitter) -> vec4f {
    let face = cross(emitter.second, emitter.third);
    let area = length(face);
    return vec4f(face / area, area);
}

fn rectangle_irradiance(emitter: Emitter, point: vec3f) -> vec3f {
    let face = rectangle_face(emitter);
    let away = point - emitter.first;
    let distance = length(away);
    let height = dot(away, face.xyz);
    if height <= 0.0 {
        return vec3f(0.0);
    }
    let solid = face.w * (height / distance) / (distance * distance + face.w * FRAC_1_PI);
    return emitter.radiance * (solid * FRAC_1_PI);
}

// Where a ray meets it; below 0: nowhere.
fn rectangle_met(emitter: Emitter, origin: vec3f, direction: vec3f, t_max: f32) -> f32 {
    let face = rectangle_face(emitter);
    let rate = -dot(direction, face.xyz);
    if rate <= 0.0 {
        return -1.0;
    }
    let t = dot(origin - emitter.first, face.xyz) / rate;
    if !(t > 0.0 && t < t_max) {
        return -1.0;
    }
    let place = origin + direction * t - emitter.first;
    let x = dot(cross(place, emitter.third), face.xyz) / face.w;
    let y = dot(cross(place, emitter.second), face.xyz) / face.w;
    return select(-1.0, t, abs(x) <= 0.5 && abs(y) <= 0.5);
}

fn rectangle_density(emitter: Emitter, point: vec3f, direction: vec3f) -> f32 {
    let t = rectangle_met(emitter, point, direction, FAR);
    if t < 0.0 {
        return 0.0;
    }
    let face = rectangle_face(emitter);
    return t * t / (-dot(direction, face.xyz) * face.w);
}

fn rectangle_sample(emitter: Emitter, point: vec3f, u: vec2f) -> LightSample {
    let face = rectangle_face(emitter);
    let place = emitter.first + emitter.second * (u.x - 0.5) + emitter.third * (u.y - 0.5);
    let way = place - point;
    let distance = length(way);
    let towards = way / distance;
    let cosine = -dot(towards, face.xyz);
    if !(cosine > 0.0 && distance > 0.0) {
        return no_light();
    }
    let density = distance * distance / (cosine * face.w);
    return LightSample(towards, distance, emitter.radiance / density, density, true);
}
