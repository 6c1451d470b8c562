// A level set around one of its points, and what it does to the hit of a ray: twin of math/level_set.rs.

struct LevelSet {
    gradient: vec3f,
    rate: f32,
    gradient_rate: vec3f,
    hessian: mat3x3f,
}

// How a place changes together with the normal there.
struct HitChange {
    position: vec3f,
    normal: vec3f,
}

fn flat_surface(normal: vec3f) -> LevelSet {
    return LevelSet(-normal, 0.0, vec3f(0.0), mat3x3f());
}

fn hit_change(surface: LevelSet, direction: vec3f, point_change: vec3f, secs: f32) -> HitChange {
    let along = dot(surface.gradient, direction);
    if along == 0.0 {
        return HitChange(vec3f(0.0), vec3f(0.0));
    }
    let steepness = length(surface.gradient);
    let t_change = -(dot(surface.gradient, point_change) + surface.rate * secs) / along;
    let position = point_change + direction * t_change;
    let normal = -surface.gradient / steepness;
    let change = surface.hessian * position + surface.gradient_rate * secs;
    return HitChange(position, (normal * dot(normal, change) - change) / steepness);
}

// Through a map to an object, its change per second, and that of a point.
fn seen_through(surface: LevelSet, map: mat3x3f, map_rate: mat3x3f, drift: vec3f) -> LevelSet {
    return LevelSet(
        surface.gradient * map,
        surface.rate + dot(surface.gradient, drift),
        (surface.gradient_rate + surface.hessian * drift) * map + surface.gradient * map_rate,
        transpose(map) * surface.hessian * map,
    );
}
