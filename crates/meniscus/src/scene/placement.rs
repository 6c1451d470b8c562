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
    /// World from object.
    #[serde(default)]
    pub matrix: Matrix,
    /// Name of a material that replaces the surface's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
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

/// `[[mesh]]`: a polygon mesh.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Mesh {
    /// Mesh file.
    pub file: PathBuf,
    /// Name of its material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

/// An affine map. In files row by row, for column vectors (the translation stands in the last
/// column): four rows of four numbers with last row 0 0 0 1, the three first rows alone, or the same
/// 16 or 12 numbers in one list.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Matrix(pub DAffine3);

impl Matrix {
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
