//! The server among clients of all kinds.

use std::fs;
use std::io::Write;
use std::net::TcpStream;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use libtest_mimic::{Failed, Trial};
use serde_json::{Value, json};

use crate::served::{Answer, Served, read_answer};

/// Requests of the load, all of them at a time.
const LOAD: usize = 1000;
/// Most memory that the server may have held under that load, kB: it takes far less.
const MOST_KB: u64 = 400_000;

type ServerTest = fn() -> Result<(), Failed>;

pub fn trials() -> Vec<Trial> {
    let tests: [(&str, ServerTest); 8] = [
        (
            "what is asked wrongly is refused with a status and a line",
            refusals,
        ),
        ("a strange host or origin is refused", strangers),
        (
            "a body that is slow is given up, and nobody waits for it",
            slow_bodies,
        ),
        ("every answer forbids what the page does not need", headers),
        ("the answer is that of evaluate", same_as_evaluate),
        ("a thousand requests at a time lose none", load),
        ("it listens on the loopback only", loopback_only),
        ("Ctrl-C ends it, and a taken port is told", endings),
    ];
    let trial = |(name, test): (&'static str, ServerTest)| Trial::test(name, test);
    tests.map(trial).into()
}

/// It was refused with this status and one line that contains these words.
#[track_caller]
fn assert_refused(answer: &Answer, status: u16, words: &str) {
    let body = String::from_utf8_lossy(&answer.body).into_owned();
    assert_eq!(answer.status, status, "{words}: {body}");
    let object: Value = serde_json::from_str(&body).expect("a refusal is JSON");
    let said = object["error"].as_str().expect("it says why");
    assert!(
        said.contains(words) && said.lines().count() == 1,
        "{words}: {said}"
    );
    assert!(
        answer.head.contains("Content-Type: application/json"),
        "{}",
        answer.head
    );
}

fn refusals() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let problem = served.problem()?;
    let with = |change: fn(&mut Value)| {
        let mut problem = problem.clone();
        change(&mut problem);
        problem.to_string()
    };
    let large = " ".repeat(65_537);
    let nested = "[".repeat(60_000);
    let bodies: [(&str, u16, &str); 13] = [
        ("", 400, "line 1, column 0"),
        ("{\"map\": ", 400, "line 1, column"),
        ("nonsense", 400, "line 1, column"),
        (&nested, 400, "line 1, column"),
        (&large, 413, "65537 bytes: send at most 65536"),
        (&with(|problem| problem["colour"] = json!(1)), 400, "colour"),
        (
            &with(|problem| problem["map"]["file"] = json!("/etc/passwd")),
            400,
            "one of \"roadway\", \"crossing\"",
        ),
        (
            &with(|problem| problem["map"] = json!({"resolution_m": 1.0, "rows": ["."]})),
            400,
            "a scene of this playground",
        ),
        (
            &with(|problem| problem["vx_samples"] = json!(100_000)),
            400,
            "4000000 samples: at most 524288 here",
        ),
        (
            &with(|problem| problem["vx_samples"] = json!(4_000_000_000_u32)),
            400,
            "number of samples",
        ),
        (
            &with(|problem| problem["sim_time_s"] = json!(1e300)),
            400,
            "sim_time_s",
        ),
        (
            &with(|problem| problem["target"] = json!([1e9, 0.0])),
            400,
            "distance to the target",
        ),
        (
            &with(|problem| {
                let one = problem["obstacles"][0].clone();
                problem["obstacles"] = json!(vec![one; 33]);
            }),
            400,
            "33 moving obstacles: at most 32 here",
        ),
    ];
    for (body, status, words) in bodies {
        assert_refused(&served.request("POST", "/decision", body)?, status, words);
        assert_refused(&served.request("POST", "/records", body)?, status, words);
    }
    let methods = [
        ("GET", "/decision", "POST"),
        ("OPTIONS", "/decision", "POST"),
        ("POST", "/", "GET"),
        ("DELETE", "/setup", "GET"),
        ("HEAD", "/", "GET"),
    ];
    for (method, path, allowed) in methods {
        let answer = served.request(method, path, "")?;
        assert_refused(&answer, 405, allowed);
        assert!(
            answer.head.contains(&format!("Allow: {allowed}")),
            "{}",
            answer.head
        );
    }
    for path in [
        "/nothing",
        "/../Cargo.toml",
        "/%2e%2e/",
        "/scenes/roadway",
        "/scenes/mine/cells",
        "/scenes/roadway/problem",
        "//",
    ] {
        assert_refused(
            &served.request("GET", path, "")?,
            404,
            "there is nothing at",
        );
    }
    let host = format!("Host: 127.0.0.1:{}\r\n", served.port);
    let long = format!("X: {}\r\n", "a".repeat(20_000));
    let many = "X: a\r\n".repeat(70);
    let post = "POST /decision HTTP/1.1\r\n";
    let raw: [(String, u16, &str); 11] = [
        ("hello\r\n\r\n".to_owned(), 400, "not HTTP/1.1"),
        (
            "GET / HTTP/1.1\r\n\r\n".to_owned(),
            400,
            "names its Host once",
        ),
        (
            format!("GET / HTTP/1.1\r\n{host}{host}\r\n"),
            400,
            "names its Host once",
        ),
        (
            format!("GET / HTTP/1.1\r\n{host}{long}\r\n"),
            431,
            "at most 16384 bytes",
        ),
        (
            format!("GET / HTTP/1.1\r\n{host}{many}\r\n"),
            431,
            "64 headers",
        ),
        (format!("{post}{host}\r\n"), 411, "Content-Length"),
        (
            format!("{post}{host}Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
            411,
            "not in chunks",
        ),
        (
            format!("{post}{host}Content-Length: many\r\n\r\n"),
            400,
            "a number of bytes",
        ),
        (
            format!("{post}{host}Content-Length: -1\r\n\r\n"),
            400,
            "a number of bytes",
        ),
        (
            format!("{post}{host}Content-Length: 99999999999999999999999\r\n\r\n"),
            413,
            "at most 65536",
        ),
        (
            format!("{post}{host}Content-Length: 2\r\nContent-Length: 3\r\n\r\n{{}}"),
            400,
            "one Content-Length",
        ),
    ];
    for (bytes, status, words) in raw {
        assert_refused(&served.exchange(bytes.as_bytes())?, status, words);
    }
    let mut no_text =
        format!("{post}{host}Content-Type: application/json\r\nContent-Length: 2\r\n\r\n")
            .into_bytes();
    no_text.extend([0xff, 0xfe]);
    assert_refused(&served.exchange(&no_text)?, 400, "UTF-8");
    // A client that leaves early, and one that says nothing, cost nothing.
    drop(served.connect()?);
    served.connect()?.write_all(b"GET / HT")?;
    assert_eq!(
        served
            .request("POST", "/decision", &problem.to_string())?
            .status,
        200
    );
    Ok(())
}

fn strangers() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let (port, problem) = (served.port, served.problem()?.to_string());
    let own = format!("127.0.0.1:{port}");
    let ask = |host: &str, origin: &str, content_type: &str| {
        served.request_from("POST", "/decision", host, origin, content_type, &problem)
    };
    for host in [
        "rebound.example",
        &format!("rebound.example:{port}"),
        "127.0.0.1",
        "127.0.0.1:1",
        "",
    ] {
        let origin = format!("http://{host}");
        assert_refused(
            &ask(host, &origin, "application/json")?,
            403,
            "this server is not",
        );
        let page = served.request_from("GET", "/", host, &origin, "", "")?;
        assert_refused(&page, 403, "this server is not");
    }
    for origin in [
        "http://elsewhere.example",
        "null",
        "https://127.0.0.1",
        &format!("https://{own}"),
        "http://127.0.0.1:1",
    ] {
        assert_refused(
            &ask(&own, origin, "application/json")?,
            403,
            "may not ask here",
        );
    }
    // What a foreign page may send without asking first.
    for content_type in [
        "text/plain",
        "application/x-www-form-urlencoded",
        "multipart/form-data; boundary=x",
        "",
    ] {
        let origin = format!("http://{own}");
        assert_refused(&ask(&own, &origin, content_type)?, 415, "application/json");
    }
    let localhost = format!("localhost:{port}");
    let answer = ask(
        &localhost,
        &format!("http://{localhost}"),
        "application/json; charset=utf-8",
    )?;
    assert_eq!(answer.status, 200);
    // A program is no page, and says no origin.
    let length = problem.len();
    let head = format!(
        "POST /decision HTTP/1.1\r\nHost: {own}\r\nContent-Type: application/json\r\nContent-Length: {length}\r\nExpect: 100-continue\r\n\r\n"
    );
    let mut stream = served.connect()?;
    stream.write_all(head.as_bytes())?;
    // It waits to be told to go on.
    let mut told = [0; 12];
    stream.peek(&mut told)?;
    assert_eq!(&told, b"HTTP/1.1 100");
    stream.write_all(problem.as_bytes())?;
    let answer = read_answer(stream)?;
    assert_eq!(answer.status, 200);
    Ok(())
}

fn slow_bodies() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let problem = served.problem()?.to_string();
    let began = Instant::now();
    let head = format!(
        "POST /decision HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nContent-Type: application/json\r\nContent-Length: 2000\r\n\r\n{{",
        served.port
    );
    let mut slow: Vec<TcpStream> = (0..20)
        .map(|_| served.connect())
        .collect::<Result<_, _>>()?;
    for stream in &mut slow {
        stream.write_all(head.as_bytes())?;
    }
    for _ in 0..20 {
        assert_eq!(served.request("POST", "/decision", &problem)?.status, 200);
    }
    // One that sends a byte now and then is as slow.
    let mut dripping = served.connect()?;
    dripping.write_all(b"GET / HTTP/1.1\r\n")?;
    let mut dripped = dripping.try_clone()?;
    let drip = thread::spawn(move || {
        while dripped.write_all(b"X: y\r\n").is_ok() {
            thread::sleep(Duration::from_millis(400));
        }
    });
    for stream in slow {
        assert_refused(&read_answer(stream)?, 408, "longer than 5 s");
    }
    assert!(began.elapsed() >= Duration::from_secs(5));
    assert_refused(&read_answer(dripping)?, 408, "longer than 5 s");
    drip.join().expect("it has stopped dripping");
    assert_eq!(served.request("GET", "/", "")?.status, 200);
    Ok(())
}

fn headers() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    assert_eq!(
        served.first_line["scenes"],
        json!(["roadway", "crossing", "dead_end"])
    );
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
        let policy = answer
            .head
            .lines()
            .find_map(|line| line.strip_prefix("Content-Security-Policy: "));
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
            "{path} names another place"
        );
        scripts += text.matches("<script").count();
    }
    assert_eq!(scripts, 1, "one script, of its own");
    assert_eq!(
        served.request("GET", "/shader.wgsl", "")?.body,
        inbye::local::gpu::shaders::source().into_bytes()
    );
    Ok(())
}

/// A room with a pillar, as a text map.
const ROOM: &str = "####################\n#..................#\n#..................#\n#........##........#\n#........##........#\n\
    #..................#\n#..................#\n####################\n";

fn same_as_evaluate() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let map = folder.path().join("room.txt");
    fs::write(&map, ROOM)?;
    let served = Served::start(&["--map", &map.to_string_lossy(), "--resolution", "0.25"])?;
    let mut problem = served.problem()?;
    problem["vx_samples"] = json!(33);
    problem["obstacles"] = json!([{"x": 3.0, "y": 0.6, "radius": 0.2, "vx": -0.4, "vy": 0.1}]);
    let served_answer = served
        .request("POST", "/decision", &problem.to_string())?
        .json()?;
    let records = served.request("POST", "/records", &problem.to_string())?;
    assert_eq!(records.body.len(), 33 * 40 * 20);
    problem["map"] = json!({"file": "room.txt", "resolution_m": 0.25});
    let file = folder.path().join("problem.json");
    fs::write(&file, problem.to_string())?;
    let run = Command::new(env!("CARGO_BIN_EXE_inbye"))
        .args(["evaluate", "--engine", "cpu", "--json", "--problem"])
        .arg(&file)
        .output()?;
    let evaluated: Value = serde_json::from_slice(&run.stdout)?;
    assert_eq!(served_answer["cpu"]["digest"], evaluated["digest"]);
    assert_eq!(
        served_answer["cpu"]["winner"]["index"],
        evaluated["winner"]["index"]
    );
    assert_eq!(served_answer["cpu"]["counts"][0], evaluated["admissible"]);
    Ok(())
}

fn load() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let problem = served.dense_problem(64, 64)?.to_string();
    let expected = served.request("POST", "/decision", &problem)?.json()?["cpu"]["digest"].take();
    let began = Instant::now();
    let digests = thread::scope(|scope| {
        let ask = || -> Result<Value, String> {
            let answer = served.request("POST", "/decision", &problem);
            let answer = answer.map_err(|failed| format!("{:?}", failed.message()))?;
            let object = answer
                .json()
                .map_err(|failed| format!("{:?}", failed.message()))?;
            Ok(object["cpu"]["digest"].clone())
        };
        let start = |_| {
            thread::Builder::new()
                .stack_size(256 << 10)
                .spawn_scoped(scope, ask)
        };
        let asking: Vec<_> = (0..LOAD).map(start).collect::<Result<_, _>>()?;
        let answers = asking
            .into_iter()
            .map(|one| one.join().expect("it asks without a panic"));
        Ok::<_, Failed>(answers.collect::<Vec<_>>())
    })?;
    let seconds = began.elapsed().as_secs_f64();
    for digest in &digests {
        assert_eq!(digest.as_ref(), Ok(&expected));
    }
    assert_eq!(digests.len(), LOAD);
    if let Ok(status) = fs::read_to_string(format!("/proc/{}/status", served.id())) {
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let peak = peak
            .ok_or("no peak of memory")?
            .trim()
            .trim_end_matches(" kB")
            .parse::<u64>()?;
        println!("{LOAD} requests in {seconds:.2} s, at most {peak} kB");
        assert!(peak < MOST_KB, "{peak} kB");
    }
    Ok(())
}

fn loopback_only() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    assert_eq!(served.url, format!("http://127.0.0.1:{}/", served.port));
    if cfg!(target_os = "linux") {
        // All of 127/8 is this machine; it listens at one address of it.
        let elsewhere = TcpStream::connect(("127.0.0.2", served.port));
        assert!(
            elsewhere.is_err(),
            "it listens on more than its own address"
        );
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

fn endings() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let port = served.port.to_string();
    let second = Command::new(env!("CARGO_BIN_EXE_inbye"))
        .args(["playground", "--port", &port])
        .output()?;
    let said = String::from_utf8(second.stderr)?;
    assert_eq!(second.status.code(), Some(2), "{said}");
    assert!(
        said.starts_with(&format!("error: --port {port}: ")) && said.lines().count() == 1,
        "{said}"
    );
    let refused = |arguments: &[&str]| -> Result<String, Failed> {
        let run = Command::new(env!("CARGO_BIN_EXE_inbye"))
            .arg("playground")
            .args(arguments)
            .output()?;
        assert_eq!((run.status.code(), run.stdout.len()), (Some(2), 0));
        Ok(String::from_utf8(run.stderr)?)
    };
    assert!(refused(&["--port", "65536"])?.contains("0 to 65535"));
    assert!(refused(&["--map", "/nothing.yaml"])?.contains("/nothing.yaml"));
    #[cfg(unix)]
    {
        // While somebody is still thinking about what to ask.
        let thinking = served.connect()?;
        assert_eq!(served.interrupt()?, Some(0));
        drop(thinking);
        let answered = Served::start(&[])?;
        assert_eq!(answered.request("GET", "/", "")?.status, 200);
        assert_eq!(answered.interrupt()?, Some(0));
    }
    Ok(())
}
