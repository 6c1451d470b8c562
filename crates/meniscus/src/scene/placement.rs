//! What stands where: instances of surfaces, planes, meshes, the ground.

use glam::{DAffine3, DMat3, DVec3};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::path::PathBuf;

/// `[[instance]]`: a surface placed in the world once more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Instance {
    /// Name of the surface.
    pub surface: String,
    /// World from object, where no `keys` say it.
    #[serde(default)]
    pub matrix: Matrix,
    /// Name of a material that replaces the surface's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// `[[instance.key]]`: where it is at several times; it moves in between and rests before and after.
    #[serde(default, rename = "key", skip_serializing_if = "Vec::is_empty")]
    pub keys: Vec<PlacementKey>,
}

/// `[[instance.key]]`: where an instance is at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacementKey {
    /// When, in seconds of the scene (see [`super::MotionSettings::time`]); keys come in order.
    pub time: f64,
    /// World from object.
    pub matrix: Matrix,
}

/// `[[plane]]`: an infinite plane; its inside is the half space below it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plane {
    /// A point on the plane, world space.
    pub point: DVec3,
    /// Normal that points outside, any length but 0; unset, the camera's up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<DVec3>,
    /// Name of its material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

impl Default for Plane {
    fn default() -> Self {
        Self {
            point: DVec3::ZERO,
            normal: None,
            material: None,
        }
    }
}

/// `[ground]`: a plane that touches the objects from below, as `--ground` adds it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ground {
    /// Height along the camera's up; unset, the lowest point of the framed bounds (those without
    /// far-off particles, see `Frame::framing_bounds`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Name of its material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

/// `[[mesh]]`: a triangle mesh; a solid if it is closed, else a sheet.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Mesh {
    /// Mesh file (PLY, OBJ or glTF); relative to the scene file.
    pub file: PathBuf,
    /// World from the file's coordinates.
    #[serde(skip_serializing_if = "Matrix::is_identity")]
    pub matrix: Matrix,
    /// Name of its material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

/// `[[sphere]]`: a ball.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sphere {
    /// Centre, world space.
    pub center: DVec3,
    /// Radius, positive.
    pub radius: f64,
    /// Name of its material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

impl Default for Sphere {
    fn default() -> Self {
        Self {
            center: DVec3::ZERO,
            radius: 1.0,
            material: None,
        }
    }
}

/// `[[clip]]`: cuts particle surfaces, closed meshes and spheres open along a plane: what lies on the
/// side that the normal points to goes, what stays is closed by a cap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clip {
    /// A point on the plane, world space.
    #[serde(default)]
    pub point: DVec3,
    /// Points to what is cut away, any length but 0.
    pub normal: DVec3,
}

/// A cut that is none of `x<1`, `z>-0.5`, `nx,ny,nz,d`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no cut; write what stays, as in x<0.5 or z>-1, or nx,ny,nz,d for nx·x + ny·y + nz·z < d"
)]
pub struct ClipError(pub String);

impl std::str::FromStr for Clip {
    type Err = ClipError;

    /// Reads what stays: `x<0.5`, `z>-1`, or four numbers `nx,ny,nz,d` for n·p < d.
    fn from_str(text: &str) -> Result<Self, ClipError> {
        let wrong = || ClipError(text.to_owned());
        let number = |word: &str| {
            let value: f64 = word.trim().parse().map_err(|_| wrong())?;
            value.is_finite().then_some(value).ok_or_else(wrong)
        };
        let compact: String = text.split_whitespace().collect();
        if let Some(at) = compact.find(['<', '>']) {
            let axis = match &compact[..at] {
                "x" => DVec3::X,
                "y" => DVec3::Y,
                "z" => DVec3::Z,
                _ => return Err(wrong()),
            };
            let limit = number(compact[at + 1..].trim_start_matches('='))?;
            let below = compact[at..].starts_with('<');
            return Ok(Self {
                point: axis * limit,
                normal: if below { axis } else { -axis },
            });
        }
        let numbers: Vec<f64> = compact.split(',').map(number).collect::<Result<_, _>>()?;
        let [x, y, z, d] = numbers[..] else {
            return Err(wrong());
        };
        let normal = DVec3::new(x, y, z);
        let point = normal * (d / normal.length_squared());
        point
            .is_finite()
            .then_some(Self { point, normal })
            .ok_or_else(wrong)
    }
}

/// An affine map. In files row by row, for column vectors (the translation stands in the last
/// column): four rows of four numbers with last row 0 0 0 1, the three first rows alone, or the same
/// 16 or 12 numbers in one list.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Matrix(pub DAffine3);

impl Matrix {
    pub(super) fn is_identity(&self) -> bool {
        self.0 == DAffine3::IDENTITY
    }

    fn from_rows(numbers: &[f64]) -> Result<Self, String> {
        if !matches!(numbers.len(), 12 | 16) {
            return Err(format!(
                "a matrix has 16 numbers (4 rows of 4) or 12 (3 rows of 4), not {}",
                numbers.len()
            ));
        }
        if numbers.len() == 16 && numbers[12..] != [0.0, 0.0, 0.0, 1.0] {
            return Err(
                "the last row of a matrix must be 0 0 0 1; rows are written one after the other, \
                 the translation stands at the end of the first three"
                    .to_owned(),
            );
        }
        let row = |i: usize| DVec3::from_slice(&numbers[4 * i..4 * i + 3]);
        Ok(Self(DAffine3 {
            matrix3: DMat3::from_cols(row(0), row(1), row(2)).transpose(),
            translation: DVec3::new(numbers[3], numbers[7], numbers[11]),
        }))
    }

    fn rows(&self) -> [[f64; 4]; 4] {
        let m = self.0.matrix3.transpose();
        let row = |axis: DVec3, shift: f64| [axis.x, axis.y, axis.z, shift];
        [
            row(m.x_axis, self.0.translation.x),
            row(m.y_axis, self.0.translation.y),
            row(m.z_axis, self.0.translation.z),
            [0.0, 0.0, 0.0, 1.0],
        ]
    }
}

impl Serialize for Matrix {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.rows().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Matrix {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(MatrixVisitor)
    }
}

struct MatrixVisitor;

impl<'de> Visitor<'de> for MatrixVisitor {
    type Value = Matrix;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a matrix (4 rows of 4 numbers)")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Matrix, A::Error> {
        let mut numbers = Vec::new();
        while let Some(item) = items.next_element::<RowOrNumber>()? {
            match item {
                RowOrNumber::Row(row) => numbers.extend(row),
                RowOrNumber::Number(number) => numbers.push(number),
            }
            if numbers.len() > 16 {
                return Err(A::Error::custom("a matrix has at most 16 numbers"));
            }
        }
        Matrix::from_rows(&numbers).map_err(A::Error::custom)
    }
}

enum RowOrNumber {
    Row([f64; 4]),
    Number(f64),
}

impl<'de> Deserialize<'de> for RowOrNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RowOrNumberVisitor)
    }
}

struct RowOrNumberVisitor;

impl<'de> Visitor<'de> for RowOrNumberVisitor {
    type Value = RowOrNumber;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a row of 4 numbers or a number")
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<RowOrNumber, E> {
        Ok(RowOrNumber::Number(number))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<RowOrNumber, E> {
        Ok(RowOrNumber::Number(number as f64))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<RowOrNumber, E> {
        Ok(RowOrNumber::Number(number as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, items: A) -> Result<RowOrNumber, A::Error> {
        Deserialize::deserialize(serde::de::value::SeqAccessDeserializer::new(items))
            .map(RowOrNumber::Row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_say_what_stays() {
        let clip = |text: &str| text.parse::<Clip>().map(|clip| (clip.point, clip.normal));
        assert_eq!(clip("x<0.5"), Ok((DVec3::X * 0.5, DVec3::X)));
        assert_eq!(clip(" z > -1 "), Ok((-DVec3::Z, -DVec3::Z)));
        assert_eq!(clip("y<=2"), Ok((DVec3::Y * 2.0, DVec3::Y)));
        let (point, normal) = clip("0,3,4,10").unwrap();
        assert_eq!(normal, DVec3::new(0.0, 3.0, 4.0));
        assert!((point.dot(normal) - 10.0).abs() < 1e-12);
        for wrong in [
            "",
            "x",
            "w<1",
            "x<",
            "x<a",
            "x<nan",
            "1,2,3",
            "0,0,0,1",
            "1,2,3,4,5",
        ] {
            assert!(clip(wrong).is_err(), "{wrong}");
        }
    }
}
