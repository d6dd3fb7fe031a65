//! Settings that differ from region to region (Wilhelms 1997; mathematics/binding.md, Settings by
//! region).

use crate::error::{Result, require, require_length};
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::mesh::vertex_order::VertexOrder;

/// A setting of the skin at a vertex: the value of the body, times a factor per bone, times a factor per
/// vertex (painted). All are finite and 0 or more. The product has the unit of `body`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regional<'a> {
    /// Value of the whole body.
    pub body: f64,
    /// Factors, one per bone; `None` is 1 everywhere. A vertex has the mean of its bones' factors, by its
    /// weights.
    pub bones: Option<&'a [f32]>,
    /// Factors, one per vertex; `None` is 1 everywhere.
    pub vertices: Option<&'a [f32]>,
}

impl Default for Regional<'_> {
    /// 1 everywhere.
    fn default() -> Self {
        Self::of_body(1.0)
    }
}

impl Regional<'_> {
    /// One value for the whole body.
    pub const fn of_body(body: f64) -> Self {
        Self {
            body,
            bones: None,
            vertices: None,
        }
    }

    /// The value at each vertex, by sorted index as `weights`, for a rig of `bones` bones. `setting` is
    /// its name in errors.
    ///
    /// # Errors
    /// A value that is not finite or below 0, or a list whose length is not the number of bones or
    /// vertices.
    pub(crate) fn resolve(
        &self,
        setting: &'static str,
        weights: &BoneWeights,
        bones: usize,
        order: &VertexOrder,
    ) -> Result<Vec<f32>> {
        require(
            self.body.is_finite() && self.body >= 0.0,
            || "skin".to_owned(),
            setting,
            self.body,
            "finite and 0 or more",
        )?;
        require_factors(setting, self.bones, bones, "one per bone", "bone")?;
        require_factors(
            setting,
            self.vertices,
            order.mesh_len(),
            "one per vertex",
            "vertex",
        )?;
        let at = |(index, vertex): (usize, usize)| {
            let of_bones = self.bones.map_or(1.0, |bones| mean(bones, weights, index));
            let painted = self.vertices.map_or(1.0, |factors| f64::from(factors[vertex]));
            // a product of large factors stays finite
            (self.body * of_bones * painted).min(f64::from(f32::MAX)) as f32
        };
        Ok(order.vertices().enumerate().map(at).collect())
    }
}

/// The mean of its bones' factors at a vertex; 1 if it has no bones. It is divided by the sum of the same
/// weights, so that equal factors of 0 or 1 give exactly 0 or 1.
pub(crate) fn mean(factors: &[f32], weights: &BoneWeights, vertex: usize) -> f64 {
    let (mut total, mut sum) = (0.0, 0.0);
    for entry in weights.of(vertex) {
        let weight = f64::from(entry.weight);
        total += weight * f64::from(factors[entry.bone as usize]);
        sum += weight;
    }
    if sum > 0.0 { total / sum } else { 1.0 }
}

/// Fails if there are not `expected` factors, or one is not finite or below 0.
fn require_factors(
    setting: &'static str,
    factors: Option<&[f32]>,
    expected: usize,
    reason: &'static str,
    kind: &str,
) -> Result<()> {
    let Some(factors) = factors else { return Ok(()) };
    require_length(setting, expected, reason, factors.len())?;
    require_each(setting, factors, kind, f32::MAX, "finite and 0 or more")
}

/// Strengths of the joints at the heads of `bones` bones, 0 to 1; all 1 if none are given.
///
/// # Errors
/// A strength outside 0 to 1, or a list whose length is not the number of bones.
pub(crate) fn strengths(setting: &'static str, given: Option<&[f32]>, bones: usize) -> Result<Vec<f32>> {
    let Some(given) = given else {
        return Ok(vec![1.0; bones]);
    };
    require_length(setting, bones, "one per bone", given.len())?;
    require_each(setting, given, "bone", 1.0, "0 to 1")?;
    Ok(given.to_vec())
}

fn require_each(
    setting: &'static str,
    numbers: &[f32],
    kind: &str,
    largest: f32,
    limit: &'static str,
) -> Result<()> {
    for (position, &number) in numbers.iter().enumerate() {
        require(
            (0.0..=largest).contains(&number),
            || format!("{kind} {position}"),
            setting,
            number.into(),
            limit,
        )?;
    }
    Ok(())
}
