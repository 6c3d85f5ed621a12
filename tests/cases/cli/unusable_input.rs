//! Unusable input: one line with the file or flag, the place and the cure; exit status 2.

use std::fs;

use super::program::Workplace;
use super::unusable_problems::problem;
use crate::support::room;

/// A folder with unusable files of every kind.
pub(super) fn place() -> Workplace {
    let place = Workplace::new();
    let yaml = fs::read_to_string(place.path("mine.yaml")).expect("the map is there");
    let png = fs::read(place.path("mine.png")).expect("its image is there");
    place.write("cut.png", &png[..png.len() / 2]);
    for (name, from, to) in [
        ("no_image.yaml", "image: mine.png", "image: gone.png"),
        ("cut.yaml", "image: mine.png", "image: cut.png"),
        ("wrong_key.yaml", "resolution", "resolutoin"),
        ("origin.yaml", "[0.0, 0.0, 0.0]", "[0.0, 0.0]"),
        ("zero.yaml", "resolution: 0.25", "resolution: 0"),
        ("nan.yaml", "resolution: 0.25", "resolution: .nan"),
    ] {
        place.write(name, yaml.replace(from, to));
    }
    place.write("solid.txt", "####\n####\n####\n");
    place.write("binary.toml", b"\xff\xfe");
    place.write("list.json", r#"{"x": 1}"#);
    place.write("radius.json", r#"[{"x": 1.0, "y": 1.0, "radius": 0.0, "speed": 1.0}]"#);
    let first = "[[obstacles]]\nx = 1.0\ny = 1.0\nradius = 0.3\nspeed = 1.0\n";
    place.write(
        "radius.toml",
        format!("{first}[[obstacles]]\nx = 1.0\nradius = -1.0\ny = 1.0\nspeed = 1.0\n"),
    );
    place.write("away.json", r#"[{"x": -9.0, "y": 1.0, "radius": 0.3, "speed": 1.0}]"#);
    place.write("key.toml", "[[obstacles]]\nx = 1.0\ny = 1.0\nradius = 0.3\nsped = 1.0\n");
    place
}

/// Runs each line of a table, `ARGUMENTS -> WORD; WORD`, and checks that the error contains the words.
#[track_caller]
fn assert_table(place: &Workplace, prefix: &str, table: &str) {
    for line in table.lines().filter(|line| !line.is_empty()) {
        let (arguments, words) = line.split_once(" -> ").expect("a line has an arrow");
        let refusal = place.refusal(&format!("{prefix} {arguments}"));
        for word in words.split("; ") {
            assert!(refusal.contains(word), "{arguments}: no {word:?} in: {refusal}");
        }
    }
}

#[test]
fn unusable_maps_are_rejected() {
    let table = "
--map gone.yaml -> gone.yaml; cannot be read; check the path
--map . -> cannot be read
--map mine.png -> mine.png; YAML
--map no_image.yaml -> no_image.yaml: line 1; gone.png; check the path
--map cut.yaml -> cut.yaml: line 1; cut.png; export it again
--map wrong_key.yaml -> wrong_key.yaml: line 2; `resolutoin`; `resolution`
--map origin.yaml -> origin.yaml: line 3; `origin`
--map zero.yaml -> zero.yaml: line 2; `resolution`; above zero
--map nan.yaml -> nan.yaml: line 2; `resolution`; finite
--map solid.txt -> solid.txt; START_O
";
    let place = place();
    for command in ["plan", "drive"] {
        assert_table(&place, &format!("{command} --start 10,5 --goal 80,40"), table);
    }
    let refusal = place.refusal("plan --map solid.txt --start 1,1 --goal 2,2");
    assert!(refusal.contains("START_OCCUPIED") && refusal.contains("no free cell"), "{refusal}");
}

#[test]
fn start_and_goal_outside_map_or_in_obstacle_are_rejected() {
    let table = "
--start -1,5 --goal 80,40 -> mine.yaml: START_OUTSIDE_MAP; (100.00, 60.00)
--start 10,5 --goal 1e9,5 -> mine.yaml: GOAL_OUTSIDE_MAP; nearest free point is (; , 5.
--start 10,5 --goal 80,4000 -> mine.yaml: GOAL_OUTSIDE_MAP; (100.00, 60.00)
--start 50,5 --goal 80,40 -> mine.yaml: START_OCCUPIED; in an obstacle; nearest free point
--start 10,5 --goal 50,40 -> mine.yaml: GOAL_OCCUPIED; in an obstacle; nearest free point
--start 10,5 --goal 50.7,40 -> mine.yaml: GOAL_OCCUPIED; m from an obstacle; nearest free point
";
    let place = place();
    for command in ["plan", "drive", "drive --obstacles 1"] {
        assert_table(&place, &format!("{command} --map mine.yaml"), table);
    }
    place.write("cabin.txt", room::rows(13, 13, &[]).join("\n"));
    let crowded =
        "drive --map cabin.txt --resolution 0.2 --start 1.3,1.3 --goal 1.3,1.4 --obstacles 9";
    assert!(place.refusal(crowded).contains("of 9 moving obstacles"));
    // A start may be nearer to a wall than a path, so that the distance of paths is not the criterion.
    place.write("hall.txt", room::rows(60, 60, &[]).join("\n"));
    let hall = "plan --map hall.txt --resolution 0.1 --goal 4,4 --start";
    let refusal = place.refusal(&format!("{hall} 0.25,3"));
    assert!(
        refusal.contains("m from an obstacle or the edge of the map, too near for the robot"),
        "{refusal}"
    );
    let far = "plan --map mine.yaml --start 10,5 --goal 80,40 --radius 90";
    assert!(place.refusal(far).contains("smaller radius"));
}

#[test]
fn unusable_flags_are_rejected() {
    let place = place();
    let table = "
--start 1,nan -> --start; write X,Y
--start 1,2,3,4 -> --start; write X,Y
--start 1,,2 -> --start; write X,Y
--start 1e300,1 -> --start; write X,Y
--start one,two -> --start; write X,Y
--goal inf,1 -> --goal; write X,Y
--start 1,1 -> --goal; --help
--gaol 1,1 -> --gaol; --goal
--resolution 0 -> --resolution; above zero
--resolution nan -> --resolution; above zero
--resolution -1 -> --resolution; above zero
--unknown maybe -> --unknown; blocked; free
--resolution 0.1 --start 10,5 --goal 80,40 -> --resolution 0.1: mine.yaml states its own resolution: leave the flag out
--radius nan -> --radius; 0 to
--radius -2 -> --radius; 0 to
";
    assert_table(&place, "plan --map mine.yaml", table);
    let table = "
--resolution 0.25 --truth mine.yaml -> --resolution 0.25: mine.yaml states its own
--engine nonsense -> --engine; auto, cpu, gpu
--real-time-factor 0 -> --real-time-factor; a number: 0.01 to 1000
--set local.sim_step_s=5 -> --set local.sim_step_s=5: [local] sim_step_s is 5; at most sim_time_s
--set local.max_clearance_m=500 -> [local] max_clearance_m is 500; at most 11
--set local.max_clearance_m=11 -> mine.yaml: with these settings; the sum of max_clearance_m of [local]; at most
--set robot.limits.max_vel_x=0 -> --set robot.limits.max_vel_x=0: [robot.limits] max_vel_x is 0; above zero
--set controller.command=[''] -> --set controller.command; [controller] length of the program
--set simulator.command=['','x'] -> --set simulator.command; [simulator] length of the program
--controller '' -> --controller; a program and its arguments
--engine gpu: -> --engine; gpu:ADAPTER
--threads 0 -> --threads; 1 to 1024
--threads 99999 -> --threads; 1 to 1024
--threads two -> --threads; 1 to 1024
--seed -1 -> --seed; whole number
--time-limit nan -> --time-limit; above zero
--time-limit 0 -> --time-limit; above zero
--obstacles -1 -> --obstacles; 0 to 1024; name of a JSON
--obstacles 1.5 -> --obstacles; 0 to 1024
--obstacles gone.json -> gone.json; check the path
--obstacles list.json -> list.json; expected a list; \"radius\"
--obstacles radius.json -> radius.json: line 1: obstacle 0; radius is 0; above zero
--obstacles radius.toml -> radius.toml: line 8: obstacle 1; radius is -1; above zero
--obstacles away.json -> away.json: line 1: obstacle 0; outside the map
--obstacles key.toml -> key.toml; `sped`; `speed`; line 5
--obstacles 5000 -> --obstacles; 0 to 1024
--record gone/trace.jsonl -> --record gone/trace.jsonl; folder that exists
--protocol native -> --port
--base-config base.toml -> --port
--report mine.png -> --report mine.png; another name
--record both.jsonl --report both.jsonl -> both.jsonl; writes this file: choose another name
";
    assert_table(&place, "drive --map mine.yaml --start 10,5 --goal 80,40", table);
    let table = "
nonsense -> nonsense; --help
--report away devices -> --report; after the command
--report mine.png -> --report mine.png; another name
plan -> --map; --start; --goal
evaluate -> --problem
bench -> command; bench
verify --cases 0 -> --cases; 1 to
verify --seed x -> --seed; whole number
plan --scene mine --resolution 1 -> --resolution 1: it is for a map file: leave the flag out
bench localization --case tour --resolution 0.1 -> --resolution 0.1: it is for a map file
bench localization --map mine.yaml --start 1,1 --goal 2,2 --resolution 0.1 -> --resolution 0.1: mine.yaml states
bench density --steps 0 -> --steps; 1 to 1023
bench density --steps 2000 -> --steps; 1 to 1023
bench density --seconds nan -> --seconds; above zero
bench density --max-samples 99999999 -> --max-samples; 1 to 4194304
bench density --min-samples 9 --max-samples 4 -> --min-samples 9; --max-samples 4; lower
bench density --record rows.txt -> --record rows.txt; .csv or .json
bench density --record gone/rows.csv -> --record gone/rows.csv; folder that exists
bench density --record rows -> --record rows; .csv or .json
bench density --record-quality rows.svg -> --record-quality rows.svg; .csv or .json
bench density --record-quality gone/rows.csv -> --record-quality gone/rows.csv; folder that exists
plan --map mine.yaml --start 10,5 --goal 80,40 --svg plan.png -> --svg plan.png; .svg
plan --map mine.yaml --start 10,5 --goal 80,40 --svg gone/plan.svg -> --svg gone/plan.svg; folder that exists
bench density --chart density.png -> --chart density.png; .svg
bench density --chart gone/density.svg -> --chart gone/density.svg; folder that exists
bench density --ticks 101 -> --ticks; 0 to 100
bench density --ticks -1 -> --ticks; 0 to 100
bench density --seconds 0 -> --seconds; above zero
bench density --missions 0 --record-missions rows.csv -> --record-missions rows.csv; --missions
";
    assert_table(&place, "", table);
}

#[test]
fn resolution_is_for_the_masks_of_a_map_with_its_own() {
    let place = place();
    place.write("mask.txt", "#.\n..\n");
    let plan = "plan --map mine.yaml --start 10,5 --goal 80,40 --keepout";
    assert_eq!(place.run(&format!("{plan} mask.txt --resolution 0.3")).status, 0);
    let refusal = place.refusal(&format!("{plan} mine.yaml --resolution 0.3"));
    assert!(refusal.contains("--resolution 0.3: mine.yaml states its own"), "{refusal}");
}

#[test]
fn folder_as_recording_is_rejected_with_its_reason_once() {
    let place = place();
    let refusal = place.refusal("replay .");
    assert_eq!(refusal, "error: .: is a folder: name a recording in it");
}

#[cfg(all(unix, feature = "serial"))]
#[test]
fn faults_without_the_flags_that_they_need_are_rejected() {
    let place = place();
    place.write("room.txt", "....\n....\n");
    let table = "
--fault lidar-frozen@1 -> --fault lidar-frozen; add --lidar-map
--fault silence --fault lidar-late -> --fault lidar-late; add --lidar-map
--fault carried@2 -> --fault carried; add --carry-to
--fault carried@2 --lidar-map room.txt --start 1,1 -> --fault carried; add --carry-to
--lidar-map room.txt --start 1,1 --carry-to 2,1 -> --carry-to; add --fault carried@SECONDS
--fault carried@2..3 --lidar-map room.txt --start 1,1 --carry-to 2,1 -> --fault carried@2..3; write carried@2
--fault port-replaced@1.5..2 -> --fault port-replaced@1.5..2; has no end; write port-replaced@1.5
--protocol native --fault tilt@2 -> --fault tilt; --protocol native does not report its sensor; use --protocol wheeltec
--protocol arduino --fault bumper@2 -> --fault bumper; use --protocol native
--protocol wheeltec --fault cliff@2 -> --fault cliff; use --protocol native
--protocol roboclaw --fault gyro-biased@1 -> --fault gyro-biased; use --protocol native or wheeltec
--protocol arduino --fault low-battery@1 -> --fault low-battery; use --protocol native or roboclaw or wheeltec
";
    assert_table(&place, "base emulate --for 0.1", table);
}

#[test]
fn flags_of_logs_and_drives_exclude_each_other() {
    let place = place();
    place.write("drive.log", "FLASER 1 3 0 0 0 0 0 0 1 host 1\n");
    let table = "
--log drive.log --record rows.csv -> --record; --log
--log drive.log --threads 2 -> --threads; --log
--case tour --scan-topic /scan -> --scan-topic; --log
--case tour --odometry-topic /odom -> --odometry-topic; --log
";
    assert_table(&place, "bench localization", table);
}

#[test]
fn fault_matrix_without_a_fault_is_rejected() {
    let table = "
--only liddar -> --only liddar; no fault in simulation; lidar sees no surface
--only liddar --serial 0 -> --only liddar; no fault in simulation
--seeds 0 --serial 0 -> --seeds 0 --serial 0
--only lidar --seeds 0 -> --only lidar; --seeds 0
";
    assert_table(&place(), "bench faults", table);
}

#[test]
fn unusable_png_file_is_rejected() {
    let place = place();
    let table = if cfg!(feature = "png") {
        "
--png plan -> --png plan; .png
--png gone/plan.png -> --png gone/plan.png; folder that exists
"
    } else {
        "
--png plan.png -> --png; feature `png`; --svg
"
    };
    assert_table(&place, "plan --map mine.yaml --start 10,5 --goal 80,40", table);
}

#[test]
fn unusable_configurations_are_rejected() {
    let place = place();
    let drive = "drive --map mine.yaml --start 10,5 --goal 80,40 --config";
    for (file, words) in [
        ("gone.toml", "cannot be read"),
        ("binary.toml", "line 1: not UTF-8 text"),
        (".", "cannot be read"),
    ] {
        let refusal = place.refusal(&format!("{drive} {file}"));
        assert!(refusal.contains(&format!("--config {file}: {words}")), "{refusal}");
    }
    let table = "
[robot.limits]|max_vel = 1.0 -> line 2; unknown field `max_vel`; did you mean `max_vel_x`?
max_vel_x = 1.0 -> line 1; `max_vel_x` belongs in [robot.limits]
[locl] -> line 1; did you mean `local`?
unknown = 'fre' -> line 1; did you mean `free`?
colour = 1 -> unknown field `colour`; `robot`; `local`
[local]|vx_samples = 'many' -> line 2, `vx_samples = 'many'`; expected a whole number
[local]|vx_samples = -3 -> line 2, `vx_samples = -3`; expected a whole number
[local]|sim_time_s = true -> line 2; expected a number
[local]|weights = 5 -> line 2; expected a table
[local -> line 1
[local]|vx_samples = 0 -> line 2, `vx_samples = 0`: [local] vx_samples is 0; at least 1
[local]|sim_time_s = nan -> [local] sim_time_s; above zero
[local]|sim_time_s = 999.0 -> [local]; steps; sim_time_s; 1 to 1023
[local]|vx_samples = 9999|vtheta_samples = 9999 -> [local]; vx_samples; 1 to 4194304
[local.weights]|heading = -1.0 -> line 2, `heading = -1.0`: [local.weights] heading is -1; 0 to 1e6
[local]|max_clearance_m = 11.0 -> mine.yaml; the sum of max_clearance_m of [local], safety_margin_m of [navigator]; at most
[robot.limits]|max_vel_x = inf -> line 2, `max_vel_x = inf`: [robot.limits] max_vel_x is inf; 0 to 15.99
[robot.limits]|min_vel_x = 0.1 -> [robot.limits] min_vel_x is 0.1; -15.99 to 0
[robot.limits]|decel_lim_x = 1.0 -> [robot.limits] decel_lim_x is 1; below zero
[robot]|footprint = [] -> line 2; at least one
[robot]|footprint = [{x = 0, y = 0, radius = -1}] -> line 2; radius above zero
[robot]|track_width_m = 0.0 -> [robot] track_width_m is 0; above zero
[robot]|track_width_m = 1e300 -> [robot] track_width_m is 1e300; at most 100
[robot]|limits = [0.0, 1.0] -> line 2; `limits = [0.0, 1.0]`; a table of keys and values
[local]|sim_time_s = 3,0 -> line 2; write a number with a point
[local]|sampler_seed = -1 -> line 2; a whole number, at least 0
[local.weights]|heading = 0.0|clearance = 0.0|velocity = 0.0|path = 0.0 -> line 2; [local.weights] heading is 0; above zero where the other three
[global]|spline_degree = 0 -> [global] spline_degree is 0; 1 to 9
[global.heuristic.normalized]|k = nan -> line 2; [global] heuristic.normalized.k; 0 to 1e6
[navigator]|lookahead_m = nan -> [navigator] lookahead_m; above zero
[navigator]|safety_margin_m = -1.0 -> [navigator] safety_margin_m is -1; 0 to
[navigator]|safety_margin_m = 0.02 -> [navigator] safety_margin_m is 0.02; at least; margin_m in [collision_monitor]
[collision_monitor]|margin_m = 0.06 -> [navigator] safety_margin_m is 0.05; margin_m in [collision_monitor]
[navigator]|passing_margin_m = nan -> [navigator] passing_margin_m; 0 to
[navigator]|passing_speed = 0.0 -> [navigator] passing_speed is 0; above zero
[navigator]|key_node_spacing_m = 0.0 -> [navigator] key_node_spacing_m is 0; 0.01 to
[navigator]|rotate_in_place_until = 3.0 -> [navigator] rotate_in_place_until is 3; at most rotate_in_place_from
[navigator]|min_approach_linear_velocity = 1.5 -> [navigator] min_approach_linear_velocity is 1.5; at most max_vel_x in [robot.limits], 1
[navigator]|min_rotational_vel = 1.5 -> [navigator] min_rotational_vel is 1.5; at most max_vel_theta in [robot.limits], 1
[simulation.lidar]|beams = 0 -> [simulation.lidar] beams is 0; 1 to
[simulation.dynamics]|motor_lag_s = -1.0 -> [simulation.dynamics] motor_lag_s is -1; at least zero
[simulation.pedestrians]|min_speed = 0.9|max_speed = 0.2 -> line 3; [simulation.pedestrians] max_speed is 0.2; at least min_speed
[local]|sim_step_s = 5.0 -> [local] sim_step_s is 5; at most sim_time_s
[global_planner]|command = [' '] -> line 1; [global_planner] length of the program in command is 0; above zero
[walkers]|radius_m = 0.2 -> line 1; `walkers` is now `simulation.pedestrians`
[navigator]|patience_s = 1.0 -> line 2; `patience_s` is now `stuck_patience_s`
";
    for line in table.lines().filter(|line| !line.is_empty()) {
        let (text, words) = line.split_once(" -> ").expect("a line has an arrow");
        place.write("bad.toml", text.replace('|', "\n"));
        let refusal = place.refusal(&format!("{drive} bad.toml"));
        assert!(refusal.contains("bad.toml"), "{text}: {refusal}");
        for word in words.split("; ") {
            assert!(refusal.contains(word), "{text}: no {word:?} in: {refusal}");
        }
    }
}

/// Editors of Windows begin a text with a byte order mark.
#[test]
fn byte_order_mark_is_accepted_in_every_text() {
    let place = place();
    let marked = |text: &str| format!("\u{feff}{text}");
    place.write("problem.json", marked(&problem().to_string()));
    place.write("mark.toml", marked("[local]\nvx_samples = 8\n"));
    place.write("plan.toml", marked("[[worlds]]\nkind = \"scenes\"\n"));
    let map = fs::read_to_string(place.path("mine.yaml")).expect("the map is there");
    place.write("mark.yaml", marked(&map));
    place.write("people.json", marked(r#"[{"x": 1.0, "y": 1.0, "radius": 0.2, "speed": 0.0}]"#));
    place.write(
        "people.toml",
        marked("[[obstacles]]\nx = 1.0\ny = 1.0\nradius = 0.2\nspeed = 0.0\n"),
    );
    let drive =
        "drive --map mark.yaml --start 10,5 --goal 11,5 --time-limit 0.2 --config mark.toml";
    for arguments in [
        "evaluate --problem problem.json",
        "config --check mark.toml",
        "sweep plan.toml --list",
        &format!("{drive} --obstacles people.json"),
        &format!("{drive} --obstacles people.toml"),
    ] {
        let run = place.run(arguments);
        assert!(run.status != 2, "{arguments}: {run:?}");
    }
}

/// A node uses the network: only errors before that are tested here.
#[test]
fn unusable_node_arguments_are_rejected() {
    let place = place();
    place.write("slow.toml", "[local]\ncontrol_period_s = 0.3\n");
    let table = if cfg!(feature = "ros2") {
        "--namespace rover -> error: --namespace rover: ; `rover`; begin with a slash
--namespace /rover/ -> `/rover/`; begin with a slash
--namespace /1st -> `/1st`; begin with a slash
--remap scans:=/scan -> error: --remap: the node has no name `scans`: ; goal_pose; scan; __ns
-r scan -> --remap; `scan` is not a rule: ; FROM:=TO
--ros-args -r scan:=1st -> --remap; `1st`; begin with a letter
--namespace /rover -r __ns:=robot1 -> error: --remap: the namespace `robot1` is invalid
--config slow.toml -> slow.toml: line 2, `control_period_s = 0.3`: [local] control_period_s is 0.3; at most 0.25
--config wrong_key.toml -> wrong_key.toml; cannot be read"
    } else {
        " -> built without ROS 2; --features ros2"
    };
    assert_table(&place, "node", table);
    let both = place.refusal("node --stamped --unstamped");
    assert!(both.contains("cannot be used with"), "{both}");
}
