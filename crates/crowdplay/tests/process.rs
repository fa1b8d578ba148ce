//! The program as a process: what only a process has, such as an environment without a display.

use std::process::Command;

fn crowdplay() -> Command {
    Command::new(env!("CARGO_BIN_EXE_crowdplay"))
}

#[test]
#[cfg(all(unix, not(target_os = "macos")))]
fn without_a_display_the_error_names_the_way_out() {
    let mut command = crowdplay();
    command.arg("any.crowdpack");
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(variable);
    }
    let output = command.output().expect("the program was built beside this test");
    let talk = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(5), "{talk}");
    assert!(talk.contains("no display") && talk.contains("--headless"), "{talk}");
    assert!(output.stdout.is_empty());
}

#[test]
fn exit_codes_reach_the_shell() {
    let code = |words: &[&str]| crowdplay().args(words).output().expect("the program was built").status.code();
    assert_eq!(code(&["--help"]), Some(0));
    assert_eq!(code(&["--count", "0", "x.crowdpack"]), Some(2));
    assert_eq!(code(&["no-such-file.crowdpack", "--headless"]), Some(1));
}
