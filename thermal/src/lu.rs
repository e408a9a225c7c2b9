//! Small dense systems by Gaussian elimination with partial pivoting.

/// A matrix taken apart, row by row, with its exchanges of rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lu {
    entries: Vec<f64>,
    pivots: Vec<usize>,
}

impl Lu {
    /// The matrix whose entries a caller fills in before [`Self::factor`].
    pub(crate) fn clear(&mut self, n: usize) -> &mut [f64] {
        self.entries.clear();
        self.entries.resize(n * n, 0.0);
        &mut self.entries
    }

    /// Takes the matrix of `n` rows apart; `false` where it is singular or has an entry that is no number.
    pub(crate) fn factor(&mut self, n: usize) -> bool {
        let a = &mut self.entries;
        self.pivots.clear();
        for k in 0..n {
            let size = |row: &usize| a[row * n + k].abs();
            let pivot = (k..n).max_by(|i, j| size(i).total_cmp(&size(j))).unwrap_or(k);
            let largest = size(&pivot);
            if !(largest > 0.0 && largest.is_finite()) {
                return false;
            }
            (0..n).for_each(|j| a.swap(k * n + j, pivot * n + j));
            self.pivots.push(pivot);
            for i in k + 1..n {
                let factor = a[i * n + k] / a[k * n + k];
                a[i * n + k] = factor;
                (k + 1..n).for_each(|j| a[i * n + j] -= factor * a[k * n + j]);
            }
        }
        true
    }

    /// Replaces the right-hand side by the solution.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        let (a, n) = (&self.entries, b.len());
        for (k, &pivot) in self.pivots.iter().enumerate() {
            b.swap(k, pivot);
        }
        for i in 0..n {
            b[i] -= (0..i).map(|j| a[i * n + j] * b[j]).sum::<f64>();
        }
        for i in (0..n).rev() {
            let rest: f64 = (i + 1..n).map(|j| a[i * n + j] * b[j]).sum();
            b[i] = (b[i] - rest) / a[i * n + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_that_needs_exchanges_is_solved() {
        let mut lu = Lu::default();
        lu.clear(3).copy_from_slice(&[0.0, 2.0, 1.0, 1.0, -2.0, -3.0, -1.0, 1.0, 2.0]);
        assert!(lu.factor(3));
        let mut x = [8.0, -13.0, 9.0];
        lu.solve(&mut x);
        let back = [2.0 * x[1] + x[2], x[0] - 2.0 * x[1] - 3.0 * x[2], -x[0] + x[1] + 2.0 * x[2]];
        for (back, b) in back.into_iter().zip([8.0, -13.0, 9.0_f64]) {
            assert!((back - b).abs() < 1e-13, "{x:?}");
        }
        lu.clear(2).copy_from_slice(&[1.0, 2.0, 2.0, 4.0]);
        assert!(!lu.factor(2));
    }
}
