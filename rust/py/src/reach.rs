//! `Goal`, `Reached`, `reach` and `reach_clip`.

use numpy::PyArray2;
use pyo3::prelude::*;
use sinew_core::reach::{self, ClipOptions, Program, ReachOptions, Target};

use crate::arrays::numbers_of;
use crate::errors::{into_python, value_error};
use crate::linkage::{Linkage, angles_of, quaternion_of, rows};
use crate::scalars::{Real, Whole};

/// A target for the bone of one joint.
#[pyclass(frozen, module = "_sinew")]
pub struct Goal {
    core: reach::Goal,
}

#[pymethods]
impl Goal {
    #[new]
    #[pyo3(signature = (joint, kind, target, *, point = None, axis = None, weight = Real::of(1.0)))]
    fn new(
        joint: Whole,
        kind: &str,
        target: &Bound<'_, PyAny>,
        point: Option<&Bound<'_, PyAny>>,
        axis: Option<&Bound<'_, PyAny>>,
        weight: Real,
    ) -> PyResult<Self> {
        let axis = axis
            .map_or(Ok([0.0, 1.0, 0.0]), |axis| numbers_of("axis", axis))?
            .into();
        let target = match kind {
            "POSITION" => Target::Position(numbers_of("target", target)?.into()),
            "ORIENTATION" => Target::Orientation(quaternion_of("target", target)?),
            "LOOK_AT" => Target::LookAt {
                axis,
                target: numbers_of("target", target)?.into(),
            },
            _ => {
                return Err(value_error(format!(
                    "kind: expected POSITION, ORIENTATION or LOOK_AT, got {kind:?}"
                )));
            }
        };
        let point = point
            .map_or(Ok([0.0; 3]), |point| numbers_of("point", point))?
            .into();
        let core = reach::Goal {
            joint: joint.named("joint")?,
            point,
            target,
            weight: weight.not_negative("weight")?,
        };
        Ok(Self { core })
    }
}

/// The result of a reach.
#[pyclass(frozen, module = "_sinew")]
pub struct Reached {
    core: reach::Reached,
}

#[pymethods]
impl Reached {
    #[getter]
    fn angles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, self.core.angles.iter().map(|angles| angles.to_array()))
    }

    #[getter]
    fn misses(&self) -> Vec<f64> {
        self.core.residuals.clone()
    }

    #[getter]
    fn evaluations(&self) -> usize {
        self.core.evaluations
    }
}

fn goals_of(goals: &[PyRef<'_, Goal>]) -> Vec<reach::Goal> {
    goals.iter().map(|goal| goal.core).collect()
}

/// The pose that meets the goals best.
#[pyfunction(name = "reach")]
#[pyo3(signature = (linkage, goals, preferred = None, *, preference = Real::of(1e-3), restarts = Whole::of(0)))]
pub fn reach_once(
    py: Python<'_>,
    linkage: &Linkage,
    goals: Vec<PyRef<'_, Goal>>,
    preferred: Option<&Bound<'_, PyAny>>,
    preference: Real,
    restarts: Whole,
) -> PyResult<Reached> {
    let preference = preference.not_negative("preference")?;
    let restarts = restarts.named("restarts")?;
    let goals = goals_of(&goals);
    let preferred = preferred
        .map(|preferred| angles_of("preferred", linkage.core.len(), preferred))
        .transpose()?;
    let options = ReachOptions { preference, restarts };
    let solve = || {
        let program = Program::new(&linkage.core, &goals)?;
        reach::reach(&program, preferred.as_deref(), &options)
    };
    let core = py.detach(solve).map_err(into_python)?;
    Ok(Reached { core })
}

/// The poses of consecutive frames.
#[pyfunction]
#[pyo3(signature = (linkages, goals, *, preference = Real::of(1e-3), restarts = Whole::of(0), smoothness = Real::of(0.01)))]
pub fn reach_clip(
    py: Python<'_>,
    linkages: Vec<PyRef<'_, Linkage>>,
    goals: Vec<Vec<PyRef<'_, Goal>>>,
    preference: Real,
    restarts: Whole,
    smoothness: Real,
) -> PyResult<Vec<Reached>> {
    let preference = preference.not_negative("preference")?;
    let restarts = restarts.named("restarts")?;
    if goals.len() != linkages.len() {
        return Err(value_error(format!(
            "goals: expected {} entries, one per linkage, got {}",
            linkages.len(),
            goals.len()
        )));
    }
    let goals: Vec<_> = goals.iter().map(|goals| goals_of(goals)).collect();
    let linkages: Vec<_> = linkages.iter().map(|linkage| &linkage.core).collect();
    let options = ClipOptions {
        reach: ReachOptions { preference, restarts },
        smoothness: smoothness.not_negative("smoothness")?,
    };
    let solve = || {
        let programs = linkages
            .iter()
            .zip(&goals)
            .map(|(linkage, goals)| Program::new(linkage, goals));
        reach::reach_clip(&programs.collect::<Result<Vec<_>, _>>()?, &options)
    };
    let found = py.detach(solve).map_err(into_python)?;
    Ok(found.into_iter().map(|core| Reached { core }).collect())
}
