//! Which pairs of clusters are close in a pose, and from which plane on: where a plane lies between the skin of two clusters,
//! neither meets the other, and what of either lies on its own side of it need not be looked at. In a crook that is most of what
//! the balls around clusters let through.

use glam::Vec3A;

use crate::skin::contact::broadphase::PosedCluster;
use crate::skin::contact::cluster::Pair;
use crate::skin::contact::contact::Contact;

/// Cosine of the facings of two clusters above which no plane between them is looked for: one hardly faces the other.
const LARGEST_AXIS_COS: f32 = 0.5;
/// Largest distance of a triangle's points from its nearest corner, over its longest edge, where no angle is obtuse.
const FARTHEST_FROM_CORNER: f32 = 0.58;

/// A cluster and another that it may meet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClosePair {
    pub cluster: u32,
    pub other: u32,
    /// The pair out of the cluster, towards the other; 0 where they do not face each other.
    separating_axis: Vec3A,
    /// How far that pair the other begins, less the margin, m: skin that does not lie beyond is clear of it.
    offset_m: f32,
    /// Depth up to which the skin of the two is moved apart, m.
    pub reach_m: f32,
    /// Square of the distance up to which the other's vertices are looked at, m²: the corners of a wide triangle lie farther away
    /// than the triangle.
    pub within_squared: f32,
    /// The box around the other as it lies, m.
    low: Vec3A,
    high: Vec3A,
}

impl ClosePair {
    /// Whether skin of the cluster that lies at `position` may meet some of the other, a vertex of which is nearer than the root of
    /// `square`, m².
    pub fn may_meet(&self, position: Vec3A, square: f32) -> bool {
        let gap = (self.low - position).max(position - self.high).max(Vec3A::ZERO);
        position.dot(self.separating_axis) > self.offset_m && gap.length_squared() < square
    }
}

/// The boxes around clusters as they lie.
#[derive(Debug)]
pub(crate) struct Boxes(Vec<Option<(Vec3A, Vec3A)>>);

impl Boxes {
    pub fn new(clusters: usize) -> Self {
        Self(vec![None; clusters])
    }

    /// Keeps of `pairs` those that are close, and writes what is to be known of them to `close`, both ways, cluster by cluster.
    /// Their vertices lie at `positions`.
    pub fn find_close(
        &mut self,
        contact: &Contact,
        posed: &[PosedCluster],
        positions: &[Vec3A],
        pairs: &mut Vec<Pair>,
        close: &mut Vec<ClosePair>,
    ) {
        self.0.fill(None);
        for cluster in pairs.iter().flat_map(|pair| [pair.one, pair.other]) {
            let held = &mut self.0[cluster as usize];
            if held.is_none() {
                *held = contact.box_of(cluster, positions);
            }
        }
        close.clear();
        pairs.retain(|pair| {
            let scale = posed[pair.one as usize]
                .scale
                .max(posed[pair.other as usize].scale);
            let boxes = (self.0[pair.one as usize], self.0[pair.other as usize]);
            let (Some(one), Some(other)) = boxes else {
                return false;
            };
            let gap = (one.0 - other.1).max(other.0 - one.1).max(Vec3A::ZERO);
            if gap.length_squared() >= (contact.reach_m * scale).powi(2) {
                return false;
            }
            let margin_m = contact.margin_m * scale;
            let [one_m, other_m] = [pair.one, pair.other].map(|cluster| contact.reaches_m[cluster as usize]);
            let reach_m = one_m.min(other_m);
            let within_m = |other: u32| {
                let middle_m = FARTHEST_FROM_CORNER * contact.clusters[other as usize].longest_edge_m;
                reach_m.hypot(middle_m).min(contact.reach_m)
            };
            let facing = |cluster: u32| posed[cluster as usize].axis;
            let mut separating_axis = (facing(pair.one) - facing(pair.other)).normalize_or_zero();
            let (mut from_one_m, mut from_other_m) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
            if facing(pair.one).dot(facing(pair.other)) > LARGEST_AXIS_COS {
                separating_axis = Vec3A::ZERO;
            } else {
                let heights = |cluster: u32| contact.heights(cluster, separating_axis, positions);
                from_one_m = heights(pair.other).fold(f32::INFINITY, f32::min) - margin_m;
                from_other_m = -heights(pair.one).fold(f32::NEG_INFINITY, f32::max) - margin_m;
                if from_one_m > -margin_m - from_other_m {
                    return false;
                }
            }
            let directed = |cluster, other, separating_axis, offset_m, (low, high)| ClosePair {
                cluster,
                other,
                separating_axis,
                offset_m,
                reach_m: reach_m * scale,
                within_squared: (within_m(other) * scale).powi(2),
                low,
                high,
            };
            close.push(directed(pair.one, pair.other, separating_axis, from_one_m, other));
            if pair.one != pair.other {
                close.push(directed(pair.other, pair.one, -separating_axis, from_other_m, one));
            }
            true
        });
        close.sort_unstable_by_key(|pair| (pair.cluster, pair.other));
    }
}

impl Contact {
    fn box_of(&self, cluster: u32, positions: &[Vec3A]) -> Option<(Vec3A, Vec3A)> {
        let own = positions[self.clusters[cluster as usize].vertices.clone()].iter();
        own.map(|&position| (position, position))
            .reduce(|held, position| (held.0.min(position.0), held.1.max(position.1)))
    }

    fn heights(&self, cluster: u32, separating_axis: Vec3A, positions: &[Vec3A]) -> impl Iterator<Item = f32> {
        let own = positions[self.clusters[cluster as usize].vertices.clone()].iter();
        own.map(move |position| position.dot(separating_axis))
    }
}
