//! Mid phase: the pairs of clusters whose boxes are close, and a separating axis for each
//! (mathematics/contact.md, Skin contact). If a plane separates two clusters, they do not touch.
//! Otherwise only vertices beyond the start of the other cluster are tested. At a crease that excludes
//! most vertices that the bounding spheres let through.

use glam::Vec3A;

use crate::skin::contact::broadphase::PosedCluster;
use crate::skin::contact::cluster::Pair;
use crate::skin::contact::contact::Contact;

/// Cosine of two clusters' axes above which no separating axis is tried, because they hardly face each
/// other.
const LARGEST_AXIS_COS: f32 = 0.5;
/// Largest distance of a point of a triangle from its nearest corner, over its longest edge, if no angle
/// is obtuse: 1/√3, rounded up.
const FARTHEST_FROM_CORNER: f32 = 0.58;

/// A cluster and another that it may touch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClosePair {
    pub cluster: u32,
    pub other: u32,
    /// Direction out of the cluster towards the other; 0 if they do not face each other.
    separating_axis: Vec3A,
    /// Where the other cluster starts along that axis, less the margin, m. Vertices that are not beyond
    /// it are clear.
    offset_m: f32,
    /// Depth up to which the skin of the two is moved apart, m.
    pub reach_m: f32,
    /// Squared distance up to which the other's vertices are tested, m². It exceeds the reach, because
    /// the corners of a wide triangle are farther away than the triangle.
    pub within_squared: f32,
    /// Bounding box of the other cluster in the pose, m.
    low: Vec3A,
    high: Vec3A,
}

impl ClosePair {
    /// Whether a vertex of the cluster at `position` may touch the other cluster, with a vertex nearer
    /// than the root of `square`, m².
    pub fn may_meet(&self, position: Vec3A, square: f32) -> bool {
        let gap = (self.low - position).max(position - self.high).max(Vec3A::ZERO);
        position.dot(self.separating_axis) > self.offset_m && gap.length_squared() < square
    }
}

/// Bounding boxes of clusters in a pose.
#[derive(Debug)]
pub(crate) struct Boxes(Vec<Option<(Vec3A, Vec3A)>>);

impl Boxes {
    pub fn new(clusters: usize) -> Self {
        Self(vec![None; clusters])
    }

    /// Keeps the close ones of `pairs`, and writes them in both directions to `close`, sorted by cluster.
    /// `positions` are those of all vertices of the pairs, m.
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
            let bounds = &mut self.0[cluster as usize];
            if bounds.is_none() {
                *bounds = contact.box_of(cluster, positions);
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
            let axis_of = |cluster: u32| posed[cluster as usize].axis;
            let mut separating_axis = (axis_of(pair.one) - axis_of(pair.other)).normalize_or_zero();
            let (mut from_one_m, mut from_other_m) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
            if axis_of(pair.one).dot(axis_of(pair.other)) > LARGEST_AXIS_COS {
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
                close.push(directed(
                    pair.other,
                    pair.one,
                    -separating_axis,
                    from_other_m,
                    one,
                ));
            }
            true
        });
        close.sort_unstable_by_key(|pair| (pair.cluster, pair.other));
    }
}

impl Contact {
    fn box_of(&self, cluster: u32, positions: &[Vec3A]) -> Option<(Vec3A, Vec3A)> {
        let vertices = positions[self.clusters[cluster as usize].vertices.clone()].iter();
        vertices
            .map(|&position| (position, position))
            .reduce(|bounds, position| (bounds.0.min(position.0), bounds.1.max(position.1)))
    }

    fn heights(
        &self,
        cluster: u32,
        separating_axis: Vec3A,
        positions: &[Vec3A],
    ) -> impl Iterator<Item = f32> {
        let vertices = positions[self.clusters[cluster as usize].vertices.clone()].iter();
        vertices.map(move |position| position.dot(separating_axis))
    }
}
