//! Eigenvalues and eigenvectors of small symmetric matrices.

/// More sweeps than any matrix takes: each squares the size of what is left beside the diagonal.
const SWEEPS: usize = 30;

/// The eigenvalues of a symmetric matrix, each with its eigenvector of unit length. They are not sorted: those of a
/// diagonal matrix are its diagonal and the axes, in order.
///
/// The method is Jacobi's: rotations in planes of two axes bring one number after the other to 0.
pub(super) fn eigen<const N: usize>(mut matrix: [[f64; N]; N]) -> [(f64, [f64; N]); N] {
    let mut vectors = [[0.0; N]; N];
    for (number, vector) in vectors.iter_mut().enumerate() {
        vector[number] = 1.0;
    }
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..N {
            for q in p + 1..N {
                // Smaller numbers change no digit of the eigenvalues.
                if matrix[p][q].abs() <= f64::EPSILON * f64::EPSILON * (matrix[p][p] * matrix[q][q]).abs().sqrt() {
                    continue;
                }
                rotated = true;
                let ratio = (matrix[q][q] - matrix[p][p]) / (2.0 * matrix[p][q]);
                let tan = 1.0_f64.copysign(ratio) / (ratio.abs() + (ratio * ratio + 1.0).sqrt());
                let cos = 1.0 / (tan * tan + 1.0).sqrt();
                let rotate = |a: f64, b: f64| (cos * a - tan * cos * b, tan * cos * a + cos * b);
                for row in &mut matrix {
                    (row[p], row[q]) = rotate(row[p], row[q]);
                }
                for k in 0..N {
                    (matrix[p][k], matrix[q][k]) = rotate(matrix[p][k], matrix[q][k]);
                    (vectors[p][k], vectors[q][k]) = rotate(vectors[p][k], vectors[q][k]);
                }
            }
        }
        if !rotated {
            break;
        }
    }
    std::array::from_fn(|number| (matrix[number][number], vectors[number]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_are_only_scaled_by_the_matrix() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX) - 0.5
        };
        for _ in 0..100 {
            let mut matrix = [[0.0; 6]; 6];
            for (row, column) in (0..6).flat_map(|row| (0..=row).map(move |column| (row, column))) {
                let entry = random();
                (matrix[row][column], matrix[column][row]) = (entry, entry);
            }
            let found = eigen(matrix);
            for (number, (value, vector)) in found.iter().enumerate() {
                for (row, entry) in matrix.iter().zip(vector) {
                    let image: f64 = row.iter().zip(vector).map(|(a, b)| a * b).sum();
                    assert!((image - value * entry).abs() < 1e-13, "{matrix:?}");
                }
                for (other_number, (_, other)) in found.iter().enumerate() {
                    let dot: f64 = vector.iter().zip(other).map(|(a, b)| a * b).sum();
                    assert!((dot - f64::from(u8::from(number == other_number))).abs() < 1e-13, "{matrix:?}");
                }
            }
        }
    }

    #[test]
    fn a_diagonal_matrix_keeps_its_axes() {
        let found = eigen([[2.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 0.0]]);
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(found, [(2.0, axes[0]), (-1.0, axes[1]), (0.0, axes[2])]);
    }
}
