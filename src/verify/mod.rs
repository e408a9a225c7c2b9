//! What `raybudget verify` measures.

pub(crate) mod accuracy;
mod audits;
mod eyes;
pub(crate) mod eyes_table;
mod formulas;
pub(crate) mod hardware;
pub(crate) mod measure;
mod metrics;
pub(crate) mod paper_charts;
mod plan;
pub(crate) mod sampling;
