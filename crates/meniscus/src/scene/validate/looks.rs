//! Lights and materials: which keys a type takes, and what their values may be.

use super::{
    Checked, check_direction, check_point, check_positive, check_radiance, invalid, require,
};
use crate::scene::materials::{MAX_IOR, MIN_IOR};
use crate::scene::{Light, LightKind, Material, MaterialKind};

/// Refuses keys that the type does not take: (name, given, taken).
fn check_keys(what: &str, key: &str, kind: &str, keys: &[(&str, bool, bool)]) -> Checked {
    for &(name, given, taken) in keys {
        require(
            !given || taken,
            format!("{key}.{name}"),
            format!("a {what} of type `{kind}` takes no `{name}`"),
        )?;
    }
    Ok(())
}

pub(super) fn check_light(key: &str, light: &Light) -> Checked {
    use LightKind::{Constant, Environment, Point, Rectangle, Sky, Sphere, Sun};
    let kind = light.kind;
    let is = |kinds: &[LightKind]| kinds.contains(&kind);
    check_keys(
        "light",
        key,
        kind.name(),
        &[
            ("direction", light.direction.is_some(), is(&[Sun])),
            ("angle", light.angle.is_some(), is(&[Sun])),
            (
                "position",
                light.position.is_some(),
                is(&[Point, Sphere, Rectangle]),
            ),
            ("radius", light.radius.is_some(), is(&[Sphere])),
            ("edges", light.edges.is_some(), is(&[Rectangle])),
            ("file", light.file.is_some(), is(&[Environment])),
            ("rotation", light.rotation.is_some(), is(&[Environment])),
        ],
    )?;
    let missing = |name: &str, message: &str, help: &str| {
        Err(invalid(format!("{key}.{name}"), message).with_help(help))
    };
    match kind {
        Sun => {
            let Some(direction) = light.direction else {
                return missing(
                    "direction",
                    "the sun has no `direction`",
                    "three numbers that point from the scene towards the sun",
                );
            };
            check_direction(&format!("{key}.direction"), direction)?;
            let angle = light.angle.unwrap_or(Light::DEFAULT_ANGLE);
            require(
                (0.0..180.0).contains(&angle),
                format!("{key}.angle"),
                format!("`angle` is in degrees, 0 to below 180, not {angle}"),
            )?;
        }
        Point | Sphere | Rectangle => {
            let Some(position) = light.position else {
                return missing(
                    "position",
                    "the light has no `position`",
                    "three numbers: where its centre is",
                );
            };
            check_point(&format!("{key}.position"), position)?;
        }
        Environment => {
            if light.file.as_ref().is_none_or(|f| f.as_os_str().is_empty()) {
                return missing(
                    "file",
                    "the environment has no `file`",
                    "an image of latitude and longitude, .hdr or .exr",
                );
            }
            require(
                light.rotation.unwrap_or(0.0).is_finite(),
                format!("{key}.rotation"),
                "`rotation` must be a finite number of degrees",
            )?;
        }
        Sky | Constant => {}
    }
    if kind == Sphere {
        if light.radius.is_none() {
            return missing("radius", "the sphere has no `radius`", "a positive number");
        }
        check_positive(&format!("{key}.radius"), light.radius)?;
    }
    if kind == Rectangle {
        let Some([first, second]) = light.edges else {
            return missing(
                "edges",
                "the rectangle has no `edges`",
                "two vectors, as in [[1, 0, 0], [0, 0, 1]]; it shines towards first × second",
            );
        };
        let area = first.cross(second).length();
        let spanned = first.length() * second.length();
        require(
            area.is_finite() && area > 1e-9 * spanned,
            format!("{key}.edges"),
            "the `edges` span no area: two finite vectors that are not parallel and not 0",
        )?;
    }
    require(
        light.intensity >= 0.0 && light.intensity.is_finite(),
        format!("{key}.intensity"),
        format!("`intensity` must be 0 or more, not {}", light.intensity),
    )?;
    light.color.map_or(Ok(()), |color| {
        check_radiance(&format!("{key}.color"), color)
    })
}

pub(super) fn check_material(key: &str, material: &Material) -> Checked {
    let kind = material.kind;
    let thin = material.is_thin();
    let clear = kind.is_clear();
    let body = clear && !thin;
    check_keys(
        "material",
        key,
        &match thin {
            true => format!("{} (thin)", kind.name()),
            false => kind.name().to_owned(),
        },
        &[
            ("thin", material.thin.is_some(), clear),
            (
                "specular",
                material.specular.is_some(),
                kind == MaterialKind::Glossy,
            ),
            (
                "roughness",
                material.roughness.is_some(),
                kind.takes_roughness() && !thin,
            ),
            ("ior", material.ior.is_some(), kind.takes_ior()),
            ("absorption", material.absorption.is_some(), clear),
            (
                "absorption_depth",
                material.absorption_depth.is_some(),
                body,
            ),
            ("priority", material.priority.is_some(), body),
            (
                "translucency",
                material.translucency.is_some(),
                kind == MaterialKind::Foam,
            ),
        ],
    )?;
    let in_range = |value: f64| (0.0..=1.0).contains(&value);
    require(
        material
            .color
            .is_none_or(|color| color.0.into_iter().all(in_range)),
        format!("{key}.color"),
        "`color` must have components from 0 to 1",
    )?;
    for (name, value) in [
        ("specular", material.specular),
        ("roughness", material.roughness),
        ("translucency", material.translucency),
    ] {
        let Some(value) = value else { continue };
        require(
            in_range(value),
            format!("{key}.{name}"),
            format!("`{name}` must be from 0 to 1, not {value}"),
        )?;
    }
    if let Some(ior) = material.ior {
        require(
            (MIN_IOR..=MAX_IOR).contains(&ior),
            format!("{key}.ior"),
            format!(
                "`ior` is the index of refraction, {MIN_IOR} (vacuum) to {MAX_IOR}; water has 1.333, \
                 not {ior}"
            ),
        )?;
    }
    require(
        material
            .absorption
            .is_none_or(|color| color.0.into_iter().all(|c| c > 0.0 && c <= 1.0)),
        format!("{key}.absorption"),
        "`absorption` is what is left of white light: components above 0 and up to 1",
    )?;
    check_positive(
        &format!("{key}.absorption_depth"),
        material.absorption_depth,
    )
}
