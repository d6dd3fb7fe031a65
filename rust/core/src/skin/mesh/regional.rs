//! Settings that differ from region to region: of the whole body, of a bone, of a vertex (Wilhelms 1997).

use crate::error::{Result, require, require_length};
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::mesh::vertex_order::VertexOrder;

/// A setting of the skin: of the whole body, times one a bone (a segment's), times one a vertex (painted). All are finite
/// and 0 or more; the product has the unit of `body`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regional<'a> {
    /// The whole body's value.
    pub body: f64,
    /// Factors, one a bone; `None` for 1 everywhere. A vertex between bones has their mean, by its weights.
    pub bones: Option<&'a [f32]>,
    /// Factors, one a vertex; `None` for 1 everywhere.
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

    /// The value at each vertex, by their numbers in `order` as `weights` are, on a rig of `bones` bones; `setting` names it where
    /// it is refused.
    ///
    /// # Errors
    /// A value that is not finite or below 0, a list of another length than bones or vertices.
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
        let at = |(number, vertex): (usize, usize)| {
            let of_bones = self.bones.map_or(1.0, |bones| mean(bones, weights, number));
            let own = self.vertices.map_or(1.0, |factors| f64::from(factors[vertex]));
            // a product of large factors stays finite, too
            (self.body * of_bones * own).min(f64::from(f32::MAX)) as f32
        };
        Ok(order.vertices().enumerate().map(at).collect())
    }
}

/// The mean of its bones' factors at a vertex; 1 where it has no bones. Divided by the sum of these very weights, so that
/// one factor everywhere is that factor, to the bit where it is 0 or 1.
pub(crate) fn mean(factors: &[f32], weights: &BoneWeights, vertex: usize) -> f64 {
    let (mut total, mut sum) = (0.0, 0.0);
    for own in weights.of(vertex) {
        let weight = f64::from(own.weight);
        total += weight * f64::from(factors[own.bone as usize]);
        sum += weight;
    }
    if sum > 0.0 { total / sum } else { 1.0 }
}

/// Fails where `factors` are not as many as `due`, or one is not finite or below 0.
fn require_factors(
    setting: &'static str,
    factors: Option<&[f32]>,
    due: usize,
    reason: &'static str,
    kind: &str,
) -> Result<()> {
    let Some(factors) = factors else { return Ok(()) };
    require_length(setting, due, reason, factors.len())?;
    require_each(setting, factors, kind, f32::MAX, "finite and 0 or more")
}

/// Strengths of the joints at the heads of `bones` bones, 0..1; all 1 where none are given.
///
/// # Errors
/// A strength outside 0..1, a list of another length than bones.
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
    most: f32,
    limit: &'static str,
) -> Result<()> {
    for (position, &number) in numbers.iter().enumerate() {
        require(
            (0.0..=most).contains(&number),
            || format!("{kind} {position}"),
            setting,
            number.into(),
            limit,
        )?;
    }
    Ok(())
}
