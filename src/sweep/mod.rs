//! Sweeps: which points a file asks for, and which of them are known already.

mod plan;
mod point;
mod store;

pub(crate) use plan::Plan;
pub(crate) use point::{ReadyPoint, scene_key};
pub(crate) use store::Store;
