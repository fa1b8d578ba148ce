//! Thin: words in, exit code out. Everything else is the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    crowdplay::loss::quiet_panics();
    let code = crowdplay::run(std::env::args_os(), &mut std::io::stdout().lock(), &mut std::io::stderr());
    ExitCode::from(code)
}
