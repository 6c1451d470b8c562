//! Metrics of ellipsoids from tensor columns.

use crate::field::FieldError;
use crate::particles::Several;
use crate::primitive::Ellipsoid;
use glam::DMat3;

/// How the components of a metric are ordered in its column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MetricOrder {
    /// xx xy xz yy yz zz.
    UpperTriangle,
    /// xx yy zz xy yz xz, as VTK orders symmetric tensors.
    Vtk,
    /// Nine components, row by row; the symmetric part counts.
    Full,
}

impl MetricOrder {
    /// Places of xx xy xz yy yz zz among six components.
    fn places(self) -> [usize; 6] {
        match self {
            Self::UpperTriangle | Self::Full => [0, 1, 2, 3, 4, 5],
            Self::Vtk => [0, 3, 5, 1, 4, 2],
        }
    }

    /// The order as words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::UpperTriangle => "xx xy xz yy yz zz",
            Self::Vtk => "xx yy zz xy yz xz (VTK's order)",
            Self::Full => "nine components",
        }
    }
}

/// Upper-triangular factors A, where there is one.
type Factors = Vec<Option<[f64; 6]>>;

/// The factors A of the metrics M = AᵀA in `column` for `rows`, `None` where M is not positive
/// definite or not finite. Six components are read as xx xy xz yy yz zz unless more rows are positive
/// definite in VTK's order: read in the wrong one, a diagonal stands where the rest should, so the two
/// are hard to confuse.
pub(in crate::field) fn factors(
    column: &Several<'_>,
    rows: &[u32],
) -> Result<(Factors, MetricOrder), FieldError> {
    let read = |order: MetricOrder| -> Factors {
        rows.iter()
            .map(|&row| {
                let m: [f64; 9] = column.get(row as usize);
                let upper = match order {
                    MetricOrder::Full => [
                        m[0],
                        0.5 * (m[1] + m[3]),
                        0.5 * (m[2] + m[6]),
                        m[4],
                        0.5 * (m[5] + m[7]),
                        m[8],
                    ],
                    _ => order.places().map(|place| m[place]),
                };
                factor(upper)
            })
            .collect()
    };
    match column.components() {
        9 => Ok((read(MetricOrder::Full), MetricOrder::Full)),
        6 => {
            let plain = read(MetricOrder::UpperTriangle);
            if plain.iter().all(Option::is_some) {
                return Ok((plain, MetricOrder::UpperTriangle));
            }
            let vtk = read(MetricOrder::Vtk);
            let count = |factors: &Factors| factors.iter().flatten().count();
            if count(&vtk) > count(&plain) {
                Ok((vtk, MetricOrder::Vtk))
            } else {
                Ok((plain, MetricOrder::UpperTriangle))
            }
        }
        found => Err(FieldError::Components {
            what: "metric",
            name: column.name().to_owned(),
            found,
            expected: "six or nine",
        }),
    }
}

/// The factor of the metric xx xy xz yy yz zz, where it also fits into f32.
fn factor([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Option<[f64; 6]> {
    let metric = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
    Ellipsoid::from_metric(metric).ok()?;
    Ellipsoid::factor_of(metric).ok()
}
