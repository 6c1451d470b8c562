//! The camera: from eye, target, up and field of view to primary rays.

use crate::math::aabb::DAabb;
use crate::math::ray::{Ray, RayDifferential};
use glam::DVec3;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// `[camera]`. What is unset frames the objects; see [`Camera::framing`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraSettings {
    /// Where the camera stands, world space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eye: Option<DVec3>,
    /// What it looks at, world space; the centre of the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<DVec3>,
    /// Which way is up.
    pub up: Up,
    /// Vertical field of view in degrees, between 0 and 180.
    pub fov: f64,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            eye: None,
            target: None,
            up: Up::default(),
            fov: 40.0,
        }
    }
}

impl CameraSettings {
    /// Whether nothing is set.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The direction that is up: `x`, `y`, `z`, `-x`, `-y`, `-z` or three numbers. A unit vector after
/// [`Up::vector`], kept as given here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Up(pub DVec3);

impl Default for Up {
    fn default() -> Self {
        Self(DVec3::Y)
    }
}

/// An up direction that is none of the six axes nor three numbers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a direction; use x, y, z, -x, -y, -z or three numbers")]
pub struct UpError(pub String);

const AXES: [(&str, DVec3); 6] = [
    ("x", DVec3::X),
    ("y", DVec3::Y),
    ("z", DVec3::Z),
    ("-x", DVec3::NEG_X),
    ("-y", DVec3::NEG_Y),
    ("-z", DVec3::NEG_Z),
];

impl Up {
    /// The unit vector (+Y where the stored one has no direction).
    pub fn vector(self) -> DVec3 {
        self.0.normalize_or(DVec3::Y)
    }
}

impl FromStr for Up {
    type Err = UpError;

    fn from_str(text: &str) -> Result<Self, UpError> {
        if let Some((_, axis)) = AXES.iter().find(|(name, _)| *name == text) {
            return Ok(Self(*axis));
        }
        let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y, z]) => Ok(Self(DVec3::new(x, y, z))),
            _ => Err(UpError(text.to_owned())),
        }
    }
}

impl Serialize for Up {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match AXES.iter().find(|(_, axis)| *axis == self.0) {
            Some((name, _)) => serializer.serialize_str(name),
            None => self.0.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Up {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(UpVisitor)
    }
}

struct UpVisitor;

impl<'de> Visitor<'de> for UpVisitor {
    type Value = Up;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a direction (\"x\", \"y\", \"z\", \"-x\", \"-y\", \"-z\" or three numbers)")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Up, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, items: A) -> Result<Up, A::Error> {
        <[f64; 3]>::deserialize(serde::de::value::SeqAccessDeserializer::new(items))
            .map(|up| Up(up.into()))
    }
}

/// Two horizontal unit vectors: with Y up they are +X and +Z, and with Z up +X and −Y, so that the
/// default views look at the same sides of an object whichever axis its file calls up.
pub(super) fn horizontal_axes(up: DVec3) -> [DVec3; 2] {
    let side = if up.x.abs() > 0.9 {
        DVec3::NEG_Z * up.x.signum()
    } else {
        DVec3::X
    };
    let side = (side - up * up.dot(side)).normalize();
    [side, side.cross(up)]
}

/// A camera that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CameraError {
    /// Eye and target coincide, are too far apart, or are not finite.
    #[error("the camera's eye and target must be two different finite points")]
    Direction,
    /// Up is zero, not finite, or points along the view.
    #[error("the camera's up must not point along its view direction")]
    Up,
    /// The field of view is not between 0° and 180°.
    #[error("the field of view must lie between 0 and 180 degrees")]
    Fov,
}

/// A pinhole camera for a film of a given size: forward = target − eye, right = forward × up,
/// vertical field of view, square pixels; pixel (0, 0) is top left. All in float64.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it stands, world space.
    pub eye: DVec3,
    /// Unit view direction.
    pub forward: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to the top of the picture.
    pub up: DVec3,
    /// Vertical field of view in radians.
    pub fov: f64,
    /// Pixels across and down.
    pub size: [u32; 2],
}

/// How far the default camera stands above the horizon, in radians.
const FRAMING_ELEVATION: f64 = 0.38;
/// How far the default camera is turned from the front, in radians.
const FRAMING_AZIMUTH: f64 = 0.55;
/// Part of the picture that the framed box fills at most.
const FRAMING_FILL: f64 = 0.9;

impl Camera {
    /// A camera at `eye` that looks at `target`; `fov` in radians, `size` in pixels.
    ///
    /// # Errors
    /// When the points, the up direction or the angle define no camera.
    pub fn new(
        eye: DVec3,
        target: DVec3,
        up: DVec3,
        fov: f64,
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        if !(fov > 0.0 && fov < std::f64::consts::PI) {
            return Err(CameraError::Fov);
        }
        let forward = (target - eye)
            .try_normalize()
            .ok_or(CameraError::Direction)?;
        let right = up
            .try_normalize()
            .map(|up| forward.cross(up))
            .filter(|right| right.length_squared() > 1e-12)
            .and_then(DVec3::try_normalize)
            .ok_or(CameraError::Up)?;
        Ok(Self {
            eye,
            forward,
            right,
            up: right.cross(forward),
            fov,
            size,
        })
    }

    /// The camera of a scene whose objects fill `bounds` (world space). An unset eye and target
    /// frame the bounds; an unset target is their centre; an unset eye stands where the whole box
    /// is seen around the given target.
    ///
    /// # Errors
    /// When the settings define no camera.
    pub fn from_settings(
        settings: &CameraSettings,
        bounds: DAabb,
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        let fov = settings.fov.to_radians();
        let up = settings.up.0;
        let bounds = with_some_size(bounds);
        match (settings.eye, settings.target) {
            (Some(eye), target) => Self::new(eye, target.unwrap_or(bounds.center()), up, fov, size),
            (None, target) => {
                Self::framing_around(target.unwrap_or(bounds.center()), bounds, up, fov, size)
            }
        }
    }

    /// A camera that frames `bounds` from a three-quarter view slightly above: the whole box is in
    /// the picture, with a margin. A box without size (or without points) gets one first.
    ///
    /// # Errors
    /// When `up` or `fov` (radians) define no camera.
    pub fn framing(
        bounds: DAabb,
        up: DVec3,
        fov: f64,
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        let bounds = with_some_size(bounds);
        Self::framing_around(bounds.center(), bounds, up, fov, size)
    }

    fn framing_around(
        target: DVec3,
        bounds: DAabb,
        up: DVec3,
        fov: f64,
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        let up = up.try_normalize().ok_or(CameraError::Up)?;
        let [side, front] = horizontal_axes(up);
        let (sin, cos) = FRAMING_AZIMUTH.sin_cos();
        let towards_eye =
            (side * sin + front * cos) * FRAMING_ELEVATION.cos() + up * FRAMING_ELEVATION.sin();
        let at_target = Self::new(target + towards_eye, target, up, fov, size)?;
        let [x_reach, y_reach] = at_target.half_extents().map(|reach| reach * FRAMING_FILL);
        // A corner c (relative to the target) is inside the picture when |c·right| ≤ reach·depth
        // with depth = distance + c·forward.
        let distance = corners(bounds)
            .map(|corner| corner - target)
            .iter()
            .fold(0.0, |d, c| {
                let x = c.dot(at_target.right).abs() / x_reach;
                let y = c.dot(at_target.up).abs() / y_reach;
                f64::max(d, x.max(y) - c.dot(at_target.forward))
            });
        // Never inside the box, even where the target lies far outside it.
        let distance = distance.max(bounds.size().length() * 1e-3);
        Self::new(target + towards_eye * distance, target, up, fov, size)
    }

    /// Half width and half height of the picture at distance 1 along the view axis.
    fn half_extents(&self) -> [f64; 2] {
        let half_height = (0.5 * self.fov).tan();
        let [width, height] = self.size.map(f64::from);
        [half_height * width / height, half_height]
    }

    /// The ray through a point of the film, in pixels from the top left corner (the centre of pixel
    /// (0, 0) is (0.5, 0.5)). Unit direction, differentials per pixel, side unknown, time 0.
    pub fn ray(&self, film: [f64; 2]) -> Ray {
        let [half_width, half_height] = self.half_extents();
        let [width, height] = self.size.map(f64::from);
        let x = (2.0 * film[0] / width - 1.0) * half_width;
        let y = (1.0 - 2.0 * film[1] / height) * half_height;
        let raw = self.forward + self.right * x + self.up * y;
        let length = raw.length();
        let direction = raw / length;
        let pixel = 2.0 * half_height / height;
        // d(v/|v|) = (dv − u (u·dv))/|v| with u = v/|v|.
        let change = |step: DVec3| (step - direction * direction.dot(step)) / length;
        Ray {
            differential: Some(RayDifferential {
                origin: [DVec3::ZERO; 2],
                direction: [change(self.right * pixel), change(self.up * -pixel)],
            }),
            ..Ray::new(self.eye, direction)
        }
    }

    /// Distance of a world point along the view axis.
    pub fn depth(&self, point: DVec3) -> f64 {
        (point - self.eye).dot(self.forward)
    }

    /// Where a world point appears on the film, in pixels from the top left corner; `None` behind
    /// the eye.
    pub fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let depth = self.depth(point);
        if depth <= 0.0 {
            return None;
        }
        let [half_width, half_height] = self.half_extents();
        let [width, height] = self.size.map(f64::from);
        let offset = (point - self.eye) / depth;
        Some([
            (offset.dot(self.right) / half_width + 1.0) * 0.5 * width,
            (1.0 - offset.dot(self.up) / half_height) * 0.5 * height,
        ])
    }
}

fn corners(bounds: DAabb) -> [DVec3; 8] {
    std::array::from_fn(|corner| {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 {
                bounds.min[axis]
            } else {
                bounds.max[axis]
            }
        };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// A box that a camera can frame: one around the origin if there is no finite point, and never
/// smaller than what float64 resolves at its place.
fn with_some_size(bounds: DAabb) -> DAabb {
    if bounds.is_empty() || !(bounds.min.is_finite() && bounds.max.is_finite()) {
        return DAabb {
            min: DVec3::NEG_ONE,
            max: DVec3::ONE,
        };
    }
    let center = bounds.center();
    if bounds.size().max_element() > 1e-9 * center.abs().max_element() {
        return bounds;
    }
    let half = DVec3::splat((center.abs().max_element() * 1e-3).max(f64::from(f32::MIN_POSITIVE)));
    let half = if center == DVec3::ZERO {
        DVec3::ONE
    } else {
        half
    };
    DAabb {
        min: center - half,
        max: center + half,
    }
}
