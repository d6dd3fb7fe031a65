//! `Elasticity`.

use pyo3::prelude::*;
use sinew_core::{Energy, Segments};

use crate::arrays::{Input, Length, Shape};
use crate::errors::value_error;
use crate::regional::{Regional, one_each};
use crate::scalars::Whole;

/// Most iterations of the solver per frame.
const MOST_ITERATIONS: usize = 1000;

/// Elastic skin around the joints at which it bends. `Skin` checks it against mesh and rig.
#[pyclass(frozen, module = "_sinew")]
pub struct Elasticity {
    spring_edges: Vec<[i32; 2]>,
    triangles: Vec<[i32; 3]>,
    segments: Vec<i32>,
    bone_lengths: Vec<f32>,
    iterations: usize,
    energy: Energy,
    anchor_stiffness: Regional,
    edge_stiffness: Regional,
    slack: Regional,
    relaxation: Regional,
    fat_sliding: Regional,
    volume: Option<Vec<f32>>,
    crease: Option<Vec<f32>>,
    contact: Option<Vec<f32>>,
    contacts: bool,
    safeguard: bool,
}

#[pymethods]
impl Elasticity {
    #[new]
    #[pyo3(signature = (spring_edges, triangles, segments, bone_lengths, iterations = Whole::of(10), *,
        energy = "AS_RIGID_AS_POSSIBLE", anchor_stiffness = None, edge_stiffness = None, slack = None,
        relaxation = None, fat_sliding = None, volume = None, crease = None, contact = None, contacts = true,
        safeguard = true))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        spring_edges: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        segments: &Bound<'_, PyAny>,
        bone_lengths: &Bound<'_, PyAny>,
        iterations: Whole,
        energy: &str,
        anchor_stiffness: Option<&Regional>,
        edge_stiffness: Option<&Regional>,
        slack: Option<&Regional>,
        relaxation: Option<&Regional>,
        fat_sliding: Option<&Regional>,
        volume: Option<&Bound<'_, PyAny>>,
        crease: Option<&Bound<'_, PyAny>>,
        contact: Option<&Bound<'_, PyAny>>,
        contacts: bool,
        safeguard: bool,
    ) -> PyResult<Self> {
        let iterations: usize = iterations.named("iterations")?;
        if iterations > MOST_ITERATIONS {
            return Err(value_error(format!(
                "iterations: expected 0 to {MOST_ITERATIONS}, got {iterations}"
            )));
        }
        let lists = |corners| [Length::Any('N'), Length::Exactly(corners)];
        let spring_edges = Input::<i32>::new("spring_edges", spring_edges, Shape(&lists(2)))?;
        let triangles = Input::<i32>::new("triangles", triangles, Shape(&lists(3)))?;
        let segments = Input::<i32>::new("segments", segments, Shape(&[Length::Any('B')]))?;
        let bones = Length::Named('B', segments.numbers()?.len());
        let lengths = Input::<f32>::new("bone_lengths", bone_lengths, Shape(&[bones]))?;
        let or_body = |given: Option<&Regional>, body| given.cloned().unwrap_or(Regional::of_body(body));
        Ok(Self {
            spring_edges: spring_edges.groups()?.to_vec(),
            triangles: triangles.groups()?.to_vec(),
            segments: segments.numbers()?.to_vec(),
            bone_lengths: lengths.numbers()?.to_vec(),
            iterations,
            energy: energy_of(energy)?,
            anchor_stiffness: or_body(anchor_stiffness, 1.0),
            edge_stiffness: or_body(edge_stiffness, 1.0),
            slack: or_body(slack, 0.0),
            relaxation: or_body(relaxation, 1.0),
            fat_sliding: or_body(fat_sliding, 0.0),
            volume: one_each("volume", volume, bones)?,
            crease: one_each("crease", crease, bones)?,
            contact: one_each("contact", contact, bones)?,
            contacts,
            safeguard,
        })
    }
}

impl Elasticity {
    /// A view for the core.
    pub fn core(&self) -> sinew_core::Elasticity<'_> {
        sinew_core::Elasticity {
            spring_edges: &self.spring_edges,
            triangles: &self.triangles,
            segments: Segments {
                of_bone: &self.segments,
                lengths_m: &self.bone_lengths,
            },
            iterations: self.iterations,
            energy: self.energy,
            anchor_stiffness: self.anchor_stiffness.core(),
            edge_stiffness: self.edge_stiffness.core(),
            slack_m: self.slack.core(),
            relaxation: self.relaxation.core(),
            fat_sliding: self.fat_sliding.core(),
            volume: self.volume.as_deref(),
            crease: self.crease.as_deref(),
            contact: self.contact.as_deref(),
            contacts: self.contacts,
            safeguards: self.safeguard,
        }
    }
}

fn energy_of(energy: &str) -> PyResult<Energy> {
    match energy {
        "AS_RIGID_AS_POSSIBLE" => Ok(Energy::AsRigidAsPossible),
        "SPRINGS" => Ok(Energy::Springs),
        _ => Err(value_error(format!(
            "energy: expected AS_RIGID_AS_POSSIBLE or SPRINGS, got {energy:?}"
        ))),
    }
}
