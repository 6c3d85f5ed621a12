//! Runs the program in a temporary folder with a map.

use std::fs;
use std::path::PathBuf;

use crate::support::room;
use assert_cmd::Command;
use image::{GrayImage, Luma};
use serde_json::Value;
use tempfile::TempDir;

/// `mine.yaml`: a room of 100 by 60 m, divided by a wall with a 10 m gap at its upper end.
const MINE_YAML: &str = "image: mine.png\nresolution: 0.25\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n\
    occupied_thresh: 0.65\nfree_thresh: 0.196\n";

/// Begin of the notes that name written files.
const FILE_NOTES: [&str; 10] = [
    "animation: ",
    "base-output: ",
    "chart: ",
    "output: ",
    "png: ",
    "record: ",
    "record-missions: ",
    "record-quality: ",
    "save: ",
    "svg: ",
];

/// A temporary folder with a map; removed when dropped.
pub struct Workplace(TempDir);

/// The result of a run.
#[derive(Debug)]
pub struct Run {
    pub status: i32,
    pub stdout: String,
    /// Standard error without the notes that name the engine and written files.
    pub errors: Vec<String>,
    /// The note that names the engine.
    pub engine_note: Option<String>,
}

impl Workplace {
    pub fn new() -> Self {
        let place = Self(tempfile::tempdir().expect("a place for temporary files"));
        place.write("mine.yaml", MINE_YAML);
        let wall = |x: u32, y: u32| {
            let border = x == 0 || y == 0 || x == 399 || y == 239;
            border || ((198..202).contains(&x) && y >= 40)
        };
        let image = GrayImage::from_fn(400, 240, |x, y| Luma([if wall(x, y) { 0 } else { 254 }]));
        image.save(place.path("mine.png")).expect("the folder can be written to");
        place
    }

    /// A workplace whose room has pillars of 0.5 m, 6 m apart: its lidar sees some of them everywhere. The protective layer
    /// cannot tell an open hall from blindness.
    pub fn with_pillars() -> Self {
        let place = Self::new();
        let mine = place.path("mine.png");
        let mut image = image::open(&mine).expect("the map is there").into_luma8();
        for (x, y, pixel) in image.enumerate_pixels_mut() {
            if x % 24 / 2 == 6 && y % 24 / 2 == 6 {
                *pixel = Luma([0]);
            }
        }
        image.save(mine).expect("the folder can be written to");
        place
    }

    /// A workplace with `room.txt`, cells of 0.2 m: a room of 6 by 3 m without obstacles.
    pub fn with_room() -> Self {
        let place = Self::new();
        place.write("room.txt", room::rows(30, 15, &[]).join("\n"));
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a file is in a folder")).expect("as below");
        fs::write(path, bytes).expect("the folder can be written to");
    }

    /// The program in this folder, without graphics adapters.
    pub fn command(&self) -> Command {
        let mut command = Command::cargo_bin("inbye").expect("cargo builds the program first");
        command
            .current_dir(self.0.path())
            .env("XDG_RUNTIME_DIR", self.0.path())
            .env("XDG_CACHE_HOME", self.0.path())
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("VK_ICD_FILENAMES", "/nonexistent");
        command
    }

    /// Runs the program with arguments separated by spaces.
    pub fn run(&self, arguments: &str) -> Run {
        self.run_words(&arguments.split_whitespace().collect::<Vec<_>>())
    }

    /// Runs the program with these arguments.
    pub fn run_words(&self, arguments: &[&str]) -> Run {
        let output = self.command().args(arguments).output().expect("the program starts");
        let stderr = String::from_utf8(output.stderr).expect("messages are text");
        let names_a_file = |line: &&str| FILE_NOTES.iter().any(|note| line.starts_with(note));
        let (notes, errors): (Vec<String>, Vec<String>) = stderr
            .lines()
            .filter(|line| !names_a_file(line))
            .map(str::to_owned)
            .partition(|line| line.starts_with("engine: "));
        assert!(notes.len() <= 1, "the engine is named once: {notes:?}");
        Run {
            status: output.status.code().expect("the program ends by itself"),
            stdout: String::from_utf8(output.stdout).expect("results are text"),
            errors,
            engine_note: notes.into_iter().next(),
        }
    }

    /// Starts the program, and interrupts its process group once a file exists, as Ctrl-C in a terminal does. Returns the exit
    /// status and both outputs.
    #[cfg(unix)]
    pub fn interrupted(&self, arguments: &str, once: &str) -> (i32, String, String) {
        use std::os::unix::process::CommandExt;
        use std::process::{Command, Stdio};
        use std::thread::sleep;
        use std::time::Duration;

        let mut child = Command::new(self.command().get_program())
            .args(arguments.split_whitespace())
            .current_dir(self.0.path())
            .env("VK_DRIVER_FILES", "/nonexistent")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0)
            .spawn()
            .expect("the program starts");
        while !self.path(once).exists() {
            sleep(Duration::from_millis(5));
            assert!(child.try_wait().expect("a child").is_none(), "it ended before {once} exists");
        }
        // Some ticks, on a busy machine too.
        sleep(Duration::from_millis(800));
        let group = format!("-{}", child.id());
        let kill = Command::new("kill").args(["-INT", "--", &group]).status();
        assert!(kill.expect("a shell's kill").success());
        let output = child.wait_with_output().expect("the program ends");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
        (output.status.code().expect("it ends by itself"), text(output.stdout), text(output.stderr))
    }

    /// Runs the program with `--json`; returns the exit status and the object.
    #[track_caller]
    pub fn json(&self, arguments: &str) -> (i32, Value) {
        let run = self.run(&format!("{arguments} --json"));
        assert!(run.errors.is_empty(), "{run:?}");
        assert_eq!(run.stdout.lines().count(), 1, "{run:?}");
        let object: Value = serde_json::from_str(&run.stdout).expect("standard output is JSON");
        assert!(object.is_object(), "{run:?}");
        (run.status, object)
    }

    /// Runs the program on unusable input and returns its error: no result, one line, exit status 2.
    #[track_caller]
    pub fn refusal(&self, arguments: &str) -> String {
        let mut run = self.run(arguments);
        assert_eq!(run.status, 2, "{arguments}: {run:?}");
        let has_result = !run.stdout.starts_with("{\"error\":") && !run.stdout.is_empty();
        assert!(!has_result, "{arguments}: {run:?}");
        assert_eq!(run.errors.len(), 1, "{arguments}: {run:?}");
        let line = run.errors.remove(0);
        assert!(line.starts_with("error: "), "{arguments}: {line}");
        assert!(!line.contains("panicked"), "{arguments}: {line}");
        line
    }
}

/// Checks the type of every field: `name type` or `outer.inner type`, separated by commas; `name[]` is the first entry of a
/// list.
#[track_caller]
pub fn assert_fields(object: &Value, fields: &str) {
    for field in fields.split(',') {
        let (path, expected) = field.trim().split_once(' ').expect("a field has a type");
        let value = path.split('.').fold(object, |value, name| match name.strip_suffix("[]") {
            Some(list) => &value[list][0],
            None => &value[name],
        });
        let found = match value {
            Value::Null => "null",
            Value::Bool(_) => "bool",
            Value::Number(number) if number.is_f64() => "real",
            Value::Number(_) => "whole",
            Value::String(_) => "text",
            Value::Array(_) => "list",
            Value::Object(_) => "object",
        };
        assert_eq!(found, expected, "{path} in {object}");
    }
}
