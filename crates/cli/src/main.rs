//! The `fingervision` command.
fn main() {}
