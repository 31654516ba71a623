//! The `amcheck` command.

fn main() {}
