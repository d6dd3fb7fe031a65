//! Garments: skins that follow the correction of the body under them (mathematics/garments.md).

pub(crate) mod body;
pub(crate) mod frame;
pub(crate) mod ties;
