//! Polynomials through sampled values, in Bernstein form, and all their sign changes by bisection.

use crate::tolerance::ORACLE_ROOT;

/// Coefficients of the highest degree in use, 8.
const MOST: usize = 9;

/// Turns the values of a polynomial at [`Interpolation::nodes`] into its Bernstein coefficients.
#[derive(Debug)]
pub(super) struct Interpolation {
    /// Chebyshev nodes in [0, 1], both ends included.
    pub(super) nodes: Vec<f64>,
    inverse: Vec<Vec<f64>>,
}

impl Interpolation {
    pub(super) fn of_degree(degree: usize) -> Self {
        let node = |i: usize| 0.5 - 0.5 * (std::f64::consts::PI * i as f64 / degree as f64).cos();
        let nodes: Vec<f64> = (0..=degree).map(node).collect();
        // Rows: the Bernstein basis at a node, then the unit matrix, reduced by Gauss and Jordan.
        let mut rows: Vec<Vec<f64>> = nodes
            .iter()
            .enumerate()
            .map(|(row, &u)| {
                let basis = (0..=degree).map(|i| {
                    let chosen: f64 = (0..i)
                        .map(|k| (degree - k) as f64 / (k + 1) as f64)
                        .product();
                    chosen * u.powi(i as i32) * (1.0 - u).powi((degree - i) as i32)
                });
                let unit = (0..=degree).map(|column| f64::from(u8::from(column == row)));
                basis.chain(unit).collect()
            })
            .collect();
        for pivot in 0..=degree {
            let best = (pivot..=degree)
                .max_by(|&a, &b| rows[a][pivot].abs().total_cmp(&rows[b][pivot].abs()));
            rows.swap(pivot, best.unwrap_or(pivot));
            let scale = 1.0 / rows[pivot][pivot];
            rows[pivot].iter_mut().for_each(|x| *x *= scale);
            let pivot_row = rows[pivot].clone();
            for row in (0..=degree).filter(|&row| row != pivot) {
                let factor = rows[row][pivot];
                for (x, p) in rows[row].iter_mut().zip(&pivot_row) {
                    *x -= factor * p;
                }
            }
        }
        Self {
            nodes,
            inverse: rows
                .into_iter()
                .map(|row| row[degree + 1..].to_vec())
                .collect(),
        }
    }

    pub(super) fn through(&self, values: &[f64]) -> Bernstein {
        let mut c = [0.0; MOST];
        for (c, row) in c.iter_mut().zip(&self.inverse) {
            *c = row.iter().zip(values).map(|(a, b)| a * b).sum();
        }
        Bernstein {
            c,
            degree: self.nodes.len() - 1,
        }
    }
}

/// A polynomial over [0, 1].
#[derive(Debug, Clone, Copy)]
pub(super) struct Bernstein {
    c: [f64; MOST],
    degree: usize,
}

impl Bernstein {
    pub(super) fn coefficients(&self) -> &[f64] {
        &self.c[..=self.degree]
    }

    /// Both halves.
    pub(super) fn halves(&self) -> (Self, Self) {
        let (mut left, mut right) = (*self, *self);
        for level in 1..=self.degree {
            for i in (level..=self.degree).rev() {
                left.c[i] = 0.5 * (left.c[i - 1] + left.c[i]);
            }
            for i in 0..=self.degree - level {
                right.c[i] = 0.5 * (right.c[i] + right.c[i + 1]);
            }
        }
        (left, right)
    }

    /// Calls `see(u, positive)` at 0 and wherever the sign changes after, in order.
    pub(super) fn signs(&self, see: &mut impl FnMut(f64, bool)) {
        self.signs_within(0.0, 1.0, see);
    }

    fn signs_within(&self, low: f64, high: f64, see: &mut impl FnMut(f64, bool)) {
        let c = self.coefficients();
        let (first, last) = (c[0] > 0.0, c[self.degree] > 0.0);
        if c.iter().all(|&c| (c > 0.0) == first) {
            see(low, first);
        } else if high - low < ORACLE_ROOT {
            see(low, first);
            see(high, last);
        } else {
            let (left, right) = self.halves();
            let middle = 0.5 * (low + high);
            left.signs_within(low, middle, see);
            right.signs_within(middle, high, see);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Interpolation;

    #[test]
    fn finds_every_sign_change_and_no_touch() {
        let interpolation = Interpolation::of_degree(8);
        let roots = [0.1, 0.11, 0.5, 0.77];
        let polynomial = |u: f64| {
            let product: f64 = roots.iter().map(|r| u - r).product();
            product * (u - 0.3) * (u - 0.3) * (u * u + 0.1)
        };
        let values: Vec<f64> = interpolation.nodes.iter().map(|&u| polynomial(u)).collect();
        let mut seen: Vec<(f64, bool)> = Vec::new();
        interpolation.through(&values).signs(&mut |u, positive| {
            if seen.last().is_none_or(|last| last.1 != positive) {
                seen.push((u, positive));
            }
        });
        // Rounding may turn the touch at 0.3 into two changes next to each other.
        seen.retain(|(u, _)| (u - 0.3).abs() > 1e-6);
        assert_eq!(seen.len(), 5, "{seen:?}");
        assert!(seen[0].1 && !seen[1].1);
        for (found, root) in seen[1..].iter().zip(roots) {
            assert!((found.0 - root).abs() < 1e-10, "{found:?} {root}");
        }
    }
}
