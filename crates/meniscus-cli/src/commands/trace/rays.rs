//! Rays from an NPY file.

use crate::exit::{Failure, Outcome};
use meniscus::math::DVec3;
use meniscus::math::ray::Ray;
use npyz::{NpyFile, Order};
use std::path::Path;

/// Reads rays: (n, 8) or (n, 9) of f32 or f64 in either byte order and either array order.
pub(crate) fn read(path: &Path) -> Outcome<Vec<Ray>> {
    let failed = |reason: String| Failure::work(format!("{}: {reason}", path.display()));
    let bytes = std::fs::read(path)
        .map_err(|error| Failure::work(format!("cannot read {}: {error}", path.display())))?;
    let file =
        NpyFile::new(&bytes[..]).map_err(|error| failed(format!("not an NPY array: {error}")))?;
    let shape = file.shape().to_vec();
    let wanted = "expected an array (n, 8) or (n, 9): origin, direction, t_min, t_max[, time]";
    let (rows, width) = match shape[..] {
        [rows, width @ (8 | 9)] => (rows, width as usize),
        _ => {
            return Err(Failure::wrong(format!(
                "{}: {wanted}, found shape {shape:?}",
                path.display()
            )));
        }
    };
    let is_columnwise = file.order() == Order::Fortran;
    // The smallest number has 4 bytes: a header cannot promise more rows than the file can hold.
    if rows.saturating_mul(width as u64 * 4) > bytes.len() as u64 {
        return Err(failed(format!(
            "the header promises {rows} rays, the file is too short"
        )));
    }
    let kind = file.dtype().descr();
    let numbers: Vec<f64> = match file.try_data::<f64>() {
        Ok(numbers) => numbers.collect::<std::io::Result<_>>(),
        Err(file) => match file.try_data::<f32>() {
            Ok(numbers) => numbers.map(|number| number.map(f64::from)).collect(),
            Err(_) => {
                return Err(Failure::wrong(format!(
                    "{}: {wanted} of f32 or f64, found numbers of type {kind}",
                    path.display()
                )));
            }
        },
    }
    .map_err(|error| failed(format!("the array is damaged: {error}")))?;
    let rows = rows as usize;
    if numbers.len() != rows * width {
        return Err(failed(format!(
            "{} numbers instead of {}",
            numbers.len(),
            rows * width
        )));
    }
    let at = |row: usize, column: usize| {
        numbers[if is_columnwise {
            column * rows + row
        } else {
            row * width + column
        }]
    };
    let ray = |row: usize| {
        let vector =
            |first: usize| DVec3::new(at(row, first), at(row, first + 1), at(row, first + 2));
        Ray {
            time: if width == 9 { at(row, 8) } else { 0.0 },
            ..Ray::new(vector(0), vector(3)).with_range(at(row, 6), at(row, 7))
        }
    };
    Ok((0..rows).map(ray).collect())
}
