//! A folder with a plan and its worlds, in which the program runs.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

/// The program.
pub const INBYE: &str = env!("CARGO_BIN_EXE_inbye");

/// Two worlds with a post each, two samplings, two sets of weights, three seeds.
pub const PLAN: &str = "title = \"posts\"\nseeds = [0, 1, 2]\nsampling = [\"8x16\", \"16x32\"]\n\
    [weights.paper]\n[weights.fast]\nvelocity = 0.4\n\
    [[worlds]]\nkind = \"barn\"\npath = \"barn\"\n";
/// Number of cells of [`PLAN`].
pub const CELLS: usize = 2 * 2 * 2 * 3;

const LIST: &str = "world,official50,path_length_m,optimal_time_s,dwa_success,dwa_collision,dwa_timeout,dwa_metric\n\
    3,1,10.0,5.0,0.90,0.10,0.00,0.1500\n\
    12,0,10.0,5.0,,,,\n";
const THREE: &str = "x_m,y_m,radius_m,kind\n-1.5,6.0,0.075,obstacle\n";
const TWELVE: &str = "x_m,y_m,radius_m,kind\n-2.25,6.0,0.075,obstacle\n-1.0,8.0,0.075,obstacle\n";

/// A folder that is deleted on drop.
pub struct PlanFolder(TempDir);

/// The folder in which one process ran all cells in sequence and merged them into `expected`.
fn by_one_process() -> &'static PlanFolder {
    static PLACE: OnceLock<PlanFolder> = OnceLock::new();
    PLACE.get_or_init(|| {
        let place = PlanFolder::new();
        place.json("sweep plan.toml --out one --jobs 1");
        place.json("sweep merge one --report expected");
        place
    })
}

/// Exit status and output of the program.
#[derive(Debug)]
pub struct Ran {
    pub status: i32,
    pub stdout: String,
    pub stderr: String,
}

impl PlanFolder {
    /// Creates a folder with the plan as `plan.toml`.
    pub fn new() -> Self {
        let place = Self(tempfile::tempdir().expect("a place for temporary files"));
        for (name, text) in [
            ("plan.toml", PLAN),
            ("barn/worlds.csv", LIST),
            ("barn/worlds/world_003.csv", THREE),
            ("barn/worlds/world_012.csv", TWELVE),
        ] {
            place.write(name, text);
        }
        fs::create_dir(place.path("tmp")).expect("the folder can be written to");
        place
    }

    /// Creates the same with the results of all cells in `out`, from one process.
    pub fn done() -> Self {
        let (place, one) = (Self::new(), by_one_process());
        for key in one.finished("one") {
            let cell = one.read(&format!("one/cells/{key}.json"));
            place.write(&format!("out/cells/{key}.json"), cell);
        }
        place.write("out/sweep.json", one.read("one/sweep.json"));
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

    pub fn read(&self, name: &str) -> Vec<u8> {
        let path = self.path(name);
        fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    /// Returns a command that runs a program here. It counts as a machine of its own, because its locks are in its own
    /// folder for temporary files.
    pub fn command(&self, program: impl AsRef<Path>) -> Command {
        let mut command = Command::new(program.as_ref());
        command
            .current_dir(self.0.path())
            .env("TMPDIR", self.path("tmp"))
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("VK_ICD_FILENAMES", "/nonexistent")
            .stdin(Stdio::null());
        command
    }

    pub fn inbye(&self, arguments: &str) -> Command {
        let mut command = self.command(INBYE);
        command.args(arguments.split_whitespace());
        command
    }

    pub fn run(&self, arguments: &str) -> Ran {
        let output = self.inbye(arguments).output().expect("the program starts");
        let text = |bytes| String::from_utf8(bytes).expect("it prints text");
        Ran {
            status: output.status.code().expect("it ends by itself"),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    pub fn start(&self, arguments: &str) -> Child {
        let mut command = self.inbye(arguments);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().expect("the program starts")
    }

    /// Runs a command that must succeed, with `--json`; returns its object.
    #[track_caller]
    pub fn json(&self, arguments: &str) -> Value {
        let ran = self.run(&format!("{arguments} --json"));
        assert_eq!(ran.status, 0, "{arguments}: {ran:?}");
        serde_json::from_str(&ran.stdout).expect("standard output is JSON")
    }

    /// Runs a command that must be rejected; returns its line of output.
    #[track_caller]
    pub fn refusal(&self, arguments: &str) -> String {
        let ran = self.run(arguments);
        assert_eq!((ran.status, ran.stdout.as_str()), (2, ""), "{arguments}: {ran:?}");
        assert_eq!(ran.stderr.lines().count(), 1, "{ran:?}");
        ran.stderr
    }

    /// Returns the keys of the cells with a file in a folder of results.
    pub fn finished(&self, out: &str) -> Vec<String> {
        let Ok(entries) = fs::read_dir(self.path(out).join("cells")) else {
            return Vec::new();
        };
        let names = entries.map(|entry| {
            let name = entry.expect("an entry of that folder").file_name();
            name.to_string_lossy().into_owned()
        });
        names.filter_map(|name| name.strip_suffix(".json").map(str::to_owned)).collect()
    }

    /// Returns the lines of a folder's log.
    pub fn log(&self, out: &str) -> Vec<Value> {
        let log = fs::read_to_string(self.path(out).join("log.jsonl")).unwrap_or_default();
        // A kill may have cut the last line short.
        log.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
    }

    /// Returns the number of starts of each cell.
    pub fn begun(&self, out: &str) -> BTreeMap<String, usize> {
        let mut begun = BTreeMap::new();
        for line in self.log(out).iter().filter(|line| line["event"] == "begun") {
            let key = line["key"].as_str().expect("a key").to_owned();
            *begun.entry(key).or_default() += 1;
        }
        begun
    }

    /// Merges folders; checks that table and report equal those of one process, byte for byte.
    #[track_caller]
    pub fn assert_same_table(&self, folders: &str) {
        let merged = self.json(&format!("sweep merge {folders} --report merged"));
        assert_eq!(merged["missing"], serde_json::json!([]), "{merged}");
        for file in [
            "sweep.csv",
            #[cfg(feature = "parquet")]
            "sweep.parquet",
            "index.html",
            "groups-barn.csv",
        ] {
            let (ours, theirs) = (
                self.read(&format!("merged/{file}")),
                by_one_process().read(&format!("expected/{file}")),
            );
            assert!(ours == theirs, "{folders}: {file} differs");
        }
        let lines = String::from_utf8(self.read("merged/sweep.csv")).expect("text");
        assert_eq!(lines.lines().count(), 1 + CELLS, "{lines}");
    }
}
