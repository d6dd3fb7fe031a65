//! Errors of the core as Python exceptions: ValueError if lists do not fit one another, SinewError if their
//! content is impossible.

use pyo3::exceptions::PyValueError;
use pyo3::{PyErr, create_exception};
use sinew_core::Error;

create_exception!(
    _sinew,
    SinewError,
    PyValueError,
    "An array is well-formed but its content is impossible; the message names the thing and what to do."
);

/// The Python exception of a core error.
pub fn into_python(error: Error) -> PyErr {
    let message = error.to_string();
    match error {
        Error::Length { .. }
        | Error::Index { .. }
        | Error::Offsets { .. }
        | Error::FaceOffsets { .. }
        | Error::Weight { .. } => PyValueError::new_err(message),
        Error::Value { .. }
        | Error::Duplicate { .. }
        | Error::Nameless { .. }
        | Error::Cycle { .. }
        | Error::Singular { .. }
        | Error::Projective { .. }
        | Error::UnknownBone { .. }
        | Error::RigidAcrossBones { .. }
        | Error::RigidAndCurved { .. }
        | Error::UnknownWrap { .. }
        | Error::WrapOfOtherKind { .. }
        | Error::NoVertices
        | Error::NoFaces { .. }
        | Error::NoTissues
        | Error::NoJoints
        | Error::Memory { .. }
        | Error::Cancelled => SinewError::new_err(message),
    }
}

/// A ValueError with `message`.
pub fn value_error(message: String) -> PyErr {
    PyValueError::new_err(message)
}
