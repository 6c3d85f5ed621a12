//! Messages on standard error: `--quiet`, `--verbose` and colours.

use std::process::Command;

use super::program::Workplace;

const DRIVE: &str = "drive --map mine.yaml --start 10,5 --goal 16,5 --seed 3";

#[test]
fn quiet_prints_warnings_only_and_verbose_prints_drive_log() {
    let place = Workplace::new();
    let plain = place.run(DRIVE);
    assert!(plain.engine_note.is_some() && plain.errors.is_empty());
    let quiet = place.run(&format!("--quiet {DRIVE}"));
    assert!(quiet.engine_note.is_none() && quiet.errors.is_empty());
    let digest = |text: &str| text.lines().last().expect("a trace").to_owned();
    assert_eq!(digest(&quiet.stdout), digest(&plain.stdout));

    place.write("mine.toml", "[local]\nvx_samples = 9\n");
    let verbose = place.run(&format!("{DRIVE} -v --config mine.toml"));
    let prints = |text: &str| verbose.errors.iter().any(|line| line.contains(text));
    for text in [
        "map: mine.yaml: 400 x 240 cells of 0.25 m; all known",
        "settings: mine.toml: local.vx_samples = 9, not 20",
        "0.0 s at 10.00, 5.00: a plan of 6.",
        "0.0 s at 10.00, 5.00: driving",
        "arrived",
    ] {
        assert!(prints(text), "{text}: {verbose:?}");
    }
    // None of it is part of the result.
    let (_, object) = place.json(&format!("{DRIVE} --quiet"));
    assert_eq!(object["reached"].as_bool(), Some(true));
    assert!(place.refusal("devices --quiet --verbose").contains("cannot be used with"));
}

/// A failed recording warns also with `--quiet`.
#[cfg(target_os = "linux")]
#[test]
fn quiet_keeps_warnings_and_errors() {
    let place = Workplace::new();
    let run = place.run(&format!("{DRIVE} --quiet --record /dev/full"));
    assert_eq!(run.status, 1);
    assert_eq!(run.errors.len(), 1, "{run:?}");
    assert!(run.errors[0].starts_with("warning: "), "{run:?}");
    let refused = place.refusal("--quiet plan --map none.yaml --start 0,0 --goal 1,1");
    assert!(refused.contains("none.yaml"));
}

/// Whether a text has a terminal escape.
fn is_coloured(text: &[u8]) -> bool {
    text.contains(&0x1b)
}

#[test]
fn colours_appear_on_terminals_only() {
    let place = Workplace::new();
    let refused = ["plan", "--map", "none.yaml", "--start", "0,0"];
    let program = || {
        let mut command = place.command();
        command.args(refused).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
        command
    };
    let piped = program().output().expect("the program starts");
    assert!(!is_coloured(&piped.stderr), "{piped:?}");
    let forced = program().env("CLICOLOR_FORCE", "1").output();
    assert!(is_coloured(&forced.expect("the program starts").stderr));

    // `script` gives a program a terminal.
    if !cfg!(target_os = "linux") {
        return;
    }
    let on_terminal = |no_color: &str| {
        let line = format!("'{}' {}", env!("CARGO_BIN_EXE_inbye"), refused.join(" "));
        let output = Command::new("script")
            .args(["--quiet", "--return", "--command", &line, "/dev/null"])
            .current_dir(place.path(""))
            .env("TERM", "xterm")
            .env("NO_COLOR", no_color)
            .output()
            .expect("script is installed");
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        output.stdout
    };
    assert!(is_coloured(&on_terminal("")));
    assert!(!is_coloured(&on_terminal("1")));
}
