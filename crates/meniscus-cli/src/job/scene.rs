//! Options that override what a scene says.

use crate::args::camera::CameraArgs;
use crate::args::surface::SurfaceArgs;
use crate::args::values::Setting;
use crate::exit::{Failure, Outcome};
use crate::report::{Excerpt, Message};
use meniscus::kernel::Kernel;
use meniscus::math::DVec3;
use meniscus::scene::file::{SceneError, SceneErrorKind};
use meniscus::scene::{Anisotropy, ClipError, Light, LightKind, Scene, Surface, Weights};

/// Sets single keys of a scene.
pub(crate) fn apply_settings(settings: &[Setting], scene: &mut Scene) -> Outcome {
    settings.iter().try_for_each(|setting| {
        scene
            .set(&setting.path, &setting.value)
            .map_err(scene_failure)
    })
}

/// Applies the surface options to every surface.
pub(crate) fn apply_surface(args: &SurfaceArgs, scene: &mut Scene) -> Outcome {
    let kernel = args.kernel.as_deref().map(kernel).transpose()?;
    let anisotropy = args.anisotropy.as_deref().map(anisotropy).transpose()?;
    for surface in &mut scene.surfaces {
        apply_shape(args, anisotropy, surface);
        apply_to_surface(args, kernel, surface);
    }
    Ok(())
}

/// Options that say where shapes come from take the place of all that the scene says about it.
fn apply_shape(args: &SurfaceArgs, anisotropy: Option<Anisotropy>, surface: &mut Surface) {
    surface.probability = args.probability.or(surface.probability);
    let columns = [
        &args.metric,
        &args.radii,
        &args.axes,
        &args.orientation,
        &args.deformation,
    ];
    if anisotropy.is_none() && columns.iter().all(|column| column.is_none()) {
        return;
    }
    surface.anisotropy = anisotropy;
    let [metric, radii, axes, orientation, deformation] = columns.map(Clone::clone);
    surface.metric = metric;
    surface.radii = radii;
    surface.axes = axes;
    surface.orientation = orientation;
    surface.deformation = deformation;
}

fn apply_to_surface(args: &SurfaceArgs, kernel: Option<Kernel>, surface: &mut Surface) {
    if args.radius.is_some() {
        surface.radius = args.radius;
        surface.support = None;
    }
    if args.support.is_some() {
        surface.support = args.support;
        surface.radius = None;
    }
    surface.smoothing = args.smoothing.or(surface.smoothing);
    surface.threshold = args.threshold.or(surface.threshold);
    surface.kernel = kernel.or(surface.kernel);
    if let Some(weights) = &args.weights {
        surface.weights = Some(Weights::from(weights.clone()));
    }
    if let Some(filter) = &args.filter {
        surface.filter = Some(filter.clone());
    }
    for name in &args.attributes {
        if !surface.attributes.contains(name) {
            surface.attributes.push(name.clone());
        }
    }
}

fn anisotropy(name: &str) -> Outcome<Anisotropy> {
    let found = Anisotropy::ALL.iter().find(|(known, _)| *known == name);
    found.map(|(_, anisotropy)| *anisotropy).ok_or_else(|| {
        Failure::wrong(format!("there is no --anisotropy `{name}`")).with_help(format!(
            "there are: {}",
            Anisotropy::ALL.map(|(known, _)| known).join(", ")
        ))
    })
}

fn kernel(name: &str) -> Outcome<Kernel> {
    Kernel::from_name(name).ok_or_else(|| {
        Failure::wrong(format!("there is no kernel `{name}`")).with_help(format!(
            "there are: {}",
            Kernel::ALL.map(Kernel::name).join(", ")
        ))
    })
}

/// Applies the camera and light options.
pub(crate) fn apply_camera(args: &CameraArgs, scene: &mut Scene) -> Outcome {
    for text in &args.clip {
        let clip = text
            .parse()
            .map_err(|error: ClipError| Failure::wrong(format!("--clip: {error}")))?;
        scene.clips.push(clip);
    }
    let camera = &mut scene.camera;
    if let Some(eye) = args.camera_eye {
        camera.eye = Some(DVec3::from(eye.0));
    }
    if let Some(target) = args.camera_target {
        camera.target = Some(DVec3::from(target.0));
    }
    if let Some(up) = &args.up {
        camera.up = up
            .parse()
            .map_err(|error: meniscus::scene::camera::UpError| {
                Failure::wrong(format!("--up: {error}"))
            })?;
    }
    camera.fov = args.fov.unwrap_or(camera.fov);
    if let Some(light) = args.light {
        let towards = DVec3::from(light.0);
        if towards.try_normalize().is_none() {
            return Err(Failure::wrong("--light: the direction must not be 0,0,0"));
        }
        if scene.lights.is_empty() {
            scene.lights = Light::defaults(scene.camera.up.vector());
        }
        match scene
            .lights
            .iter_mut()
            .find(|light| light.kind == LightKind::Sun)
        {
            Some(sun) => sun.direction = Some(towards),
            None => scene.lights.push(Light::sun(towards)),
        }
    }
    Ok(())
}

/// A scene's error with its caret; files that cannot be read are work that failed.
pub(crate) fn scene_failure(error: SceneError) -> Failure {
    let message = Box::new(Message {
        text: error.message,
        help: error.help,
        excerpt: error
            .excerpt
            .map(|excerpt| Excerpt::new(&excerpt.name, &excerpt.text, excerpt.span.clone())),
    });
    match error.kind {
        SceneErrorKind::Io => Failure::Work(message),
        _ => Failure::Wrong(message),
    }
}
