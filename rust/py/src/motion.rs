//! `SkinMotion`.

use pyo3::prelude::*;
use sinew_core::measure::{Jitter, Motion, Pop};

use crate::arrays::{Input, Length, Shape};
use crate::errors::value_error;
use crate::threads::in_pool;

/// Jitter and pop of a skin over a sequence of frames.
#[pyclass(frozen, module = "_sinew")]
pub struct SkinMotion {
    jitter: Jitter,
    pop: Pop,
}

#[pymethods]
impl SkinMotion {
    #[new]
    #[pyo3(signature = (frames, reference, counted = None))]
    fn new(
        py: Python<'_>,
        frames: &Bound<'_, PyAny>,
        reference: &Bound<'_, PyAny>,
        counted: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let three = Length::Exactly(3);
        let skin = Input::<f32>::new(
            "frames",
            frames,
            Shape(&[Length::Any('N'), Length::Any('V'), three]),
        )?;
        let [count, vertices] = frames
            .getattr("shape")?
            .extract::<(usize, usize, usize)>()
            .map(|shape| [shape.0, shape.1])?;
        let like = [Length::Named('N', count), Length::Named('V', vertices), three];
        let reference = Input::<f32>::new("reference", reference, Shape(&like))?;
        let counted = counted
            .map(|counted| Input::<bool>::new("counted", counted, Shape(&[Length::Named('V', vertices)])))
            .transpose()?;
        if vertices == 0 {
            return Err(value_error("frames: expected vertices, got none".to_owned()));
        }
        let motion = Motion {
            vertices,
            skin: skin.groups()?,
            reference: reference.groups()?,
            counted: counted.as_ref().map(Input::numbers).transpose()?,
        };
        let (jitter, pop) = in_pool(py, || (motion.jitter(), motion.pop()));
        Ok(Self { jitter, pop })
    }

    #[getter]
    fn jitter_p99(&self) -> f64 {
        self.jitter.p99_m
    }

    #[getter]
    fn jitter_reference_p99(&self) -> f64 {
        self.jitter.reference_p99_m
    }

    #[getter]
    fn jitter_excess_p99(&self) -> f64 {
        self.jitter.excess_p99_m
    }

    #[getter]
    fn pop_max(&self) -> f64 {
        self.pop.max_m
    }

    #[getter]
    fn pop_reference_max(&self) -> f64 {
        self.pop.reference_max_m
    }

    #[getter]
    fn pop_excess(&self) -> f64 {
        self.pop.excess_m
    }

    #[getter]
    fn pop_frame(&self) -> usize {
        self.pop.frame
    }

    #[getter]
    fn pop_vertex(&self) -> usize {
        self.pop.vertex
    }

    #[getter]
    fn pop_persistence(&self) -> f64 {
        self.pop.persistence
    }
}
