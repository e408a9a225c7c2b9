//! What `raybudget verify` measures.

pub(crate) mod accuracy;
mod audits;
mod eyes;
mod formulas;
pub(crate) mod hardware;
pub(crate) mod measure;
mod metrics;
pub(crate) mod paper_charts;
mod plan;
pub(crate) mod sampling;
