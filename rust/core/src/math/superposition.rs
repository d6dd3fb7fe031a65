//! The rotation that superposes one set of points best on another (B. K. P. Horn 1987), by the characteristic polynomial of
//! Horn's matrix (D. L. Theobald, "Rapid Calculation of RMSDs Using a Quaternion-Based Characteristic Polynomial", 2005).
//! A Jacobi solution of the same eigenproblem takes about ten times as long.

use glam::{DMat3, DQuat};

use crate::math::eigen::SymmetricEigen;

/// Newton steps at most. From above all roots they converge without a detour; about six are enough.
const MOST_STEPS: usize = 50;
/// Length of a row of cofactors, over the cube of the norm of the covariance, from which the row gives the eigenvector. It is
/// above the rounding of f64. If none is as long, two rotations fit almost equally well.
const LEAST_ROW: f64 = 1e-6;

/// The rotation that maps rest positions best to posed ones. `covariance` is the sum of `rest posedᵀ` over the points, both from
/// their means; its columns are the posed axes. The identity if an entry is not finite or all are 0.
pub(crate) fn best_rotation(covariance: DMat3) -> DQuat {
    let square: f64 = covariance.to_cols_array().iter().map(|entry| entry * entry).sum();
    if !(square.is_finite() && square > 0.0) {
        return DQuat::IDENTITY;
    }
    let matrix = horn_matrix(covariance * square.sqrt().recip());
    let largest = largest_eigenvalue(&matrix, covariance.determinant() / (square * square.sqrt()));
    let [w, x, y, z] = eigenvector(&matrix, largest);
    DQuat::from_xyzw(x, y, z, w).normalize()
}

fn horn_matrix(covariance: DMat3) -> [[f64; 4]; 4] {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = covariance.to_cols_array_2d();
    #[rustfmt::skip]
    let matrix = [
        [xx + yy + zz, yz - zy,      zx - xz,      xy - yx],
        [yz - zy,      xx - yy - zz, xy + yx,      zx + xz],
        [zx - xz,      xy + yx,      yy - xx - zz, yz + zy],
        [xy - yx,      zx + xz,      yz + zy,      zz - xx - yy],
    ];
    matrix
}

/// The largest root of the characteristic polynomial of Horn's matrix of a covariance with norm 1 and this determinant.
fn largest_eigenvalue(matrix: &[[f64; 4]; 4], determinant: f64) -> f64 {
    let constant = (0..4)
        .map(|row| matrix[row][0] * cofactor(matrix, row, 0))
        .sum::<f64>();
    let mut root = 3.0_f64.sqrt(); // no singular values of norm 1 have a larger sum
    for _ in 0..MOST_STEPS {
        let square = root * root;
        let value = ((square - 2.0) * root - 8.0 * determinant) * root + constant;
        let slope = (4.0 * square - 4.0) * root - 8.0 * determinant;
        let step = value / slope;
        if !step.is_finite() {
            break;
        }
        root -= step;
        if step.abs() <= f64::EPSILON * root.abs() {
            break;
        }
    }
    root
}

/// An eigenvector of the eigenvalue: a row of the cofactors of `matrix - eigenvalue`.
fn eigenvector(matrix: &[[f64; 4]; 4], eigenvalue: f64) -> [f64; 4] {
    let mut shifted = *matrix;
    (0..4).for_each(|axis| shifted[axis][axis] -= eigenvalue);
    let rows = (0..4).map(|row| std::array::from_fn(|column| cofactor(&shifted, row, column)));
    let square = |row: &[f64; 4]| row.iter().map(|entry| entry * entry).sum::<f64>();
    let longest = rows.max_by(|a, b| square(a).total_cmp(&square(b)));
    match longest.filter(|row| square(row) > LEAST_ROW * LEAST_ROW) {
        Some(row) => row,
        None => {
            SymmetricEigen::new(*matrix).map_or([1.0, 0.0, 0.0, 0.0], |eigen| eigen.vectors[eigen.largest()])
        }
    }
}

fn cofactor(matrix: &[[f64; 4]; 4], row: usize, column: usize) -> f64 {
    let rows: [usize; 3] = std::array::from_fn(|index| index + usize::from(index >= row));
    let columns: [usize; 3] = std::array::from_fn(|index| index + usize::from(index >= column));
    let at = |index: usize, other: usize| matrix[rows[index]][columns[other]];
    let minor = at(0, 0) * (at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1))
        - at(0, 1) * (at(1, 0) * at(2, 2) - at(1, 2) * at(2, 0))
        + at(0, 2) * (at(1, 0) * at(2, 1) - at(1, 1) * at(2, 0));
    if (row + column).is_multiple_of(2) {
        minor
    } else {
        -minor
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// What a rotation makes of the fit: the trace of the rotated covariance, which the best one maximises.
    fn agreement(rotation: DQuat, covariance: DMat3) -> f64 {
        (0..3)
            .map(|axis| (rotation * DVec3::AXES[axis]).dot(covariance.transpose().col(axis)))
            .sum()
    }

    #[test]
    fn no_rotation_fits_better_than_that_of_the_eigenproblem() {
        let mut number = 0.37_f64;
        let mut next = || {
            number = (number * 997.13 + 0.71).fract();
            2.0 * number - 1.0
        };
        for case in 0..4000 {
            let mut covariance = DMat3::from_cols_array(&std::array::from_fn(|_| next()));
            match case % 4 {
                1 => covariance.z_axis = covariance.x_axis * 1e-9, // almost a plane of points
                2 => covariance.z_axis = -covariance.z_axis * 1e-3,
                3 => covariance = DMat3::from_quat(DQuat::from_rotation_x(next())) * next().abs(),
                _ => {}
            }
            let Some(eigen) = SymmetricEigen::new(horn_matrix(covariance)) else {
                panic!("{case}: not finite");
            };
            let best = eigen.values[eigen.largest()];
            let found = agreement(best_rotation(covariance), covariance);
            let rounding = 1e-9
                * covariance
                    .to_cols_array()
                    .iter()
                    .map(|entry| entry.abs())
                    .sum::<f64>();
            assert!(found >= best - rounding, "{case}: {found} of {best}");
        }
    }

    #[test]
    fn without_points_it_is_the_identity() {
        assert_eq!(best_rotation(DMat3::ZERO), DQuat::IDENTITY);
        assert_eq!(best_rotation(DMat3::IDENTITY * f64::NAN), DQuat::IDENTITY);
    }
}
