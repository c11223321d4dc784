//! Affine maps and their inverses.

use glam::{DMat4, DVec3, DVec4};

/// An invertible affine map between spaces, kept with its inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    matrix: DMat4,
    inverse: DMat4,
}

/// Reason why a matrix cannot be used as a transform.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TransformError {
    /// An element is NaN or infinite.
    #[error("the matrix has an element that is not finite")]
    NotFinite,
    /// The matrix maps space onto a plane, a line or a point.
    #[error("the matrix cannot be inverted (its determinant is {determinant:e})")]
    Singular {
        /// The matrix' determinant.
        determinant: f64,
    },
    /// The last row is not 0 0 0 1.
    #[error("the matrix is not affine: its last row must be 0 0 0 1")]
    NotAffine,
}

impl Transform {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self {
        matrix: DMat4::IDENTITY,
        inverse: DMat4::IDENTITY,
    };

    /// The transform with this matrix (column vectors: `p' = M p`).
    ///
    /// # Errors
    ///
    /// If an element is not finite, the last row is not 0 0 0 1, or the matrix has no inverse.
    pub fn from_matrix(matrix: DMat4) -> Result<Self, TransformError> {
        if !matrix.is_finite() {
            return Err(TransformError::NotFinite);
        }
        if matrix.row(3) != DVec4::W {
            return Err(TransformError::NotAffine);
        }
        let determinant = matrix.determinant();
        let inverse = matrix.inverse();
        if determinant == 0.0 || !inverse.is_finite() {
            return Err(TransformError::Singular { determinant });
        }
        Ok(Self { matrix, inverse })
    }

    /// The matrix, for column vectors.
    #[inline]
    pub fn matrix(&self) -> DMat4 {
        self.matrix
    }

    /// The inverse map.
    #[inline]
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self {
            matrix: self.inverse,
            inverse: self.matrix,
        }
    }

    /// The composition: first `inner`, then this.
    ///
    /// # Errors
    ///
    /// If the product overflows or cannot be inverted.
    pub fn after(&self, inner: &Self) -> Result<Self, TransformError> {
        Self::from_matrix(self.matrix * inner.matrix)
    }

    /// The image of a point.
    #[inline]
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.matrix.transform_point3(point)
    }

    /// The image of a difference of points; lengths are not kept.
    #[inline]
    pub fn vector(&self, vector: DVec3) -> DVec3 {
        self.matrix.transform_vector3(vector)
    }

    /// The image of a surface normal, by the inverse transpose; lengths are not kept.
    #[inline]
    pub fn normal(&self, normal: DVec3) -> DVec3 {
        DVec3::new(
            self.inverse.x_axis.truncate().dot(normal),
            self.inverse.y_axis.truncate().dot(normal),
            self.inverse.z_axis.truncate().dot(normal),
        )
    }

    /// True if the map turns a right hand into a left one.
    #[inline]
    pub fn is_mirroring(&self) -> bool {
        self.matrix.determinant() < 0.0
    }
}
