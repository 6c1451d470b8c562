//! Meshes, spheres, planes, cuts and where they stand; depth cues; the shutter.

use super::{Checked, check_direction, check_point, require};
use crate::scene::motion::MAX_SHUTTER;
use crate::scene::{CueSettings, Matrix, MotionSettings, Scene};

impl Scene {
    /// Whether anything but particles can be seen.
    pub(super) fn has_company(&self) -> bool {
        !self.meshes.is_empty() || !self.spheres.is_empty() || !self.planes.is_empty()
    }

    pub(super) fn check_company(&self) -> Checked {
        for (i, mesh) in self.meshes.iter().enumerate() {
            require(
                !mesh.file.as_os_str().is_empty(),
                format!("mesh.{i}.file"),
                "the mesh has no triangles: the key `file` is missing",
            )?;
            check_matrix(&format!("mesh.{i}.matrix"), &mesh.matrix)?;
            self.check_material(&format!("mesh.{i}.material"), mesh.material.as_deref())?;
        }
        for (i, sphere) in self.spheres.iter().enumerate() {
            check_point(&format!("sphere.{i}.center"), sphere.center)?;
            require(
                sphere.radius > 0.0 && sphere.radius.is_finite(),
                format!("sphere.{i}.radius"),
                format!("`radius` must be a positive number, not {}", sphere.radius),
            )?;
            self.check_material(&format!("sphere.{i}.material"), sphere.material.as_deref())?;
        }
        for (i, plane) in self.planes.iter().enumerate() {
            check_point(&format!("plane.{i}.point"), plane.point)?;
            if let Some(normal) = plane.normal {
                check_direction(&format!("plane.{i}.normal"), normal)?;
            }
            self.check_material(&format!("plane.{i}.material"), plane.material.as_deref())?;
        }
        for (i, clip) in self.clips.iter().enumerate() {
            check_point(&format!("clip.{i}.point"), clip.point)?;
            check_direction(&format!("clip.{i}.normal"), clip.normal)?;
        }
        Ok(())
    }
}

pub(super) fn check_matrix(key: &str, matrix: &Matrix) -> Checked {
    let map = matrix.0;
    require(
        map.is_finite() && map.inverse().is_finite(),
        key,
        "the matrix must have finite numbers and an inverse",
    )?;
    // |det| is the volume of the unit cube's image: compare it with what its edges could span.
    let m = map.matrix3;
    let edges = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    require(
        m.determinant().abs() > 1e-9 * edges,
        key,
        "the matrix is singular: it flattens the surface",
    )
}

pub(super) fn check_motion(motion: &MotionSettings) -> Checked {
    require(
        (0.0..=MAX_SHUTTER).contains(&motion.shutter),
        "motion.shutter",
        format!(
            "`shutter` is a part of the time between two pictures, from 0 to {MAX_SHUTTER}, not {}",
            motion.shutter
        ),
    )?;
    require(
        motion.fps > 0.0 && motion.fps <= 1e6,
        "motion.fps",
        format!("`fps` must be above 0 and up to 1e6, not {}", motion.fps),
    )?;
    require(
        motion.time.is_finite(),
        "motion.time",
        "`time` must be a number of seconds",
    )?;
    require(
        motion.velocity_scale != 0.0 && motion.velocity_scale.is_finite(),
        "motion.velocity_scale",
        format!(
            "`velocity_scale` must be a number other than 0, not {}",
            motion.velocity_scale
        ),
    )
}

pub(super) fn check_cues(cues: &CueSettings) -> Checked {
    require(
        (0.0..=1.0).contains(&cues.silhouettes),
        "cues.silhouettes",
        format!(
            "`silhouettes` must be from 0 to 1, not {}",
            cues.silhouettes
        ),
    )?;
    require(
        (0.0..=10.0).contains(&cues.depth_shading),
        "cues.depth_shading",
        format!(
            "`depth_shading` must be from 0 to 10, not {}",
            cues.depth_shading
        ),
    )?;
    require(
        cues.depth_reach > 0.0 && cues.depth_reach <= 1.0,
        "cues.depth_reach",
        format!(
            "`depth_reach` is a part of the picture's diagonal, above 0 and up to 1, not {}",
            cues.depth_reach
        ),
    )
}
