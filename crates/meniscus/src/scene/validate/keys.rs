//! Keyframes of the camera and of instances.

use super::company::check_matrix;
use super::{Checked, check_direction, check_point, invalid, require};
use crate::scene::camera::{Camera, CameraError, CameraSettings};
use crate::scene::{Instance, Matrix};

/// Times that are finite and rise.
fn check_times(key: &str, times: impl Iterator<Item = f64>) -> Checked {
    let mut last = f64::NEG_INFINITY;
    for (i, time) in times.enumerate() {
        let place = format!("{key}.key.{i}.time");
        require(
            time.is_finite(),
            place.clone(),
            "`time` must be a number of seconds",
        )?;
        require(
            time > last,
            place,
            format!("keys must come in the order of their times: {time} follows {last}"),
        )?;
        last = time;
    }
    Ok(())
}

pub(super) fn check_camera(camera: &CameraSettings) -> Checked {
    if camera.keys.is_empty() {
        return Ok(());
    }
    for (name, point) in [("eye", camera.eye), ("target", camera.target)] {
        if point.is_some() {
            let message = format!("`{name}` has no effect beside the keys of the camera");
            return Err(invalid(format!("camera.{name}"), message)
                .with_help("leave out one of them: a [[camera.key]] has its own"));
        }
    }
    check_times("camera", camera.keys.iter().map(|key| key.time))?;
    for (i, key) in camera.keys.iter().enumerate() {
        let place = |name: &str| format!("camera.key.{i}.{name}");
        check_point(&place("eye"), key.eye)?;
        check_point(&place("target"), key.target)?;
        let up = key.up.unwrap_or(camera.up);
        check_direction(&place("up"), up.0)?;
        let fov = key.fov.unwrap_or(camera.fov);
        require(
            fov > 0.0 && fov < 180.0,
            place("fov"),
            format!("`fov` is the vertical angle in degrees, between 0 and 180, not {fov}"),
        )?;
        match Camera::new(key.eye, key.target, up.0, fov.to_radians(), [1, 1]) {
            Ok(_) => {}
            Err(CameraError::Up) => {
                let message = "`up` points along the view, from eye to target";
                let at = if key.up.is_some() { "up" } else { "target" };
                return Err(invalid(place(at), message)
                    .with_help("choose another up, for example one of x, y, z"));
            }
            Err(_) => {
                let message = "`eye` and `target` are the same point";
                return Err(invalid(place("eye"), message));
            }
        }
    }
    match camera.check_path() {
        None => Ok(()),
        Some((time, error)) => {
            let last = camera.keys.iter().rposition(|key| key.time <= time);
            let at = format!("camera.key.{}", last.unwrap_or(0));
            let message = format!("on the way to the next key, at {time:.3} s: {error}");
            Err(invalid(at, message).with_help("put another key in between"))
        }
    }
}

pub(super) fn check_placements(key: &str, instance: &Instance) -> Checked {
    let keys = &instance.keys;
    if !keys.is_empty() && instance.matrix != Matrix::default() {
        let message = "`matrix` has no effect beside the keys of the instance";
        return Err(invalid(format!("{key}.matrix"), message)
            .with_help("leave out one of them: an [[instance.key]] has its own"));
    }
    check_times(key, keys.iter().map(|key| key.time))?;
    for (i, placed) in keys.iter().enumerate() {
        check_matrix(&format!("{key}.key.{i}.matrix"), &placed.matrix)?;
    }
    let is_mirror = |matrix: &Matrix| matrix.0.matrix3.determinant() < 0.0;
    let turned = keys
        .windows(2)
        .position(|pair| is_mirror(&pair[0].matrix) != is_mirror(&pair[1].matrix));
    match turned {
        None => Ok(()),
        Some(i) => Err(invalid(
            format!("{key}.key.{}.matrix", i + 1),
            "one of two keys in a row is a mirror and the other is not: nothing solid gets there",
        )),
    }
}
