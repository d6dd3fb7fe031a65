//! Skin contact: skin that touches other skin of the same mesh (mathematics/contact.md, Skin contact).

pub(crate) mod broadphase;
pub(crate) mod cluster;
pub(crate) mod cluster_tree;
#[expect(
    clippy::module_inception,
    reason = "the data that all of its neighbours work on"
)]
pub(crate) mod contact;
pub(crate) mod contact_mesh;
pub(crate) mod facing;
pub(crate) mod facing_pairs;
pub(crate) mod frame;
pub(crate) mod midphase;
pub(crate) mod narrowphase;
pub(crate) mod points_soa;
pub(crate) mod response;
pub(crate) mod thickness;
