//! Whether a scene makes sense, beyond what its types say.

mod company;
mod keys;

use super::camera::{Camera, CameraError, CameraSettings};
use super::engine::MOST_TIME_SLABS;
use super::file::suggest::help_for;
use super::file::{SceneError, SceneErrorKind};
use super::film::{
    Background, FilmSettings, MAX_KELVIN, MAX_PIXELS, MAX_SIDE, MAX_SPP, MIN_KELVIN,
};
use super::integrator::MAX_AO_SAMPLES;
use super::{Color, Instance, Scene};
use super::{Surface, Weights, WhiteBalance};
use company::check_matrix;
use glam::DVec3;

mod looks;

type Checked = Result<(), SceneError>;

fn invalid(key: impl Into<String>, message: impl Into<String>) -> SceneError {
    SceneError::new(SceneErrorKind::Invalid, message).at(key)
}

fn unsupported(key: impl Into<String>, what: &str, can: &str) -> SceneError {
    SceneError::new(
        SceneErrorKind::Unsupported,
        format!("{what} is not supported yet"),
    )
    .with_help(format!("this version can do {can}"))
    .at(key)
}

fn require(holds: bool, key: impl Into<String>, message: impl Into<String>) -> Checked {
    if holds {
        Ok(())
    } else {
        Err(invalid(key, message))
    }
}

impl Scene {
    /// Checks that everything in the scene can be rendered: ranges, names that are used, and what
    /// this version supports. Files are not opened.
    ///
    /// # Errors
    /// The first problem found, in the order of the scene's keys.
    pub fn validate(&self) -> Result<(), SceneError> {
        check_camera(&self.camera)?;
        check_film(&self.film)?;
        company::check_motion(&self.motion)?;
        company::check_cues(&self.cues)?;
        self.check_integrator()?;
        self.check_engine()?;
        for (i, surface) in self.surfaces.iter().enumerate() {
            check_surface(&format!("surface.{i}"), surface)?;
            self.check_material(
                &format!("surface.{i}.material"),
                surface.material.as_deref(),
            )?;
            if let Some(name) = &surface.name {
                let twin = self.surfaces[..i]
                    .iter()
                    .position(|s| s.name.as_ref() == Some(name));
                if let Some(twin) = twin {
                    let message = format!("surface {twin} is called `{name}` already");
                    return Err(invalid(format!("surface.{i}.name"), message));
                }
            }
        }
        for (i, instance) in self.instances.iter().enumerate() {
            self.check_instance(&format!("instance.{i}"), instance)?;
        }
        self.check_company()?;
        if let Some(ground) = &self.ground {
            let finite = ground.height.is_none_or(f64::is_finite);
            require(finite, "ground.height", "`height` must be a finite number")?;
            self.check_material("ground.material", ground.material.as_deref())?;
        }
        for (i, light) in self.lights.iter().enumerate() {
            looks::check_light(&format!("light.{i}"), light)?;
        }
        for (name, material) in &self.materials {
            looks::check_material(&format!("material.{name}"), material)?;
        }
        let shows_something =
            !self.surfaces.is_empty() || self.has_company() || self.ground.is_some();
        if !shows_something {
            return Err(invalid("", "the scene shows nothing")
                .with_help("add a [[surface]] with a `file` of particles"));
        }
        Ok(())
    }

    fn check_integrator(&self) -> Checked {
        let settings = &self.integrator;
        for (name, value) in [("distance", settings.distance), ("clamp", settings.clamp)] {
            check_positive(&format!("integrator.{name}"), value)?;
        }
        if let Some(samples) = settings.samples {
            require(
                (1..=MAX_AO_SAMPLES).contains(&samples),
                "integrator.samples",
                format!("`samples` must be 1 to {MAX_AO_SAMPLES}, not {samples}"),
            )?;
        }
        require(
            settings.depth >= 1,
            "integrator.depth",
            "`depth` must be at least 1",
        )
    }

    fn check_engine(&self) -> Checked {
        let slabs = self.engine.time_slabs;
        require(
            slabs <= MOST_TIME_SLABS,
            "engine.time_slabs",
            format!(
                "`time_slabs` must be 0 (by the particles' motion) to {MOST_TIME_SLABS}, not {slabs}"
            ),
        )
    }

    fn check_material(&self, key: &str, name: Option<&str>) -> Checked {
        let Some(name) = name else { return Ok(()) };
        if self.materials.contains_key(name) {
            return Ok(());
        }
        let known: Vec<&str> = self.materials.keys().map(String::as_str).collect();
        let help = if known.is_empty() {
            format!("define it: [material.{name}]")
        } else {
            help_for(name, &known, "the scene defines")
        };
        Err(invalid(key, format!("there is no material `{name}`")).with_help(help))
    }

    fn check_instance(&self, key: &str, instance: &Instance) -> Checked {
        let name = &instance.surface;
        let known: Vec<&str> = self
            .surfaces
            .iter()
            .filter_map(|s| s.name.as_deref())
            .collect();
        if !known.contains(&name.as_str()) {
            let help = if known.is_empty() {
                "give the [[surface]] a `name`".to_owned()
            } else {
                help_for(name, &known, "the surfaces are")
            };
            let message = format!("there is no surface `{name}`");
            return Err(invalid(format!("{key}.surface"), message).with_help(help));
        }
        check_matrix(&format!("{key}.matrix"), &instance.matrix)?;
        keys::check_placements(key, instance)?;
        self.check_material(&format!("{key}.material"), instance.material.as_deref())
    }
}

fn check_camera(camera: &CameraSettings) -> Checked {
    require(
        camera.fov > 0.0 && camera.fov < 180.0,
        "camera.fov",
        format!(
            "`fov` is the vertical angle in degrees, between 0 and 180, not {}",
            camera.fov
        ),
    )?;
    check_direction("camera.up", camera.up.0)?;
    for (key, point) in [("camera.eye", camera.eye), ("camera.target", camera.target)] {
        if let Some(point) = point {
            check_point(key, point)?;
        }
    }
    keys::check_camera(camera)?;
    let (Some(eye), Some(target)) = (camera.eye, camera.target) else {
        return Ok(());
    };
    match Camera::new(eye, target, camera.up.0, camera.fov.to_radians(), [1, 1]) {
        Ok(_) => Ok(()),
        Err(CameraError::Up) => Err(invalid(
            "camera.up",
            "`up` points along the view, from eye to target",
        )
        .with_help("choose another up, for example one of x, y, z")),
        Err(_) => Err(invalid(
            "camera.eye",
            "`eye` and `target` are the same point",
        )),
    }
}

fn check_film(film: &FilmSettings) -> Checked {
    for (name, side) in [("width", film.width), ("height", film.height)] {
        require(
            (1..=MAX_SIDE).contains(&side),
            format!("film.{name}"),
            format!("`{name}` must be 1 to {MAX_SIDE} pixels, not {side}"),
        )?;
    }
    let pixels = u64::from(film.width) * u64::from(film.height);
    require(
        pixels <= MAX_PIXELS,
        "film.width",
        format!(
            "{} x {} is more than {MAX_PIXELS} pixels",
            film.width, film.height
        ),
    )?;
    require(
        (1..=MAX_SPP).contains(&film.spp),
        "film.spp",
        format!(
            "`spp` must be 1 to {MAX_SPP} samples per pixel, not {}",
            film.spp
        ),
    )?;
    require(
        film.exposure.abs() <= 100.0,
        "film.exposure",
        format!("`exposure` is in stops, −100 to 100, not {}", film.exposure),
    )?;
    if let Some(noise) = film.noise {
        require(
            noise > 0.0 && noise < 1.0,
            "film.noise",
            format!("`noise` is relative, between 0 and 1 (0.02 is 2 %), not {noise}"),
        )?;
    }
    match film.white_balance {
        Some(WhiteBalance::Kelvin(kelvin)) => require(
            (MIN_KELVIN..=MAX_KELVIN).contains(&kelvin),
            "film.white_balance",
            format!("`white_balance` is {MIN_KELVIN} to {MAX_KELVIN} kelvin, not {kelvin}"),
        )?,
        Some(WhiteBalance::Color(color)) => require(
            color.0.into_iter().all(|c| c > 0.0 && c.is_finite()),
            "film.white_balance",
            "`white_balance` must have components above 0",
        )?,
        None => {}
    }
    if let Some(Background::Color(color)) = film.background {
        check_radiance("film.background", color)?;
    }
    Ok(())
}

fn check_surface(key: &str, surface: &Surface) -> Checked {
    if !surface.kind.is_supported() {
        let what = format!("surface type `{}`", surface.kind.name());
        return Err(unsupported(format!("{key}.type"), &what, "blobs"));
    }
    require(
        !surface.file.as_os_str().is_empty(),
        format!("{key}.file"),
        "the surface has no particles: the key `file` is missing",
    )?;
    let positive = [
        ("radius", surface.radius),
        ("support", surface.support),
        ("smoothing", surface.smoothing),
        ("threshold", surface.threshold),
    ];
    for (name, value) in positive {
        if let Some(value) = value {
            require(
                value > 0.0 && value.is_finite(),
                format!("{key}.{name}"),
                format!("`{name}` must be a positive number, not {value}"),
            )?;
        }
    }
    if let Some(probability) = surface.probability {
        require(
            probability > 0.0 && probability < 1.0,
            format!("{key}.probability"),
            format!("`probability` must be above 0 and below 1, not {probability}"),
        )?;
    }
    if surface.radius.is_some() && surface.support.is_some() {
        return Err(invalid(
            format!("{key}.radius"),
            "`radius` has no effect beside `support`, which overrides all radii",
        )
        .with_help("leave out one of them"));
    }
    let texts = [
        ("name", surface.name.as_deref()),
        ("filter", surface.filter.as_deref()),
        ("weights", surface.weights.as_ref().map(Weights::name)),
        ("color_by", surface.color_by.as_deref()),
        ("roughness_by", surface.roughness_by.as_deref()),
        ("absorption_by", surface.absorption_by.as_deref()),
    ];
    for (name, text) in texts {
        require(
            text.is_none_or(|text| !text.is_empty()),
            format!("{key}.{name}"),
            format!("`{name}` is empty"),
        )?;
    }
    let ranges = [
        ("color_range", surface.color_range),
        ("roughness_range", surface.roughness_range),
        ("absorption_range", surface.absorption_range),
    ];
    for (name, range) in ranges {
        let Some([low, high]) = range else { continue };
        require(
            low.is_finite() && high.is_finite() && low < high,
            format!("{key}.{name}"),
            format!("`{name}` must be two numbers, the smaller first, not {low} and {high}"),
        )?;
    }
    Ok(())
}

/// A number that may be missing, and is above 0 if it is there.
fn check_positive(key: &str, value: Option<f64>) -> Checked {
    let Some(value) = value else { return Ok(()) };
    let name = last_step(key);
    require(
        value > 0.0 && value.is_finite(),
        key,
        format!("`{name}` must be a positive number, not {value}"),
    )
}

fn check_point(key: &str, point: DVec3) -> Checked {
    let name = last_step(key);
    require(
        point.is_finite(),
        key,
        format!("`{name}` must be three finite numbers"),
    )
}

fn check_direction(key: &str, direction: DVec3) -> Checked {
    let name = last_step(key);
    require(
        direction.try_normalize().is_some(),
        key,
        format!("`{name}` must be a direction: three finite numbers, not all 0"),
    )
}

fn check_radiance(key: &str, color: Color) -> Checked {
    let name = last_step(key);
    require(
        color.0.into_iter().all(|c| c >= 0.0 && c.is_finite()),
        key,
        format!("`{name}` must have components of 0 or more"),
    )
}

fn last_step(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}
