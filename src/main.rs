//! The `raybudget` command line.
fn main() {}
