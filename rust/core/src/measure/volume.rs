//! Volume by signed tetrahedra, and closing an open surface by fans.

use glam::DVec3;

/// Triangles closed over their boundary loops, with a copy of the points.
#[derive(Debug)]
pub(super) struct Closed {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Closed {
    /// `triangles`, with a fan from the centre of each boundary loop to its edges.
    ///
    /// The edges of a fan oppose those of the loop, so that the closed surface has the orientation of the
    /// triangles.
    pub fn new(points: &[DVec3], triangles: &[[u32; 3]], boundary_loops: &[Vec<u32>]) -> Self {
        let mut closed = Self {
            points: points.to_vec(),
            triangles: triangles.to_vec(),
        };
        for boundary in boundary_loops {
            let middle = boundary
                .iter()
                .map(|&vertex| points[vertex as usize])
                .sum::<DVec3>()
                / boundary.len() as f64;
            let hub = closed.points.len() as u32;
            closed.points.push(middle);
            let after = boundary.iter().cycle().skip(1);
            closed
                .triangles
                .extend(boundary.iter().zip(after).map(|(&start, &end)| [end, start, hub]));
        }
        closed
    }

    /// Signed volume, m³: positive if the triangles face outwards. Overlaps count twice.
    pub fn volume(&self) -> f64 {
        let origin = self.middle();
        let sixfold = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|vertex| self.points[vertex as usize] - origin);
            a.dot(b.cross(c))
        };
        self.triangles.iter().map(sixfold).sum::<f64>() / 6.0
    }

    /// Lower and upper corner of the bounding box of all triangles; both 0 without triangles.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let used = self
            .triangles
            .iter()
            .flatten()
            .map(|&vertex| self.points[vertex as usize]);
        used.fold(None, |bounds: Option<(DVec3, DVec3)>, point| match bounds {
            Some((low, high)) => Some((low.min(point), high.max(point))),
            None => Some((point, point)),
        })
        .unwrap_or_default()
    }

    /// The centre of the bounding box, as the origin of the tetrahedra: volumes of things far from the origin
    /// keep their digits.
    fn middle(&self) -> DVec3 {
        let (low, high) = self.bounds();
        0.5 * (low + high)
    }
}
