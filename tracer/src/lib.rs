//! Acceleration structures and instrumented traversals that record what each ray visits.
