//! The carpaint program.

use std::process::ExitCode;

fn main() -> ExitCode {
    carpaint::cli::main()
}
