//! Eigenvalues and eigenvectors of small symmetric matrices, by cyclic Jacobi rotations (Jacobi 1846; Golub and Van Loan,
//! "Matrix Computations", sec. 8.5).

/// Sweeps over all entries above the diagonal. Convergence is quadratic: about six are enough for a 4x4 matrix.
const MOST_SWEEPS: usize = 50;

/// The eigenvalues of a symmetric matrix, in no particular order, and its eigenvectors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SymmetricEigen<const N: usize> {
    /// The eigenvalues.
    pub values: [f64; N],
    /// The unit eigenvector of each value. They are orthogonal to one another; their signs are arbitrary.
    pub vectors: [[f64; N]; N],
}

impl<const N: usize> SymmetricEigen<N> {
    /// The eigenvalues and eigenvectors of `matrix`, of which the entries below the diagonal are not read; `None` if an
    /// entry is not finite.
    pub fn new(matrix: [[f64; N]; N]) -> Option<Self> {
        let largest = matrix
            .iter()
            .flatten()
            .fold(0.0, |most: f64, entry| most.max(entry.abs()));
        if !matrix.iter().flatten().all(|entry| entry.is_finite()) {
            return None;
        }
        let mut vectors = [[0.0; N]; N];
        (0..N).for_each(|axis| vectors[axis][axis] = 1.0);
        if largest == 0.0 {
            return Some(Self {
                values: [0.0; N],
                vectors,
            });
        }
        // scaled, so that squares neither overflow nor vanish
        let mut scaled = matrix.map(|row| row.map(|entry| entry / largest));
        for _ in 0..MOST_SWEEPS {
            if is_diagonal(&scaled) {
                break;
            }
            for p in 0..N {
                for q in p + 1..N {
                    rotate(&mut scaled, &mut vectors, p, q);
                }
            }
        }
        Some(Self {
            values: std::array::from_fn(|axis| scaled[axis][axis] * largest),
            vectors,
        })
    }

    /// The index of the largest eigenvalue, the first of equal ones.
    pub fn largest(&self) -> usize {
        (1..N).fold(0, |best, index| {
            if self.values[index] > self.values[best] {
                index
            } else {
                best
            }
        })
    }
}

/// True if the entries above the diagonal are rounding errors of a matrix with entries up to 1.
fn is_diagonal<const N: usize>(matrix: &[[f64; N]; N]) -> bool {
    let above = |row: usize| {
        matrix[row][row + 1..]
            .iter()
            .map(|entry| entry * entry)
            .sum::<f64>()
    };
    (0..N).map(above).sum::<f64>() <= (0.1 * f64::EPSILON).powi(2)
}

/// The rotation in the plane of axes `p` < `q` that makes entry (p, q) zero. Works on the upper triangle.
fn rotate<const N: usize>(matrix: &mut [[f64; N]; N], vectors: &mut [[f64; N]; N], p: usize, q: usize) {
    let across = matrix[p][q];
    if across == 0.0 {
        return;
    }
    // the smaller of the two angles, by its tangent
    let ratio = (matrix[q][q] - matrix[p][p]) / (2.0 * across);
    let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    matrix[p][p] -= tangent * across;
    matrix[q][q] += tangent * across;
    matrix[p][q] = 0.0;
    for other in (0..N).filter(|&other| other != p && other != q) {
        let [(row_p, column_p), (row_q, column_q)] = [p, q].map(|axis| (other.min(axis), other.max(axis)));
        let (by_p, by_q) = (matrix[row_p][column_p], matrix[row_q][column_q]);
        matrix[row_p][column_p] = cosine * by_p - sine * by_q;
        matrix[row_q][column_q] = sine * by_p + cosine * by_q;
    }
    let (old_p, old_q) = (vectors[p], vectors[q]);
    vectors[p] = std::array::from_fn(|axis| cosine * old_p[axis] - sine * old_q[axis]);
    vectors[q] = std::array::from_fn(|axis| sine * old_p[axis] + cosine * old_q[axis]);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::SymmetricEigen;

    /// `Σ value · vector vectorᵀ`.
    fn rebuilt<const N: usize>(eigen: &SymmetricEigen<N>) -> [[f64; N]; N] {
        let entry = |row: usize, column: usize| {
            let part = |index: usize| {
                let vector = eigen.vectors[index];
                eigen.values[index] * vector[row] * vector[column]
            };
            (0..N).map(part).sum()
        };
        std::array::from_fn(|row| std::array::from_fn(|column| entry(row, column)))
    }

    fn symmetric<const N: usize>(entries: [[f64; N]; N]) -> [[f64; N]; N] {
        std::array::from_fn(|row| std::array::from_fn(|column| entries[row.min(column)][row.max(column)]))
    }

    fn check<const N: usize>(matrix: [[f64; N]; N]) {
        let eigen = SymmetricEigen::new(matrix).expect("the entries are finite");
        let size = matrix
            .iter()
            .flatten()
            .fold(0.0, |most: f64, entry| most.max(entry.abs()));
        for (row, again) in matrix.iter().flatten().zip(rebuilt(&eigen).iter().flatten()) {
            assert!(
                (row - again).abs() <= 1e-14 * N as f64 * size,
                "{row} became {again}"
            );
        }
        for (index, vector) in eigen.vectors.iter().enumerate() {
            for (other, beside) in eigen.vectors.iter().enumerate() {
                let dot: f64 = vector.iter().zip(beside).map(|(a, b)| a * b).sum();
                let expected = if index == other { 1.0 } else { 0.0 };
                assert!(
                    (dot - expected).abs() < 1e-14,
                    "vectors {index} and {other}: {dot}"
                );
            }
        }
        let largest = eigen.values[eigen.largest()];
        assert!(eigen.values.iter().all(|value| *value <= largest));
    }

    fn entries<const N: usize>() -> impl Strategy<Value = [[f64; N]; N]> {
        let entry = prop_oneof![-1.0..1.0, Just(0.0), Just(1.0), -1e-9..1e-9];
        let rows = proptest::array::uniform::<_, N>(proptest::array::uniform::<_, N>(entry));
        (rows, prop_oneof![Just(0), -200..200]).prop_map(|(rows, exponent)| {
            symmetric(rows.map(|row| row.map(|entry| entry * 10.0_f64.powi(exponent))))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn values_and_vectors_rebuild_a_3x3_matrix(matrix in entries::<3>()) {
            check(matrix);
        }

        #[test]
        fn values_and_vectors_rebuild_a_4x4_matrix(matrix in entries::<4>()) {
            check(matrix);
        }
    }

    #[test]
    fn equal_values_and_zero_have_vectors_too() {
        check([[0.0; 4]; 4]);
        check([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]]);
        check([[1.0; 3]; 3]);
        let eigen = SymmetricEigen::new([[2.0, 1.0], [1.0, 2.0]]).expect("the entries are finite");
        assert!((eigen.values[eigen.largest()] - 3.0).abs() < 1e-15);
    }

    #[test]
    fn a_matrix_with_an_entry_that_is_not_finite_has_none() {
        assert!(SymmetricEigen::new([[f64::NAN, 0.0], [0.0, 1.0]]).is_none());
        assert!(SymmetricEigen::new([[1.0, f64::INFINITY], [f64::INFINITY, 1.0]]).is_none());
    }
}
