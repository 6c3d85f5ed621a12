//! Help texts and their examples.

use super::program::Workplace;

/// An emulated base needs a pseudo-terminal.
const HAS_TERMINALS: bool = cfg!(all(unix, feature = "serial"));

/// All commands that a help text lists, the program itself first.
pub fn commands(place: &Workplace) -> Vec<String> {
    let mut known = vec![String::new()];
    let mut index = 0;
    while index < known.len() {
        let parent = known[index].clone();
        let help = place.run(&format!("{parent} --help")).stdout;
        let listed = help.split_once("Commands:\n").map_or("", |(_, list)| list);
        for line in listed.lines().take_while(|line| !line.is_empty()) {
            // A continuation of the previous line is indented further.
            let Some(rest) = line.strip_prefix("  ").filter(|rest| !rest.starts_with(' ')) else {
                continue;
            };
            let name = rest.split_whitespace().next().expect("a command has a name");
            if name != "help" {
                known.push(format!("{parent} {name}").trim_start().to_owned());
            }
        }
        index += 1;
    }
    known
}

/// The examples of a command's help, without the program's name.
fn examples(place: &Workplace, command: &str) -> Vec<String> {
    let run = place.run(&format!("{command} --help"));
    assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
    let (_, after) = run.stdout.split_once("Example:\n").expect("every help has an example");
    after
        .lines()
        .map_while(|line| line.strip_prefix("  inbye"))
        .map(|line| line.trim().to_owned())
        .collect()
}

#[test]
fn help_examples_run() {
    let place = Workplace::with_pillars();
    let help = place.run("evaluate --help").stdout;
    let (_, after) = help.split_once("problem.json:\n").expect("the file is documented");
    let (problem, _) = after.split_once("\nRows run").expect("the example ends");
    place.write("problem.json", problem);
    for map in ["mine.map", "maps/mine.map"] {
        place.write(map, "type octile\nheight 1\nwidth 3\nmap\n...\n");
        place.write(&format!("{map}.scen"), "version 1\n0 mine.map 3 1 0 0 2 0 2\n");
    }
    place.write("nav2_params.yaml", super::config::NAV2);
    // As if the import had written it: another example replaces it.
    let header = "# Imported from a.yaml by `inbye config import-nav2`; all other settings have their defaults.";
    place.write("mine.toml", format!("{header}\n[local]\nvx_samples = 8\n"));
    place.write("sweep.toml", "seeds = [0]\n[[worlds]]\nkind = \"barn\"\npath = \"barn\"\n");
    place.write("compare.toml", "[configs.inbye]\n[[worlds]]\nkind = \"barn\"\npath = \"barn\"\n");
    place.write(
        "tune.toml",
        "rounds = 1\ncandidates = 1\n[space]\n\"local.vx_samples\" = { from = 8, to = 12 }\n\
         [[train]]\nkind = \"dynabarn\"\npath = \"dynabarn\"\n[[judge]]\nkind = \"barn\"\npath = \"barn\"\n",
    );
    let log =
        "FLASER 3 1.0 1.0 1.0 0 0 0 0 0 0 1 host 1\nFLASER 3 1.0 1.0 1.0 0 0 0 0 0 0 2 host 2\n";
    place.write("drive.log", log);
    super::barn::write_worlds(&place);
    super::dynabarn::write_worlds(&place);
    super::records::write_records(&place);
    let commands = commands(&place);
    assert!(commands.len() > 20, "{commands:?}");
    let mut tried = 0;
    for command in &commands {
        let examples = examples(&place, command);
        assert!(!examples.is_empty(), "{command}");
        // The demo takes long and has its own test.
        for example in examples
            .iter()
            .filter(|example| !example.contains("run the demo"))
            .filter(|example| HAS_TERMINALS || !example.contains("base emulate"))
            // These would use the network or a serial port, or serve until they are stopped.
            .filter(|example| {
                let serves = example.starts_with("node") || example.starts_with("playground");
                !serves && !example.contains("--port")
            })
        {
            let run = place.run(example);
            assert_eq!(run.status, 0, "{example}: {run:?}");
            // The import lists parameters without an equivalent.
            let lists = example.contains("import-nav2") && !example.contains("--json");
            if !lists {
                let notes = usize::from(example.contains("--report"));
                assert_eq!(run.errors.len(), notes, "{example}: {run:?}");
            }
            tried += 1;
        }
    }
    // Not tried: the demo, node, playground, base send and base monitor.
    assert!(tried >= commands.len() - 5 - 2 * usize::from(!HAS_TERMINALS));
}

#[test]
fn help_and_version_go_to_standard_output() {
    let place = Workplace::new();
    for arguments in ["--help", "--version", "plan -h", "help drive"] {
        let run = place.run(arguments);
        assert_eq!((run.status, run.errors.len()), (0, 0), "{arguments}: {run:?}");
        assert!(run.stdout.contains("inbye"), "{arguments}: {run:?}");
    }
}
