//! Rejected requests: each gets a status and one line with the cause and the cure.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread;
use std::time::{Duration, Instant};

use libtest_mimic::{Failed, Trial};
use serde_json::{Value, json};

use super::served::{Answer, Served, ServerTest, read_answer};

pub fn trials() -> Vec<Trial> {
    let tests: [(&str, ServerTest); 5] = [
        ("invalid_and_too_large_bodies_are_rejected", invalid_bodies_are_rejected),
        ("unknown_paths_and_methods_are_rejected", unknown_paths_and_methods_are_rejected),
        ("invalid_heads_are_rejected", invalid_heads_are_rejected),
        ("foreign_hosts_and_origins_are_rejected", foreign_hosts_and_origins_are_rejected),
        ("slow_body_times_out_without_delaying_others", slow_body_times_out),
    ];
    let trial = |(name, test): (&'static str, ServerTest)| Trial::test(name, test);
    tests.map(trial).into()
}

/// The response has this status and one line that contains this text.
#[track_caller]
fn assert_rejected(answer: &Answer, status: u16, words: &str) {
    let body = String::from_utf8_lossy(&answer.body).into_owned();
    assert_eq!(answer.status, status, "{words}: {body}");
    let object: Value = serde_json::from_str(&body).expect("JSON");
    let error = object["error"].as_str().expect("a message");
    assert!(error.contains(words) && error.lines().count() == 1, "{words}: {error}");
    assert!(answer.head.contains("Content-Type: application/json"), "{}", answer.head);
}

fn invalid_bodies_are_rejected() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let problem = served.problem()?;
    let with = |change: fn(&mut Value)| {
        let mut problem = problem.clone();
        change(&mut problem);
        problem.to_string()
    };
    let large = " ".repeat(65_537);
    let nested = "[".repeat(60_000);
    let bodies: [(&str, u16, &str); 15] = [
        ("", 400, "it is empty: write an object"),
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
            &with(|problem| problem["map"]["origin"] = json!([1.0, 2.0])),
            400,
            "map.origin: it is only for map.rows",
        ),
        (
            &with(|problem| problem["map"]["resolution_m"] = json!(0.1)),
            400,
            "a scene states its own resolution",
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
        (&with(|problem| problem["sim_time_s"] = json!(1e300)), 400, "sim_time_s"),
        (&with(|problem| problem["target"] = json!([1e9, 0.0])), 400, "distance to the target"),
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
        assert_rejected(&served.request("POST", "/decision", body)?, status, words);
        assert_rejected(&served.request("POST", "/records", body)?, status, words);
    }
    Ok(())
}

fn unknown_paths_and_methods_are_rejected() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let methods = [
        ("GET", "/decision", "POST"),
        ("OPTIONS", "/decision", "POST"),
        ("POST", "/", "GET, HEAD"),
        ("DELETE", "/setup", "GET, HEAD"),
    ];
    for (method, path, allowed) in methods {
        let answer = served.request(method, path, "")?;
        assert_rejected(&answer, 405, allowed);
        assert!(answer.head.contains(&format!("Allow: {allowed}")), "{}", answer.head);
    }
    for path in [
        "/nothing",
        "/../Cargo.toml",
        "/%2e%2e/",
        "/scenes/roadway",
        "/scenes/moon/cells",
        "/scenes/roadway/problem",
        "//",
    ] {
        assert_rejected(&served.request("GET", path, "")?, 404, "there is nothing at");
    }
    Ok(())
}

fn invalid_heads_are_rejected() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let problem = served.problem()?;
    let host = format!("Host: 127.0.0.1:{}\r\n", served.port);
    let long = format!("X: {}\r\n", "a".repeat(20_000));
    let many = "X: a\r\n".repeat(70);
    let head = format!("HEAD / HTTP/1.1\r\n{host}\r\n");
    let mut response = String::new();
    let mut stream = served.connect()?;
    stream.write_all(head.as_bytes())?;
    stream.read_to_string(&mut response)?;
    assert!(response.starts_with("HTTP/1.1 200 ") && response.ends_with("\r\n\r\n"), "{response}");
    let post = "POST /decision HTTP/1.1\r\n";
    let raw: [(String, u16, &str); 12] = [
        ("hello\r\n\r\n".to_owned(), 400, "not HTTP/1.1"),
        ("GET / HTTP/1.1\r\n\r\n".to_owned(), 400, "exactly one Host"),
        (format!("GET / HTTP/1.1\r\n{host}{host}\r\n"), 400, "exactly one Host"),
        (format!("GET / HTTP/1.1\r\n{host}{long}\r\n"), 431, "at most 16384 bytes"),
        (format!("GET / HTTP/1.1\r\n{host}{many}\r\n"), 431, "64 headers"),
        (format!("{post}{host}\r\n"), 411, "Content-Length"),
        (format!("{post}{host}Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"), 411, "not in chunks"),
        (format!("{post}{host}Content-Length: many\r\n\r\n"), 400, "content-length"),
        (format!("{post}{host}Content-Length: -1\r\n\r\n"), 400, "content-length"),
        (format!("{post}{host}Content-Length: 9999999999999999999\r\n\r\n"), 413, "at most 65536"),
        // hyper rejects lengths of more than 64 bits.
        (
            format!("{post}{host}Content-Length: 99999999999999999999999\r\n\r\n"),
            400,
            "content-length",
        ),
        (
            format!("{post}{host}Content-Length: 2\r\nContent-Length: 3\r\n\r\n{{}}"),
            400,
            "content-length",
        ),
    ];
    for (bytes, status, words) in raw {
        assert_rejected(&served.exchange(bytes.as_bytes())?, status, words);
    }
    let mut no_text =
        format!("{post}{host}Content-Type: application/json\r\nContent-Length: 2\r\n\r\n")
            .into_bytes();
    no_text.extend([0xff, 0xfe]);
    assert_rejected(&served.exchange(&no_text)?, 400, "UTF-8");
    // A client that disconnects early, or sends no whole request, costs nothing.
    drop(served.connect()?);
    served.connect()?.write_all(b"GET / HT")?;
    assert_eq!(served.request("POST", "/decision", &problem.to_string())?.status, 200);
    Ok(())
}

fn foreign_hosts_and_origins_are_rejected() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let (port, problem) = (served.port, served.problem()?.to_string());
    let own = format!("127.0.0.1:{port}");
    let ask = |host: &str, origin: &str, content_type: &str| {
        served.request_from("POST", "/decision", host, origin, content_type, &problem)
    };
    for host in
        ["rebound.example", &format!("rebound.example:{port}"), "127.0.0.1", "127.0.0.1:1", ""]
    {
        let origin = format!("http://{host}");
        assert_rejected(&ask(host, &origin, "application/json")?, 403, "this server is not");
        let page = served.request_from("GET", "/", host, &origin, "", "")?;
        assert_rejected(&page, 403, "this server is not");
    }
    for origin in [
        "http://elsewhere.example",
        "null",
        "https://127.0.0.1",
        &format!("https://{own}"),
        "http://127.0.0.1:1",
    ] {
        assert_rejected(&ask(&own, origin, "application/json")?, 403, "are rejected");
    }
    // Content types that a foreign page can send without a preflight request.
    for content_type in
        ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", ""]
    {
        let origin = format!("http://{own}");
        assert_rejected(&ask(&own, &origin, content_type)?, 415, "application/json");
    }
    let localhost = format!("localhost:{port}");
    let answer =
        ask(&localhost, &format!("http://{localhost}"), "application/json; charset=utf-8")?;
    assert_eq!(answer.status, 200);
    // A program sends no origin.
    let length = problem.len();
    let head = format!(
        "POST /decision HTTP/1.1\r\nHost: {own}\r\nContent-Type: application/json\r\nContent-Length: {length}\r\nExpect: 100-continue\r\n\r\n"
    );
    let mut stream = served.connect()?;
    stream.write_all(head.as_bytes())?;
    // The client waits for the interim response.
    let mut interim = [0; 12];
    stream.peek(&mut interim)?;
    assert_eq!(&interim, b"HTTP/1.1 100");
    stream.write_all(problem.as_bytes())?;
    let answer = read_answer(stream)?;
    assert_eq!(answer.status, 200);
    Ok(())
}

fn slow_body_times_out() -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let problem = served.problem()?.to_string();
    let began = Instant::now();
    let head = format!(
        "POST /decision HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nContent-Type: application/json\r\nContent-Length: 2000\r\n\r\n{{",
        served.port
    );
    let mut slow: Vec<TcpStream> = (0..20).map(|_| served.connect()).collect::<Result<_, _>>()?;
    for stream in &mut slow {
        stream.write_all(head.as_bytes())?;
    }
    for _ in 0..20 {
        assert_eq!(served.request("POST", "/decision", &problem)?.status, 200);
    }
    // A client that sends a line now and then also times out.
    let mut dripping = served.connect()?;
    dripping.write_all(b"GET / HTTP/1.1\r\n")?;
    let mut dripped = dripping.try_clone()?;
    let drip = thread::spawn(move || {
        while dripped.write_all(b"X: y\r\n").is_ok() {
            thread::sleep(Duration::from_millis(400));
        }
    });
    for stream in slow {
        assert_rejected(&read_answer(stream)?, 408, "longer than 5 s");
    }
    assert!(began.elapsed() >= Duration::from_secs(5));
    assert_rejected(&read_answer(dripping)?, 408, "longer than 5 s");
    drip.join().expect("no panic");
    assert_eq!(served.request("GET", "/", "")?.status, 200);
    Ok(())
}
