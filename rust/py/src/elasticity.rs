//! `Elasticity`.

use pyo3::prelude::*;
use sinew_core::Segments;

use crate::arrays::{Input, Length, Shape};
use crate::errors::value_error;

/// Most rounds of relaxation a frame.
const MOST_ITERATIONS: usize = 1000;

/// What makes a skin elastic; checked against mesh and rig where a `Skin` is made with it.
#[pyclass(frozen, module = "_sinew")]
pub struct Elasticity {
    struts: Vec<[i32; 2]>,
    triangles: Vec<[i32; 3]>,
    segments: Vec<i32>,
    bone_lengths: Vec<f32>,
    iterations: usize,
}

#[pymethods]
impl Elasticity {
    #[new]
    #[pyo3(signature = (struts, triangles, segments, bone_lengths, iterations = 10))]
    fn new(
        struts: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        segments: &Bound<'_, PyAny>,
        bone_lengths: &Bound<'_, PyAny>,
        iterations: usize,
    ) -> PyResult<Self> {
        if iterations > MOST_ITERATIONS {
            return Err(value_error(format!(
                "iterations: expected 0 to {MOST_ITERATIONS}, got {iterations}"
            )));
        }
        let lists = |corners| [Length::Any('N'), Length::Exactly(corners)];
        let struts = Input::<i32>::new("struts", struts, Shape(&lists(2)))?;
        let triangles = Input::<i32>::new("triangles", triangles, Shape(&lists(3)))?;
        let segments = Input::<i32>::new("segments", segments, Shape(&[Length::Any('B')]))?;
        let bones = Length::Named('B', segments.numbers()?.len());
        let lengths = Input::<f32>::new("bone_lengths", bone_lengths, Shape(&[bones]))?;
        Ok(Self {
            struts: struts.groups()?.to_vec(),
            triangles: triangles.groups()?.to_vec(),
            segments: segments.numbers()?.to_vec(),
            bone_lengths: lengths.numbers()?.to_vec(),
            iterations,
        })
    }
}

impl Elasticity {
    /// The core's view of it.
    pub fn core(&self) -> sinew_core::Elasticity<'_> {
        sinew_core::Elasticity {
            struts: &self.struts,
            triangles: &self.triangles,
            segments: Segments {
                of_bone: &self.segments,
                lengths_m: &self.bone_lengths,
            },
            iterations: self.iterations,
        }
    }
}
