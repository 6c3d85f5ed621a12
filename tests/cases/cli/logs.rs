//! `inbye map` and `inbye bench localization --log`.

use core::fmt::Write as _;

use super::program::Workplace;

/// Half the sides of a room with its origin in the middle, metres, and the radius of the robot's circle in it.
const HALF_ROOM_M: (f64, f64) = (4.0, 3.0);
pub const CIRCLE_M: f64 = 1.5;
/// Scans of two rounds, and beams of a scan, one degree apart.
const SCANS: u32 = 160;
const BEAMS: i32 = 181;

/// A CARMEN log of a drive in a circle. Its laser poses are the true ones. The wheels measure `scale` times the distance.
fn drive_log(scale: f64) -> String {
    let mut log = String::from("PARAM robot_frontlaser_offset 0.0\n");
    let (mut x, mut y, mut yaw) = (CIRCLE_M, 0.0, core::f64::consts::FRAC_PI_2);
    let step_rad = 2.0 * core::f64::consts::TAU / f64::from(SCANS);
    for index in 0..SCANS {
        let around = step_rad * f64::from(index);
        let (sin, cos) = libm::sincos(around);
        let (true_x, true_y) = (CIRCLE_M * cos, CIRCLE_M * sin);
        let true_yaw = around + core::f64::consts::FRAC_PI_2;
        let _ = write!(log, "FLASER {BEAMS}");
        for beam in 0..BEAMS {
            let angle = true_yaw + f64::from(beam - 90).to_radians();
            let _ = write!(log, " {:.4}", range_m((true_x, true_y), angle));
        }
        let time_s = 0.5 * f64::from(index + 1);
        let yaw_of_log = libm::remainder(true_yaw, core::f64::consts::TAU);
        let _ =
            writeln!(log, " {true_x} {true_y} {yaw_of_log} {x} {y} {yaw} {time_s} host {time_s}");
        // The wheels' own circle.
        let chord = scale * 2.0 * CIRCLE_M * libm::sin(0.5 * step_rad);
        let (sin, cos) = libm::sincos(yaw + 0.5 * step_rad);
        (x, y) = (x + chord * cos, y + chord * sin);
        yaw = libm::remainder(yaw + step_rad, core::f64::consts::TAU);
    }
    log
}

/// Distance to the wall of the room.
pub fn range_m((x, y): (f64, f64), angle: f64) -> f64 {
    let (sin, cos) = libm::sincos(angle);
    let along = |direction: f64, position: f64, half_m: f64| {
        if direction.abs() < 1e-12 {
            f64::INFINITY
        } else {
            (half_m.copysign(direction) - position) / direction
        }
    };
    along(cos, x, HALF_ROOM_M.0).min(along(sin, y, HALF_ROOM_M.1))
}

#[test]
fn map_of_a_log_is_read_by_plan_and_by_localization() {
    let place = Workplace::new();
    place.write("drive.log", drive_log(1.02));
    let (status, object) = place.json("map drive.log --out room.yaml");
    assert_eq!(status, 0, "{object}");
    assert_eq!((&object["scans"], &object["unmatched"]), (&SCANS.into(), &0.into()), "{object}");
    let mean_m = object["absolute"]["position_m"]["mean"].as_f64().expect("a mean");
    assert!(mean_m < 0.03, "{object}");
    let plan = place.run("plan --map room.yaml --start 1.5,0 --goal -1.5,0");
    assert_eq!(plan.status, 0, "{:?}", plan.errors);
    let (again, _) = place.json("map drive.log --out again.yaml");
    assert_eq!(again, 0);
    let image = |name: &str| std::fs::read(place.path(name)).expect("an image");
    assert!(image("room.pgm") == image("again.pgm"), "the same log gives the same map");
    for map in ["", "--map room.yaml "] {
        let (status, object) = place.json(&format!("bench localization --log drive.log {map}"));
        assert_eq!((status, &object["lost_scans"]), (0, &0.into()), "{object}");
        let mean_m = object["absolute"]["position_m"]["mean"].as_f64().expect("a mean");
        assert!(mean_m < 0.03, "{object}");
    }
}

/// Of the scans of another room, few are compared.
#[test]
fn localization_says_how_many_scans_it_compared() {
    let place = Workplace::new();
    place.write("drive.log", drive_log(1.02));
    place.write("free.txt", "..........\n".repeat(10));
    let (_, object) = place.json("bench localization --log drive.log");
    assert_eq!(object["absolute"]["poses"], SCANS, "{object}");
    assert_eq!(object["relative"]["motions"], SCANS - 1, "{object}");
    let text = place.run("bench localization --log drive.log").stdout;
    assert!(text.contains(&format!(", over {SCANS} of the scans")), "{text}");
    let other = "bench localization --log drive.log --map free.txt --start 5,5";
    let (status, object) = place.json(other);
    let lost = object["lost_scans"].as_u64().expect("a number");
    assert!(status == 1 && lost > 0, "{object}");
    let compared = object["absolute"]["poses"].as_u64().unwrap_or(0);
    assert_eq!(compared + lost, u64::from(SCANS), "{object}");
}

#[test]
fn perception_over_a_log_of_an_empty_room_finds_nothing_that_moves() {
    let place = Workplace::new();
    place.write("drive.log", drive_log(1.0));
    let (status, object) = place.json("bench perception drive.log");
    assert_eq!((status, &object["scans"]), (0, &SCANS.into()), "{object}");
    for map in ["unknown", "mapped"] {
        assert_eq!(object[map]["moving"], 0, "{object}");
    }
    let text = place.run("bench perception drive.log");
    assert!(text.stdout.contains("obstacles that moved: 0"), "{}", text.stdout);
}

/// Scans that never fit together: the map is made, but it is worth no more than the odometry.
#[test]
fn log_with_mostly_unmatched_scans_is_warned_of() {
    let place = Workplace::new();
    // Each scan has one short wall, at another place.
    let scan = |index: u32| {
        let range_m = if index.is_multiple_of(2) { 2 } else { 15 };
        let x_m = 0.3 * f64::from(index);
        format!("FLASER 3 {range_m} {range_m} {range_m} {x_m} 0 0 {x_m} 0 0 {index} host {index}\n")
    };
    place.write("drive.log", (0..20).map(scan).collect::<String>());
    let run = place.run("map drive.log --out room.yaml");
    assert_eq!(run.status, 0, "{run:?}");
    let warning = run.errors.iter().find(|line| line.starts_with("warning: drive.log: "));
    assert!(warning.is_some_and(|line| line.contains("of 20 scans do not match")), "{run:?}");
}

#[test]
fn relations_that_are_compared_with_nothing_are_warned_of() {
    let place = Workplace::new();
    place.write("drive.log", drive_log(1.02));
    place.write("far.rel", "1e9 2e9 0 0 0 0 0 0\n");
    place.write("empty.rel", "");
    for command in ["map drive.log --out room.yaml", "bench localization --log drive.log"] {
        for (file, why) in [("far.rel", "check --time-offset"), ("empty.rel", "holds no relation")]
        {
            let run = place.run(&format!("{command} --relations {file}"));
            assert_eq!(run.status, 0, "{run:?}");
            let begin = format!("warning: --relations {file}: nothing is compared: ");
            let warning = run.errors.iter().find(|line| line.starts_with(&begin));
            assert!(warning.is_some_and(|line| line.contains(why)), "{run:?}");
        }
    }
}

/// Most scans show a room of half the size; the last ones show the map.
#[test]
fn localization_that_is_mostly_lost_fails() {
    let place = Workplace::new();
    let log = drive_log(1.0);
    place.write("drive.log", &log);
    assert_eq!(place.run("map drive.log --out room.yaml").status, 0);
    let halved = |(index, line): (usize, &str)| {
        let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        let is_halved = (2..130).contains(&index);
        for word in words.iter_mut().skip(2).take(181).filter(|_| is_halved) {
            let range_m: f64 = word.parse().expect("a number");
            *word = (0.5 * range_m).to_string();
        }
        words.join(" ") + "\n"
    };
    place.write("odd.log", log.lines().enumerate().map(halved).collect::<String>());
    let (status, object) = place.json("bench localization --log odd.log --map room.yaml");
    let lost = object["lost_scans"].as_u64().expect("a number");
    assert!(lost > u64::from(SCANS) / 2 && object["is_lost_at_end"] == false, "{object}");
    assert_eq!(status, 1, "{object}");
}

/// The map is right in spite of it.
#[test]
fn jump_of_the_odometry_is_warned_of() {
    let place = Workplace::new();
    let log = drive_log(1.0);
    let far = |(index, line): (usize, &str)| {
        let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        if index > 80 {
            let x_m: f64 = words[186].parse().expect("a number");
            words[186] = (x_m + 20.0).to_string();
        }
        words.join(" ") + "\n"
    };
    place.write("jump.log", log.lines().enumerate().map(far).collect::<String>());
    let run = place.run("map jump.log --out room.yaml --json");
    let object: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!((&object["odometry_jumps"], &object["gaps"]), (&1.into(), &0.into()), "{object}");
    let warning = run.errors.iter().find(|line| line.starts_with("warning: jump.log: "));
    let expected = "rad, at 40.500 s; the scan matches another place";
    assert!(warning.is_some_and(|line| line.contains(expected)), "{run:?}");
    let run = place.run("bench localization --log jump.log --map room.yaml");
    assert!(run.errors.iter().any(|line| line.contains("the odometry jumps by 2")), "{run:?}");
}

#[test]
fn cut_last_line_is_warned_of() {
    let place = Workplace::new();
    let log = drive_log(1.0);
    place.write("cut.log", &log[..log.len() - 200]);
    let run = place.run("map cut.log --out room.yaml");
    let cut = "warning: cut.log: line 161 was cut off and is left out";
    assert!(run.status == 0 && run.errors.iter().any(|line| line.starts_with(cut)), "{run:?}");
}

#[test]
fn start_of_a_log_outside_the_map_is_refused() {
    let place = Workplace::new();
    place.write("drive.log", drive_log(1.0));
    assert_eq!(place.run("map drive.log --out room.yaml").status, 0);
    let localize = "bench localization --log drive.log";
    let refusal = place.refusal(&format!("{localize} --map room.yaml --start 500,500"));
    assert!(refusal.contains("--start 500,500: lies outside the map room.yaml"), "{refusal}");
    // It ends at 1.2, 1.2, and the log begins at 1.5, 0.
    place.write("small.txt", "...\n...\n...\n");
    let refusal = place.refusal(&format!("{localize} --map small.txt --resolution 0.4"));
    assert!(refusal.contains("small.txt: the log's first pose"), "{refusal}");
}

#[test]
fn duration_of_a_log_whose_stamps_run_backwards_is_not_negative() {
    let place = Workplace::new();
    let log = drive_log(1.02);
    let mut lines: Vec<String> = log.lines().map(str::to_owned).collect();
    for line in &mut lines {
        let Some(at) = line.find(" host ") else { continue };
        let from = line[..at].rfind(' ').expect("a scan has fields");
        line.insert(from + 1, '-');
    }
    place.write("drive.log", lines.join("\n") + "\n");
    let (_, object) = place.json("bench localization --log drive.log");
    assert_eq!(object["duration_s"], 0.5 * f64::from(SCANS - 1), "{object}");
}

#[test]
fn unusable_logs_are_refused() {
    let place = Workplace::new();
    place.write("bad.log", drive_log(1.0).replacen(" 1.5 0 ", " 1.5 nought ", 1));
    place.write("empty.log", "");
    place.write("drive.log", drive_log(1.0));
    place.write("gzip.log", b"\x1f\x8b\x08\x00");
    place.write("millimetres.log", "FLASER 3 1000 2000 1000 0 0 0 0 0 0 1 host 1\n");
    let scan = |x_m: u32| format!("FLASER 1 3 {x_m} 0 0 {x_m} 0 0 {x_m} host {x_m}\n");
    place.write("jump.log", scan(0) + &scan(9000));
    for (command, expected) in [
        ("map millimetres.log --out room.yaml", "millimetres.log: no reading within 25 m: "),
        ("bench perception millimetres.log", "millimetres.log: no reading within 25 m: "),
        ("map jump.log --out room.yaml", "jump.log: its map has 180"),
        ("map jump.log --out room.yaml", "up to 9000.0 m, at 9000.000 s"),
        ("map bad.log --out room.yaml", "bad.log: line 2: FLASER has `nought`"),
        ("map empty.log --out room.yaml", "empty.log"),
        ("map gzip.log --out room.yaml", "gzip.log: it is compressed: decompress it with `gunzip`"),
        ("bench localization --log millimetres.log", "millimetres.log: no reading within 25 m: "),
        ("map drive.log --out room.png", "must end in .yaml"),
        ("bench localization --log none.log", "none.log"),
        ("bench perception none.log", "none.log"),
        ("bench localization --relations none.txt", "--relations belongs to --log"),
        ("bench localization --map room.yaml", "--start"),
    ] {
        let refusal = place.refusal(command);
        assert!(refusal.contains(expected), "{command}: {refusal}");
    }
}
