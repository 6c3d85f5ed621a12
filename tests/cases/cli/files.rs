//! Files that never end, files that outputs must not replace, and names that are not UTF-8.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::process::Command;
use std::time::Duration;

use super::program::Workplace;

/// Longest time of a command, which ends at once or never.
const TIMEOUT: Duration = Duration::from_secs(60);

const DRIVE: &str = "drive --map mine.yaml --start 5,5 --goal 7,5";

/// The message of a command that refuses its arguments within the time.
#[track_caller]
fn refusal_in_time(place: &Workplace, arguments: &str) -> String {
    let run = place.command().args(arguments.split(' ')).timeout(TIMEOUT).output();
    let run = run.expect("the program starts");
    let message = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(2), "{arguments}: {message}");
    message
}

#[test]
fn endless_text_files_are_rejected() {
    let place = Workplace::new();
    for arguments in [
        "drive --map mine.yaml --start 5,5 --goal 7,5 --config /dev/zero",
        "drive --map mine.yaml --start 5,5 --goal 7,5 --obstacles /dev/zero",
        "evaluate --problem /dev/zero",
        "config --check /dev/zero",
        "config import-nav2 /dev/zero",
        "sweep /dev/zero --list",
        "bench draw /dev/zero --svg a.svg",
    ] {
        let message = refusal_in_time(&place, arguments);
        assert!(message.contains("bytes"), "{arguments}: {message}");
    }
}

#[test]
fn pipe_without_writer_is_no_map() {
    let place = Workplace::new();
    let made = Command::new("mkfifo").arg(place.path("mine.pgm")).status().expect("mkfifo");
    assert!(made.success());
    let yaml = fs::read_to_string(place.path("mine.yaml")).expect("the map is there");
    place.write("pipe.yaml", yaml.replace("mine.png", "mine.pgm"));
    let message = refusal_in_time(&place, "plan --map pipe.yaml --start 5,5 --goal 7,5");
    assert!(message.contains("no regular file"), "{message}");
}

#[test]
fn outputs_replace_only_own_files() {
    let place = Workplace::new();
    place.write("notes.csv", "a,b\n1,2\n");
    place.write("page/index.html", "<p>mine</p>");
    place.write("notes.svg", "<svg><!-- mine --></svg>");
    let map = fs::read(place.path("mine.yaml")).expect("the map is there");
    for output in ["--record mine.yaml", "--record mine.png", "--record notes.csv", "--report page"]
    {
        let refusal = place.refusal(&format!("{DRIVE} {output}"));
        assert!(refusal.contains("exists"), "{output}: {refusal}");
    }
    assert_eq!(fs::read(place.path("mine.yaml")).expect("still there"), map);
    let refusal = place.refusal("plan --map mine.yaml --start 5,5 --goal 7,5 --svg notes.svg");
    assert!(refusal.contains("notes.svg"), "{refusal}");
    // The same command works twice.
    for arguments in [
        format!("{DRIVE} --record run.mcap --report pages"),
        format!("{DRIVE} --record run.jsonl"),
        "plan --map mine.yaml --start 5,5 --goal 7,5 --svg plan.svg".to_owned(),
        "bench soak --missions 1 --record rows.csv".to_owned(),
        "bench soak --missions 1 --record rows.json".to_owned(),
        "bench soak --missions 1 --report soak".to_owned(),
        "bench density --min-samples 4 --max-samples 16 --seconds 0.01 --ticks 2 --missions 0 --report density"
            .to_owned(),
    ] {
        for _ in 0..2 {
            let run = place.run(&arguments);
            assert!(run.status <= 1, "{arguments}: {run:?}");
            assert!(!run.errors.iter().any(|line| line.contains("exists")), "{run:?}");
        }
    }
}

#[test]
fn results_are_printed_before_files_that_cannot_be_written() {
    let place = Workplace::with_room();
    fs::create_dir_all(place.path("full")).expect("a folder");
    symlink("/dev/full", place.path("full/index.html")).expect("a link");
    symlink("/dev/full", place.path("full.svg")).expect("a link");
    place.write("problem.json", super::evaluate::room().to_string());
    super::records::write_records(&place);
    let room = "--map room.txt --resolution 0.2 --start 1,1.5 --goal 5,1.5 --engine cpu";
    let run = place.run(&format!("drive {room} --record run.mcap"));
    assert_eq!(run.status, 0, "{run:?}");
    let plan = "plan --map room.txt --resolution 0.2 --start 1,1.5 --goal 5,1.5";
    for arguments in [plan, "evaluate --problem problem.json --engine cpu", "bench draw barn.csv"] {
        let run = place.run(&format!("{arguments} --svg full.svg"));
        assert_eq!(run.status, 2, "{arguments}: {run:?}");
        assert!(!run.stdout.is_empty(), "{arguments}: {run:?}");
    }
    // The other picture is tried, and a wrong name of one file costs none.
    place.run("bench draw barn.csv --svg full.svg --report drawn");
    assert!(place.path("drawn/index.html").is_file());
    place.write("mine/index.html", "<p>mine</p>");
    let draw = "bench draw barn.csv --svg new.svg --report mine";
    assert!(place.refusal(draw).contains("--report mine") && !place.path("new.svg").exists());
    for arguments in [
        &*format!("drive {room}"),
        "replay run.mcap --engine cpu",
        "bench soak --missions 1",
        "bench ablation --missions 1 --longest 5",
        "bench density --min-samples 4 --max-samples 16 --seconds 0.01 --ticks 2 --missions 0 --no-batches",
    ] {
        let run = place.run(&format!("{arguments} --report full"));
        assert_eq!(run.status, 2, "{arguments}: {run:?}");
        assert!(!run.stdout.is_empty(), "{arguments}: {run:?}");
        assert!(run.errors.iter().any(|line| line.contains("--report full")), "{run:?}");
    }
}

/// The runs may have taken hours.
#[test]
fn full_disk_of_one_file_does_not_prevent_the_result_and_the_other_files() {
    let place = Workplace::with_room();
    for name in ["full.csv", "full.toml"] {
        symlink("/dev/full", place.path(name)).expect("a link");
    }
    let world = |route: &str| {
        format!("kind = \"map\"\npath = \"room.txt\"\nresolution_m = 0.2\nroutes = [{route}]\n")
    };
    let there = world("{ start = [1, 1.5, 0], goal = [5, 1.5] }");
    let back = world("{ start = [5, 1.5, 3.1], goal = [1, 1.5] }");
    place.write("compare.toml", format!("[[worlds]]\n{there}"));
    let tune = "rounds = 1\ncandidates = 1\n[space]\n\"local.vx_samples\" = { from = 8, to = 9 }\n";
    place.write("tune.toml", format!("{tune}[[train]]\n{there}[[judge]]\n{back}"));
    for (arguments, files) in [
        ("bench compare compare.toml --report compared", &["compared/index.html"][..]),
        ("bench soak --missions 1 --longest 5 --report soaked", &["soaked/index.html"]),
        ("tune tune.toml --report tuned --save tuned.toml", &["tuned/index.html", "tuned.toml"]),
    ] {
        let run = place.run(&format!("{arguments} --record full.csv --json"));
        assert_eq!(run.status, 2, "{arguments}: {run:?}");
        // The result, then the error.
        let [result, error] = &run.stdout.lines().collect::<Vec<_>>()[..] else {
            panic!("{arguments}: {run:?}")
        };
        assert!(result.contains("ranked") || result.contains("summary"), "{run:?}");
        assert!(error.starts_with("{\"error\":"), "{run:?}");
        let has = |words: &str| run.errors.iter().any(|line| line.contains(words));
        assert!(has("--record full.csv: No space left on device"), "{arguments}: {run:?}");
        for file in files {
            assert!(place.path(file).exists(), "{arguments}: no {file}");
        }
    }
    // The report comes after the settings, which cannot be saved.
    let run = place.run("tune tune.toml --report other --save full.toml");
    assert_eq!(run.status, 2, "{run:?}");
    assert!(run.stdout.contains("other worlds") && place.path("other/index.html").exists());
    assert!(run.errors.iter().any(|line| line.contains("--save full.toml: No space")), "{run:?}");
}

#[test]
fn command_that_fails_keeps_the_output_of_an_earlier_one() {
    let place = Workplace::new();
    let drawing =
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"samples\"></svg>";
    place.write("fan.svg", drawing);
    place.write("problem.json", "{");
    let refusal = place.refusal("evaluate --problem problem.json --svg fan.svg");
    assert!(refusal.contains("problem.json"), "{refusal}");
    assert_eq!(fs::read_to_string(place.path("fan.svg")).expect("still there"), drawing);
}

#[cfg(feature = "png")]
#[test]
fn animation_is_written_twice() {
    let place = Workplace::new();
    place.write("other.gif", "GIF89a");
    for _ in 0..2 {
        let run = place.run(&format!("{DRIVE} --time-limit 1 --animation run.gif"));
        assert_eq!(run.status, 1, "{run:?}");
        assert!(run.errors.is_empty(), "{run:?}");
    }
    let refusal = place.refusal(&format!("{DRIVE} --animation other.gif"));
    assert!(refusal.contains("was not written by this command"), "{refusal}");
}

/// What earlier commands wrote, as far as its kind is recognised: a recording, a map and its image.
const EARLIER: [(&str, &[u8]); 3] = [
    ("run.mcap", b"\x89MCAP0\r\n, recorded by inbye"),
    ("new.yaml", b"# Map written by inbye.\nimage: new.pgm\n"),
    ("new.pgm", b"P5\n# inbye\n1 1\n255\n\xff"),
];

#[test]
fn drive_that_does_not_begin_keeps_every_file() {
    let place = Workplace::new();
    for (name, content) in EARLIER {
        place.write(name, content);
    }
    place.write("foreign/index.html", "<p>mine</p>");
    let drive = "drive --map mine.yaml --set pose_source=scans --record run.mcap --update-map new.yaml --engine cpu";
    let ends = "--start 5,5 --goal 7,5";
    for (arguments, status) in [
        // In the wall.
        ("--start 50,5 --goal 7,5".to_owned(), 2),
        ("--start 5,5 --goal 50,5".to_owned(), 2),
        (format!("{ends} --controller /nonexistent"), 2),
        (format!("{ends} --global-planner /nonexistent"), 2),
        (format!("{ends} --simulator /nonexistent"), 2),
        (format!("{ends} --animation gone/a.gif"), 2),
        (format!("{ends} --report foreign"), 2),
        (format!("{ends} --report mine.png"), 2),
        (format!("{ends} --set local.max_clearance_m=500"), 2),
    ] {
        let run = place.run(&format!("{drive} {arguments}"));
        assert_eq!(run.status, status, "{arguments}: {run:?}");
        for (name, content) in EARLIER {
            let kept = fs::read(place.path(name)).expect("still there");
            assert!(kept == content, "{arguments}: {name} has {} bytes", kept.len());
        }
    }
    // Nor does it leave empty files.
    let refusal = place.refusal(
        "drive --map mine.yaml --start 50,5 --goal 7,5 --set pose_source=scans --record a.mcap --update-map a.yaml \
         --animation a.gif",
    );
    assert!(refusal.contains("START_OCCUPIED"), "{refusal}");
    for name in ["a.mcap", "a.yaml", "a.pgm", "a.gif"] {
        assert!(!place.path(name).exists(), "{name}");
    }
}

#[test]
fn map_that_is_not_made_leaves_its_files() {
    let place = Workplace::new();
    for (name, content) in EARLIER {
        place.write(name, content);
    }
    // Two scans, between which the odometry jumps.
    let scan = |x_m: f64, time_s: u32| {
        format!("FLASER 3 1.0 2.0 1.0 {x_m} 0 0 {x_m} 0 0 {time_s} host {time_s}\n")
    };
    place.write("jump.log", scan(0.0, 1) + &scan(1e6, 2));
    for name in ["new.yaml", "other.yaml"] {
        let refusal = place.refusal(&format!("map jump.log --out {name}"));
        assert!(refusal.contains("cells"), "{refusal}");
    }
    for (name, content) in EARLIER {
        assert!(fs::read(place.path(name)).expect("still there") == content, "{name}");
    }
    // An image of another program is not replaced, and its map is not begun.
    place.write("foreign.pgm", "P5\n1 1\n255\n0");
    let refusal = place.refusal("map jump.log --out foreign.yaml");
    assert!(refusal.contains("foreign.pgm"), "{refusal}");
    for name in ["other.yaml", "other.pgm", "foreign.yaml"] {
        assert!(!place.path(name).exists(), "{name}");
    }
}

#[test]
fn two_flags_cannot_name_one_file() {
    let place = Workplace::new();
    let nav2 = "controller_server:\n  ros__parameters:\n    controller_frequency: 10.0\n";
    place.write("nav2.yaml", nav2);
    place.write("mine.toml", "# Imported from a.yaml by `inbye config import-nav2`; mine\n");
    let before = fs::read(place.path("mine.toml")).expect("the file");
    place.write("pages/notes.txt", "mine");
    for (arguments, flags) in [
        (
            "bench density --min-samples 4 --max-samples 16 --seconds 0.01 --ticks 2 --missions 0 --record a.csv \
             --record-quality ./a.csv"
                .to_owned(),
            ["--record-quality ./a.csv", "--record writes this file"],
        ),
        (
            format!("{DRIVE} --report pages --record pages/index.html"),
            ["--re", "writes this file"],
        ),
        (
            "config import-nav2 nav2.yaml --output mine.toml --base-output mine.toml".to_owned(),
            ["--base-output mine.toml", "--output writes this file"],
        ),
    ] {
        let refusal = place.refusal(&arguments);
        for flag in flags {
            assert!(refusal.contains(flag), "{arguments}: {refusal}");
        }
    }
    assert_eq!(fs::read(place.path("mine.toml")).expect("the file"), before, "it is not emptied");
}

#[test]
fn file_that_only_names_this_program_is_not_replaced() {
    let place = Workplace::new();
    for (name, text, output) in [
        (
            "notes.jsonl",
            "# Settings for inbye\n[navigator]\n",
            format!("{DRIVE} --record notes.jsonl"),
        ),
        ("rows.csv", "kind,value\n1,2\n", "bench soak --missions 1 --record rows.csv".to_owned()),
    ] {
        place.write(name, text);
        let refusal = place.refusal(&output);
        assert!(refusal.contains("was not written by this command"), "{refusal}");
        assert_eq!(fs::read_to_string(place.path(name)).expect("still there"), text);
    }
}

#[test]
fn names_that_are_not_utf8_are_written_and_read() {
    let place = Workplace::new();
    let name = OsStr::from_bytes(b"run-\xff.mcap");
    let folder = OsStr::from_bytes(b"pages-\xff");
    let mut drive = place.command();
    drive
        .args(DRIVE.split(' '))
        .arg("--json")
        .arg("--record")
        .arg(name)
        .arg("--report")
        .arg(folder);
    let run = drive.output().expect("the program starts");
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let replay = place.command().arg("replay").arg(name).output().expect("the program starts");
    assert_eq!(replay.status.code(), Some(0), "{}", String::from_utf8_lossy(&replay.stderr));
}

/// A full disk, here a limit of a file's size: what an earlier command wrote stays as it was.
#[test]
fn outputs_without_room_keep_the_earlier_content() {
    let place = Workplace::new();
    super::records::write_records(&place);
    let draw = "bench draw barn.csv --report page --svg a.svg";
    assert_eq!(place.run(draw).status, 0);
    let read = || {
        let names = ["page/index.html", "page/barn.csv", "a.svg"];
        names.map(|name| fs::read(place.path(name)).expect(name))
    };
    let entries = || fs::read_dir(place.path("page")).expect("the folder").count();
    let (before, count) = (read(), entries());
    for draw in [draw, "bench draw barn.csv --report page", "bench draw barn.csv --report new"] {
        let script =
            format!("trap '' XFSZ; ulimit -f 1; exec {} {draw}", env!("CARGO_BIN_EXE_inbye"));
        let mut shell = Command::new("bash");
        let run = shell.args(["-c", &script]).current_dir(place.path("")).output().expect("bash");
        let message = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.code() == Some(2) && message.contains("arge"), "{draw}: {run:?}");
        assert_eq!((read() == before, entries()), (true, count), "{draw}");
    }
    let left = fs::read_dir(place.path("new")).expect("the folder").count();
    assert_eq!(left, 0, "neither a part nor an empty page");
}

/// The files of a drive do not depend on its standard output.
#[test]
fn result_that_cannot_be_written_costs_no_file() {
    let place = Workplace::new();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
    let arguments =
        "drive --scene roadway --time-limit 1 --engine cpu --report page --record a.jsonl";
    let mut command = Command::new(env!("CARGO_BIN_EXE_inbye"));
    let run = command.args(arguments.split(' ')).current_dir(place.path("")).stdout(full).output();
    let run = run.expect("the program starts");
    assert_eq!(run.status.code(), Some(2), "{run:?}");
    let message = String::from_utf8_lossy(&run.stderr);
    assert_eq!(message.matches("error: standard output").count(), 1, "{message}");
    let page = fs::metadata(place.path("page/index.html")).expect("a page");
    let record = fs::metadata(place.path("a.jsonl")).expect("a recording");
    assert!(page.len() > 1000 && record.len() > 1000);
}

#[test]
fn help_that_cannot_be_written_is_an_error() {
    let place = Workplace::new();
    for arguments in ["--help", "--version", "drive --help"] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
        let mut command = Command::new(env!("CARGO_BIN_EXE_inbye"));
        let run =
            command.args(arguments.split(' ')).current_dir(place.path("")).stdout(full).output();
        let run = run.expect("the program starts");
        assert_eq!(run.status.code(), Some(2), "{arguments}: {run:?}");
        assert!(String::from_utf8_lossy(&run.stderr).contains("standard output"), "{run:?}");
    }
}
