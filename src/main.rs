//! The `nearmiss` program.
fn main() {}
