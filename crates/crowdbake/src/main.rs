//! The program. Everything it does is in the library, so that tests can drive it without a process.

use std::io::IsTerminal;
use std::process::ExitCode;

fn main() -> ExitCode {
    let terminal = std::io::stderr().is_terminal();
    ExitCode::from(crowdbake::run_in(std::env::args_os(), &mut std::io::stdout(), &mut std::io::stderr(), terminal))
}
