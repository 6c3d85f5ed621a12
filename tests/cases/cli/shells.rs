//! Completions and manual pages.

use std::fs;
use std::process::Command;

use super::help;
use super::program::Workplace;

/// Bash's completions of the last of these words.
fn completions(place: &Workplace, words: &[&str]) -> Vec<String> {
    let script = place.run("completions bash").stdout;
    place.write("inbye.bash", script);
    let line = words.join("' '");
    // The variables that bash sets before it calls the function of `complete`.
    let command = format!(
        "source ./inbye.bash; COMP_WORDS=('{line}'); COMP_CWORD={last}; COMPREPLY=(); \
         _inbye inbye \"${{COMP_WORDS[{last}]}}\" \"${{COMP_WORDS[{before}]}}\"; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
        last = words.len() - 1,
        before = words.len() - 2,
    );
    let output = Command::new("bash")
        .args(["--norc", "-c", &command])
        .current_dir(place.path(""))
        .output()
        .expect("bash is installed");
    assert!(output.status.success(), "{output:?}");
    let stdout = String::from_utf8(output.stdout).expect("words are text");
    stdout.lines().map(str::to_owned).collect()
}

#[cfg(unix)]
#[test]
fn bash_completes_commands_flags_and_keywords() {
    let place = Workplace::new();
    let offered = |words: &[&str]| completions(&place, words);
    assert_eq!(offered(&["inbye", "dr"]), ["drive"]);
    assert_eq!(offered(&["inbye", "bench", "d"]), ["density", "draw", "dynabarn"]);
    assert_eq!(offered(&["inbye", "drive", "--eng"]), ["--engine"]);
    let engines = offered(&["inbye", "drive", "--engine", ""]);
    assert_eq!(engines, ["auto", "cpu", "gpu"]);
    let unknown = offered(&["inbye", "plan", "--unknown", "b"]);
    assert_eq!(unknown, ["blocked"]);
    let protocols = offered(&["inbye", "base", "emulate", "--protocol", ""]);
    assert_eq!(protocols, ["native", "wheeltec", "roboclaw", "arduino"]);
    // A file, which bash completes itself.
    assert_eq!(offered(&["inbye", "config", "--check", "mine.y"]), ["mine.yaml"]);
}

#[test]
fn completions_exist_for_every_shell() {
    let place = Workplace::new();
    for (shell, word) in [
        ("bash", "complete -F"),
        ("zsh", "#compdef inbye"),
        ("fish", "complete -c inbye"),
        ("powershell", "Register-ArgumentCompleter"),
        ("elvish", "edit:completion"),
    ] {
        let run = place.run(&format!("completions {shell}"));
        assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
        let found = run.stdout.contains(word);
        assert!(found && run.stdout.contains("require-gpu"), "{shell}");
        let refusal = place.refusal(&format!("completions {shell} --json"));
        assert!(refusal.contains("--json"), "{refusal}");
    }
    assert!(place.refusal("completions tcsh").contains("possible values: bash,"));
}

#[test]
fn manual_page_exists_for_every_command() {
    let place = Workplace::new();
    let run = place.run("man --output man1");
    assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
    let mut expected = Vec::new();
    for command in help::commands(&place) {
        let name = format!("inbye {command}").trim_end().replace([' ', '/'], "-");
        let page = fs::read_to_string(place.path(&format!("man1/{name}.1"))).expect("a page");
        // Hyphens are escaped against line breaks.
        let plain = page.replace("\\-", "-");
        assert!(plain.contains(&format!(".TH {name} 1")), "{plain}");
        assert!(plain.contains(".SH EXAMPLE\n.nf\n"), "{name}: {plain}");
        for flag in ["--json", "--quiet", "--verbose"] {
            assert!(plain.contains(flag), "{name}: {flag}");
        }
        expected.push(format!("man1/{name}.1"));
    }
    let mut written: Vec<&str> = run.stdout.lines().collect();
    written.sort_unstable();
    expected.sort_unstable();
    assert_eq!(written, expected);
    let whole = place.run("man").stdout;
    let page = fs::read_to_string(place.path("man1/inbye.1")).expect("a page");
    assert_eq!(whole.trim_end(), page.trim_end());
    // Own pages are replaced, other files are not.
    assert_eq!(place.run("man --output man1").status, 0);
    place.write("man1/inbye-plan.1", "notes");
    assert!(place.refusal("man --output man1").contains("man1/inbye-plan.1: the file exists"));
    assert_eq!(fs::read(place.path("man1/inbye-plan.1")).expect("still there"), b"notes");
    place.write("taken", "");
    assert!(place.refusal("man --output taken").contains("--output taken"));
}
