//! `SkinMotion`.

use pyo3::prelude::*;
use sinew_core::measure::Motion;

use crate::arrays::{Input, Length, Shape};
use crate::errors::value_error;
use crate::threads::in_pool;

/// Jitter and pop of a skin over a sequence of frames.
#[pyclass(frozen, get_all, module = "_sinew")]
pub struct SkinMotion {
    jitter_p99: f64,
    jitter_reference_p99: f64,
    jitter_excess_p99: f64,
    pop_max: f64,
    pop_reference_max: f64,
    pop_excess: f64,
    pop_frame: usize,
    pop_vertex: usize,
    pop_persistence: f64,
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
        let (count, vertices, _) = frames.getattr("shape")?.extract::<(usize, usize, usize)>()?;
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
        Ok(Self {
            jitter_p99: jitter.p99_m,
            jitter_reference_p99: jitter.reference_p99_m,
            jitter_excess_p99: jitter.excess_p99_m,
            pop_max: pop.max_m,
            pop_reference_max: pop.reference_max_m,
            pop_excess: pop.excess_m,
            pop_frame: pop.frame,
            pop_vertex: pop.vertex,
            pop_persistence: pop.persistence,
        })
    }
}
