//! Whole numbers from Python. One that its type can't hold is a ValueError that names the argument, where PyO3
//! would raise an OverflowError.

use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;

use crate::errors::value_error;

/// A whole number as Python gave it, or its text if 64 bits can't hold it. `named` checks it.
pub struct Whole(Result<i64, String>);

impl Whole {
    /// A default.
    pub const fn of(number: i64) -> Self {
        Self(Ok(number))
    }

    /// The number as the argument `name`.
    pub fn named<T: TryFrom<i64>>(self, name: &str) -> PyResult<T> {
        let refused = |found: String| {
            let least = if T::try_from(-1).is_ok() { "-2^63" } else { "0" };
            let most = if T::try_from(i64::MAX).is_ok() {
                "2^63"
            } else {
                "2^32"
            };
            value_error(format!(
                "{name}: expected a whole number from {least} up to {most}, got {found}"
            ))
        };
        let number = self.0.map_err(refused)?;
        T::try_from(number).map_err(|_| refused(number.to_string()))
    }
}

impl<'py> FromPyObject<'_, 'py> for Whole {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match object.extract::<i64>() {
            Ok(number) => Ok(Self(Ok(number))),
            Err(error) if error.is_instance_of::<PyOverflowError>(object.py()) => {
                Ok(Self(Err(object.str()?.to_string())))
            }
            Err(error) => Err(error),
        }
    }
}
