//! Two eyes: the right image made from what the left one shows, as far as it goes.
//!
//! What the left eye's rays hit is reprojected into the right image, row by row; pixels for which that gives no answer are traced (Badt 1988;
//! Adelson & Hodges, "Stereoscopic ray-tracing", 1993; on a mobile GPU: Lee et al. 2017, who call them bad pixels). What depends on the
//! direction of view, reflections, is traced for every pixel.

mod eyes;
mod reprojection;
mod row;
#[cfg(test)]
mod tests;
mod work;

pub use eyes::Eyes;
pub use reprojection::Reprojection;
pub use row::Source;
pub use work::TraversalWork;
