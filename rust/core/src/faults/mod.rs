//! Faults of a deformed surface compared with its rest pose: inverted faces, intersecting faces, stretched
//! edges. [`measure`](crate::measure) reports them, and the safeguard of a skin compares them.

pub(crate) mod crossing;
pub(crate) mod inverted;
pub(crate) mod percentile;
pub(crate) mod stretch;
pub(crate) mod triangle_clusters;
