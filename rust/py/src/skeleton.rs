//! `Skeleton`.

use pyo3::prelude::*;

use crate::arrays::{Input, Length, Shape};
use crate::errors::into_python;

/// The rest pose of a rig: one matrix per bone.
#[pyclass(frozen, module = "_sinew")]
pub struct Skeleton {
    /// The skeleton of the core.
    pub core: sinew_core::Skeleton,
}

#[pymethods]
impl Skeleton {
    #[new]
    fn new(names: Vec<String>, parents: &Bound<'_, PyAny>, rest: &Bound<'_, PyAny>) -> PyResult<Self> {
        let count = Length::Named('B', names.len());
        let parents = Input::<i32>::new("parents", parents, Shape(&[count]))?;
        let rest = Input::<f32>::new(
            "rest",
            rest,
            Shape(&[count, Length::Exactly(4), Length::Exactly(4)]),
        )?;
        let core =
            sinew_core::Skeleton::new(names, parents.numbers()?, rest.groups()?).map_err(into_python)?;
        Ok(Self { core })
    }

    fn __len__(&self) -> usize {
        self.core.len()
    }
}
