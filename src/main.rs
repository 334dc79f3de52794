//! The program `toile`; everything it does is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    toile::cli::run()
}
