//! Eigenvalues of small symmetric matrices by Jacobi's method (Golub and Van Loan, section 8.5).
//!
//! Heat networks are graded: their rows differ by as much as their time constants. Jacobi's method gives even the smallest eigenvalues
//! of such positive definite matrices to high relative accuracy (Demmel and Veselic 1992), which methods by tridiagonal form do not.

/// A matrix `Q diag(values) Q^T`; column `k` of `Q` belongs to `values[k]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Eigen {
    pub(crate) values: Vec<f64>,
    /// Row by row.
    vectors: Vec<f64>,
}

/// After so many sweeps over all pairs the rest is rounding; six are usual.
const MOST_SWEEPS: usize = 40;

impl Eigen {
    /// Of the symmetric matrix `a` of `n` rows, which is destroyed.
    pub(crate) fn of(&mut self, a: &mut [f64], n: usize) {
        self.vectors.clear();
        self.vectors.resize(n * n, 0.0);
        (0..n).for_each(|i| self.vectors[i * n + i] = 1.0);
        for _ in 0..MOST_SWEEPS {
            let mut rotated = false;
            for p in 0..n {
                for q in p + 1..n {
                    rotated |= self.rotate(a, n, p, q);
                }
            }
            if !rotated {
                break;
            }
        }
        self.values.clear();
        self.values.extend((0..n).map(|i| a[i * n + i]));
    }

    /// Rotates the entry `(p, q)` to zero, unless it is rounding beside its diagonal.
    fn rotate(&mut self, a: &mut [f64], n: usize, p: usize, q: usize) -> bool {
        let (app, aqq, apq) = (a[p * n + p], a[q * n + q], a[p * n + q]);
        if apq.abs() <= 0.5 * f64::EPSILON * (app.abs().sqrt() * aqq.abs().sqrt()) {
            return false;
        }
        let theta = (aqq - app) / (2.0 * apq);
        let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
        let c = 1.0 / t.hypot(1.0);
        let s = t * c;
        a[p * n + p] = app - t * apq;
        a[q * n + q] = aqq + t * apq;
        (a[p * n + q], a[q * n + p]) = (0.0, 0.0);
        for k in (0..n).filter(|&k| k != p && k != q) {
            let (akp, akq) = (a[k * n + p], a[k * n + q]);
            let (kp, kq) = (c * akp - s * akq, s * akp + c * akq);
            (a[k * n + p], a[p * n + k]) = (kp, kp);
            (a[k * n + q], a[q * n + k]) = (kq, kq);
        }
        for k in 0..n {
            let (vp, vq) = (self.vectors[k * n + p], self.vectors[k * n + q]);
            self.vectors[k * n + p] = c * vp - s * vq;
            self.vectors[k * n + q] = s * vp + c * vq;
        }
        true
    }

    /// `Q^T x`.
    pub(crate) fn modes_of(&self, x: &[f64], out: &mut [f64]) {
        let n = x.len();
        for (k, out) in out.iter_mut().enumerate() {
            *out = (0..n).map(|i| self.vectors[i * n + k] * x[i]).sum();
        }
    }

    /// `Q x`.
    pub(crate) fn of_modes(&self, x: &[f64], out: &mut [f64]) {
        let n = x.len();
        for (i, out) in out.iter_mut().enumerate() {
            *out = (0..n).map(|k| self.vectors[i * n + k] * x[k]).sum();
        }
    }

    /// `Q^T e_i`.
    pub(crate) fn row(&self, i: usize) -> &[f64] {
        let n = self.values.len();
        &self.vectors[i * n..(i + 1) * n]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_graded_matrix_is_taken_apart_and_put_together() {
        let n = 4;
        // Conductances of a chain over capacities of six decades.
        let scale = [1e3, 1e1, 1e-1, 1e-3];
        let laplacian =
            [2.0, -1.0, 0.0, 0.0, -1.0, 2.0, -1.0, 0.0, 0.0, -1.0, 2.0, -1.0, 0.0, 0.0, -1.0, 1.5];
        let matrix: Vec<f64> = (0..n * n).map(|k| scale[k / n] * laplacian[k] * scale[k % n]).collect();
        let mut eigen = Eigen::default();
        eigen.of(&mut matrix.clone(), n);
        for i in 0..n {
            let mut modes = vec![0.0; n];
            let mut unit = vec![0.0; n];
            unit[i] = 1.0;
            eigen.modes_of(&unit, &mut modes);
            assert_eq!(modes, eigen.row(i));
            modes.iter_mut().zip(&eigen.values).for_each(|(mode, value)| *mode *= value);
            let mut row = vec![0.0; n];
            eigen.of_modes(&modes, &mut row);
            for j in 0..n {
                let size = (matrix[i * n + i] * matrix[j * n + j]).sqrt();
                assert!((row[j] - matrix[i * n + j]).abs() <= 1e-13 * size, "{i} {j}");
            }
        }
    }

    /// The product of all eigenvalues is the determinant, so a wrong smallest one shows although it is 1e12 times smaller than the largest.
    #[test]
    fn small_eigenvalues_are_relatively_accurate() {
        let (s, t) = (1e6, 1e-6);
        let mut matrix = vec![2.0 * s * s, -s * t, -s * t, 2.0 * t * t];
        let mut eigen = Eigen::default();
        eigen.of(&mut matrix, 2);
        let mut values = eigen.values;
        values.sort_by(f64::total_cmp);
        assert!((values[0] / (1.5 * t * t) - 1.0).abs() < 1e-14, "{values:?}");
    }
}
