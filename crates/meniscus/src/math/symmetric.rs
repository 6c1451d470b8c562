//! Eigenvalues of symmetric 3×3 matrices.

use glam::{DMat3, DVec3};

/// Eigenvalues of a symmetric matrix and its unit eigenvectors as columns, by Jacobi's rotations.
pub fn eigen(matrix: DMat3) -> (DVec3, DMat3) {
    /// Far more than are ever needed: each squares what is left off the diagonal.
    const SWEEPS: usize = 12;
    let mut m = matrix.to_cols_array_2d();
    let mut axes = DMat3::IDENTITY.to_cols_array_2d();
    let size = m
        .iter()
        .flatten()
        .fold(0.0, |size: f64, a| size.max(a.abs()));
    for _ in 0..SWEEPS {
        let mut settled = true;
        for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let off = m[p][q];
            if off.abs() <= f64::EPSILON * size {
                continue;
            }
            settled = false;
            let theta = 0.5 * (m[q][q] - m[p][p]) / off;
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            m[p][p] -= t * off;
            m[q][q] += t * off;
            (m[p][q], m[q][p]) = (0.0, 0.0);
            let (pr, qr) = (c * m[p][r] - s * m[q][r], s * m[p][r] + c * m[q][r]);
            (m[p][r], m[r][p], m[q][r], m[r][q]) = (pr, pr, qr, qr);
            for k in 0..3 {
                let (a, b) = (axes[p][k], axes[q][k]);
                (axes[p][k], axes[q][k]) = (c * a - s * b, s * a + c * b);
            }
        }
        if settled {
            break;
        }
    }
    let values = DVec3::new(m[0][0], m[1][1], m[2][2]);
    (values, DMat3::from_cols_array_2d(&axes))
}
