// The sky: twin of shade/light/sky.rs.

fn sky_radiance(horizon: vec3f, zenith: vec3f, nadir: vec3f, h: f32) -> vec3f {
    let rest = 1.0 - min(abs(h), 1.0);
    return mix(horizon, select(nadir, zenith, h >= 0.0), 1.0 - rest * rest);
}
