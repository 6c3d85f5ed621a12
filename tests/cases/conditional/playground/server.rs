//! The server with many clients.

use std::fs;
use std::net::TcpStream;
use std::process::Command;
use std::thread;
use std::time::Instant;

use libtest_mimic::{Failed, Trial};
use serde_json::{Value, json};

use super::served::{Served, ServerTest};

/// Number of simultaneous requests.
const LOAD: usize = 1000;
/// Maximum memory of the server under load, kB: it needs far less.
const MAX_KB: u64 = 400_000;

pub fn trials() -> Vec<Trial> {
    let tests: [(&str, ServerTest); 5] = [
        ("responses_have_security_headers", responses_have_security_headers),
        ("decision_equals_evaluate", decision_equals_evaluate),
        ("thousand_simultaneous_requests_are_answered", thousand_requests_are_answered),
        ("server_listens_on_loopback_only", server_listens_on_loopback_only),
        ("ctrl_c_ends_server_and_used_port_is_reported", ctrl_c_ends_server),
    ];
    let trial = |(name, test): (&'static str, ServerTest)| Trial::test(name, test);
    tests.map(trial).into()
}

fn responses_have_security_headers() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    assert_eq!(served.first_line["scenes"], json!(["roadway", "crossing", "dead_end", "mine"]));
    let mut scripts = 0;
    for (path, content_type) in [
        ("/", "text/html; charset=utf-8"),
        ("/main.js", "text/javascript; charset=utf-8"),
        ("/gpu.js?a=b", "text/javascript; charset=utf-8"),
        ("/playground.css", "text/css; charset=utf-8"),
        ("/report.css", "text/css; charset=utf-8"),
        ("/shader.wgsl", "text/plain; charset=utf-8"),
        ("/setup", "application/json"),
        ("/scenes/crossing/field", "application/octet-stream"),
        ("/nothing", "application/json"),
    ] {
        let answer = served.request("GET", path, "")?;
        for line in [
            &format!("Content-Type: {content_type}"),
            "Cache-Control: no-store",
            "X-Content-Type-Options: nosniff",
            "Referrer-Policy: no-referrer",
            "Cross-Origin-Resource-Policy: same-origin",
            "Connection: close",
        ] {
            assert!(
                answer.head.lines().any(|one| one == line),
                "{path}: {line} in {}",
                answer.head
            );
        }
        let policy =
            answer.head.lines().find_map(|line| line.strip_prefix("Content-Security-Policy: "));
        let policy = policy.ok_or("no policy")?;
        assert!(
            policy.starts_with("default-src 'none'; script-src 'self'; style-src 'self';"),
            "{policy}"
        );
        assert!(
            !policy.contains("unsafe") && policy.contains("frame-ancestors 'none'"),
            "{policy}"
        );
        let text = String::from_utf8_lossy(&answer.body).into_owned();
        assert!(
            !text.contains("http://") && !text.contains("https://"),
            "{path} names another server"
        );
        scripts += text.matches("<script").count();
    }
    assert_eq!(scripts, 1, "one script");
    assert_eq!(
        served.request("GET", "/shader.wgsl", "")?.body,
        inbye::local::internals::gpu::source().into_bytes()
    );
    Ok(())
}

/// A room with a pillar, as a text map.
const ROOM: &str = "####################\n#..................#\n#..................#\n#........##........#\n#........##........#\n\
    #..................#\n#..................#\n####################\n";

fn decision_equals_evaluate() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let map = folder.path().join("room.txt");
    fs::write(&map, ROOM)?;
    let config = folder.path().join("robot.toml");
    fs::write(
        &config,
        "[local]
vtheta_samples = 21
[robot]
footprint = [{ x = 0.1, y = 0.0, radius = 0.2 }]
[robot.limits]
max_vel_x = 0.2
",
    )?;
    let served = Served::start(&[
        "--map",
        &map.to_string_lossy(),
        "--resolution",
        "0.25",
        "--config",
        &config.to_string_lossy(),
    ])?;
    let mut problem = served.problem()?;
    assert_eq!(problem["vtheta_samples"], json!(21));
    // It drives at most as fast as its limits permit.
    assert_eq!(problem["robot"]["velocity"], json!([0.2, 0.0]));
    assert_eq!(problem["robot"]["footprint"][0]["radius"], json!(0.2));
    problem["vx_samples"] = json!(33);
    problem["obstacles"] = json!([{"x": 3.0, "y": 0.6, "radius": 0.2, "vx": -0.4, "vy": 0.1}]);
    let served_answer = served.request("POST", "/decision", &problem.to_string())?.json()?;
    let records = served.request("POST", "/records", &problem.to_string())?;
    assert_eq!(records.body.len(), 33 * 21 * 20);
    problem["map"] = json!({"file": "room.txt", "resolution_m": 0.25});
    let file = folder.path().join("problem.json");
    fs::write(&file, problem.to_string())?;
    let run = Command::new(env!("CARGO_BIN_EXE_inbye"))
        .args(["evaluate", "--engine", "cpu", "--json", "--problem"])
        .arg(&file)
        .output()?;
    let evaluated: Value = serde_json::from_slice(&run.stdout)?;
    assert_eq!(served_answer["cpu"]["digest"], evaluated["digest"]);
    assert_eq!(served_answer["cpu"]["winner"]["index"], evaluated["winner"]["index"]);
    assert_eq!(served_answer["cpu"]["counts"][0], evaluated["admissible"]);
    Ok(())
}

#[expect(clippy::print_stdout, reason = "prints measured figures")]
fn thousand_requests_are_answered() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let problem = served.dense_problem(64, 64)?.to_string();
    let expected = served.request("POST", "/decision", &problem)?.json()?["cpu"]["digest"].take();
    let began = Instant::now();
    let digests = thread::scope(|scope| {
        let ask = || -> Result<Value, String> {
            let answer = served.request("POST", "/decision", &problem);
            let answer = answer.map_err(|failed| format!("{:?}", failed.message()))?;
            let object = answer.json().map_err(|failed| format!("{:?}", failed.message()))?;
            Ok(object["cpu"]["digest"].clone())
        };
        let start = |_| thread::Builder::new().stack_size(256 << 10).spawn_scoped(scope, ask);
        let asking: Vec<_> = (0..LOAD).map(start).collect::<Result<_, _>>()?;
        let answers = asking.into_iter().map(|one| one.join().expect("no panic"));
        Ok::<_, Failed>(answers.collect::<Vec<_>>())
    })?;
    let seconds = began.elapsed().as_secs_f64();
    for digest in &digests {
        assert_eq!(digest.as_ref(), Ok(&expected));
    }
    assert_eq!(digests.len(), LOAD);
    if let Ok(status) = fs::read_to_string(format!("/proc/{}/status", served.id())) {
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let peak =
            peak.ok_or("no peak of memory")?.trim().trim_end_matches(" kB").parse::<u64>()?;
        println!("{LOAD} requests in {seconds:.2} s, at most {peak} kB");
        assert!(peak < MAX_KB, "{peak} kB");
    }
    Ok(())
}

fn server_listens_on_loopback_only() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    assert_eq!(served.url, format!("http://127.0.0.1:{}/", served.port));
    if cfg!(target_os = "linux") {
        // All of 127/8 is this machine; the server listens at one of its addresses.
        let elsewhere = TcpStream::connect(("127.0.0.2", served.port));
        assert!(elsewhere.is_err(), "the server listens on another address");
        let table = fs::read_to_string("/proc/net/tcp")?;
        let own = format!(":{:04X}", served.port);
        let listening: Vec<&str> = table
            .lines()
            .filter_map(|line| {
                let mut words = line.split_whitespace().skip(1);
                let address = words.next()?;
                (address.ends_with(&own) && words.nth(1)? == "0A").then_some(address)
            })
            .collect();
        assert_eq!(listening, [format!("0100007F{own}")]);
    }
    Ok(())
}

fn ctrl_c_ends_server() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let port = served.port.to_string();
    let second =
        Command::new(env!("CARGO_BIN_EXE_inbye")).args(["playground", "--port", &port]).output()?;
    let error = String::from_utf8(second.stderr)?;
    assert_eq!(second.status.code(), Some(2), "{error}");
    assert!(
        error.starts_with(&format!("error: --port {port}: ")) && error.lines().count() == 1,
        "{error}"
    );
    let rejected = |arguments: &[&str]| -> Result<String, Failed> {
        let run =
            Command::new(env!("CARGO_BIN_EXE_inbye")).arg("playground").args(arguments).output()?;
        assert_eq!((run.status.code(), run.stdout.len()), (Some(2), 0));
        Ok(String::from_utf8(run.stderr)?)
    };
    assert!(rejected(&["--port", "65536"])?.contains("0 to 65535"));
    assert!(rejected(&["--map", "/nothing.yaml"])?.contains("/nothing.yaml"));
    #[cfg(unix)]
    {
        // With an open connection without a request.
        let idle = served.connect()?;
        assert_eq!(served.interrupt()?, Some(0));
        drop(idle);
        let answered = Served::start(&[])?;
        assert_eq!(answered.request("GET", "/", "")?.status, 200);
        assert_eq!(answered.interrupt()?, Some(0));
    }
    Ok(())
}
