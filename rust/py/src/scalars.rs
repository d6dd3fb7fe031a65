//! Single numbers from Python. One that its type can't hold is a ValueError that names the argument, where PyO3
//! would raise an OverflowError or a TypeError without the name.

use pyo3::prelude::*;

use crate::errors::value_error;

/// The largest number of any argument: a length, m, or a factor. Its square, and the sum of hundreds of them, fits in
/// a float32, so that distances are finite.
pub const LARGEST: f64 = 1e18;

/// A whole number as Python gave it, or the text of what it gave instead. `named` checks it.
pub struct Whole(Result<i64, String>);

/// A real number as Python gave it, or the text of what it gave instead. `named` checks it.
pub struct Real(Result<f64, String>);

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

impl Real {
    /// A default.
    pub const fn of(number: f64) -> Self {
        Self(Ok(number))
    }

    /// The number as the argument `name`, if it is finite and no larger than `LARGEST`.
    pub fn named(self, name: &str) -> PyResult<f64> {
        self.within(name, -LARGEST, "-1e18")
    }

    /// The number as the argument `name`, if it is from 0 to `LARGEST`.
    pub fn not_negative(self, name: &str) -> PyResult<f64> {
        self.within(name, 0.0, "0")
    }

    fn within(self, name: &str, least: f64, least_text: &str) -> PyResult<f64> {
        let refused = |found: String| {
            value_error(format!(
                "{name}: expected a number from {least_text} to {LARGEST:e}, got {found}"
            ))
        };
        let number = self.0.map_err(refused)?;
        if (least..=LARGEST).contains(&number) {
            Ok(number)
        } else {
            Err(refused(number.to_string()))
        }
    }
}

impl<'py> FromPyObject<'_, 'py> for Whole {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self(object.extract::<i64>().map_err(|_| text_of(&object))))
    }
}

impl<'py> FromPyObject<'_, 'py> for Real {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self(object.extract::<f64>().map_err(|_| text_of(&object))))
    }
}

/// What Python shows of an object.
pub fn text_of(object: &Bound<'_, PyAny>) -> String {
    object
        .repr()
        .map_or_else(|_| "something else".to_owned(), |text| text.to_string())
}
