//! The command line: arguments → validated job → command → exit code.

fn main() {}
