//! Replacement policies, one per file.

pub(crate) mod fifo;
pub(crate) mod lru;
