//! `pylon studio`: which requests are served, with what, and what may be written.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod common;

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use common::Recipe;
use serde_json::{Value, json};
use tempfile::TempDir;

const PAGE: &str = "<!doctype html>\n<head>\n<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
    connect-src 'none'\"></head><body>the page</body>\n";

/// A studio that runs until dropped.
struct Studio {
    child: Child,
    /// 127.0.0.1:PORT
    host: String,
    token: String,
}

impl Drop for Studio {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

struct Answer {
    status: u16,
    head: String,
    body: String,
}

impl Studio {
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        fs::write(folder.join("page.html"), PAGE).unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_pylon"))
            .current_dir(folder)
            .env("PYLON_STUDIO", folder.join("page.html"))
            .args(["studio", "--no-browser"])
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut address = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
        let address = address.trim().strip_prefix("http://").unwrap_or_else(|| panic!("{address}"));
        let (host, token) = address.split_once("/?token=").unwrap();
        Self { child, host: host.to_owned(), token: token.to_owned() }
    }

    /// Sends a request as raw text: method and path, headers, body.
    fn raw(&self, request: &str, headers: &[&str], body: &str) -> Answer {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        let headers: String = headers.iter().map(|header| format!("{header}\r\n")).collect();
        let text = format!(
            "{request} HTTP/1.1\r\n{headers}Connection: close\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        stream.write_all(text.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or((&answer, ""));
        let status = head
            .split(' ')
            .nth(1)
            .and_then(|status| status.parse().ok())
            .unwrap_or_else(|| panic!("{answer}"));
        Answer { status, head: head.to_owned(), body: body.to_owned() }
    }

    /// Sends a request as the page does.
    fn ask(&self, request: &str, headers: &[&str], body: &str) -> Answer {
        let own = [
            format!("Host: {}", self.host),
            format!("Origin: http://{}", self.host),
            format!("Authorization: Bearer {}", self.token),
        ];
        let own: Vec<&str> = own.iter().map(String::as_str).chain(headers.iter().copied()).collect();
        self.raw(request, &own, body)
    }
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("logs")).unwrap();
    fs::write(folder.path().join("logs/one.csv"), "# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m\n0,1,2\n")
        .unwrap();
    fs::write(folder.path().join("secret.txt"), "secret").unwrap();
    fs::write(folder.path().join("ours.toml"), "# ours\n").unwrap();
    folder
}

fn version(json: &str) -> String {
    let json: serde_json::Value = serde_json::from_str(json).unwrap();
    json["version"].as_str().unwrap().to_owned()
}

#[test]
fn only_the_page_of_this_start_is_served() {
    let folder = folder();
    let studio = Studio::start(folder.path(), &["logs"]);
    let Studio { host, token, .. } = &studio;
    assert_eq!(token.len(), 64);
    let own_host = format!("Host: {host}");
    let page = studio.raw(&format!("GET /?token={token}"), &[&own_host], "");
    assert_eq!(page.status, 200);
    assert!(page.body.contains(&format!("<meta name=\"pylon-token\" content=\"{token}\">")), "{}", page.body);
    assert!(
        page.body.contains("connect-src 'self'") && !page.body.contains("connect-src 'none'"),
        "{}",
        page.body
    );
    for header in
        ["Cache-Control: no-store", "Referrer-Policy: no-referrer", "X-Content-Type-Options: nosniff"]
    {
        assert!(page.head.contains(header), "{}", page.head);
    }
    let local = format!("Host: {}", host.replace("127.0.0.1", "localhost"));
    assert_eq!(studio.raw(&format!("GET /?token={token}"), &[&local], "").status, 200);

    let bearer = format!("Authorization: Bearer {token}");
    let wrong = format!("Authorization: Bearer {}", "0".repeat(64));
    let longer = format!("{bearer}0");
    let refused: [(&str, &str, &[&str]); 9] = [
        ("no token", "GET /", &[&own_host]),
        ("another token", "GET /?token=00", &[&own_host]),
        ("no token", "GET /api/session", &[&own_host]),
        ("another token", "GET /api/session", &[&own_host, &wrong]),
        ("more than the token", "GET /api/session", &[&own_host, &longer]),
        ("a name that leads here", "GET /api/session", &["Host: evil.example", &bearer]),
        ("another port", "GET /api/session", &["Host: 127.0.0.1:1", &bearer]),
        ("another page", "GET /api/session", &[&own_host, &bearer, "Origin: http://evil.example"]),
        ("a page from a disk", "GET /api/session", &[&own_host, &bearer, "Origin: null"]),
    ];
    for (what, request, headers) in refused {
        let answer = studio.raw(request, headers, "");
        assert_eq!(answer.status, 403, "{what}");
        assert!(
            !answer.body.contains(token.as_str()) && !answer.body.contains("one.csv"),
            "{what}: {}",
            answer.body
        );
    }
    assert_ne!(Studio::start(folder.path(), &[]).token, *token);
}

#[test]
fn flights_are_those_that_were_named_and_nothing_else() {
    let folder = folder();
    let studio = Studio::start(folder.path(), &["logs"]);
    let session = studio.ask("GET /api/session", &[], "");
    assert_eq!(session.body, "{\"flights\":[\"one.csv\"],\"model\":null,\"canFly\":true}");
    let log = studio.ask("GET /api/flight/0", &[], "");
    assert_eq!(
        (log.status, log.body),
        (200, fs::read_to_string(folder.path().join("logs/one.csv")).unwrap())
    );
    for path in [
        "/api/flight/1",
        "/api/flight/-1",
        "/api/flight/../secret.txt",
        "/api/flight/..%2f..%2fsecret.txt",
        "/secret.txt",
        "/../secret.txt",
        "//etc/passwd",
        "/api/flight/18446744073709551616",
    ] {
        let answer = studio.ask(&format!("GET {path}"), &[], "");
        assert!(answer.status == 404 || answer.status == 400, "{path}: {}", answer.status);
        assert!(
            !answer.body.contains("secret\n") && !answer.body.contains("root:"),
            "{path}: {}",
            answer.body
        );
    }
    assert_eq!(studio.ask("PUT /api/model", &["If-Match: \"0\""], "# mine\n").status, 404);
    assert_eq!(studio.ask("POST /api/fly/7", &[], "").status, 404);
    let unflown = studio.ask("POST /api/fly/0", &[], "settling = 1\n");
    assert_eq!(unflown.status, 422, "{}", unflown.body);
    assert_eq!(studio.ask("DELETE /api/flight/0", &[], "").status, 405);
    assert_eq!(fs::read_to_string(folder.path().join("secret.txt")).unwrap(), "secret");
}

/// Needs qemu-system-arm and the Rust target, as `cli_fly` does.
#[test]
fn a_named_flight_flies_in_the_emulator_with_the_pages_model_and_times() {
    let folder = folder();
    Recipe { captive_s: 14.0, free_s: 8.0, ..Recipe::default() }.write(folder.path());
    let studio = Studio::start(folder.path(), &["made.csv"]);
    // Another settling time, so that the flown model is this one and not a preset.
    let model = "settling_s = 4.0\n";
    let flown = |query: &str| {
        let answer = studio.ask(&format!("POST /api/fly/0{query}"), &[], model);
        assert_eq!(answer.status, 200, "{}", answer.body);
        serde_json::from_str::<Value>(&answer.body).unwrap()
    };
    let whole = flown("");
    assert_eq!((&whole["bit_for_bit"], &whole["ticks"]), (&json!(true), &json!(4397)), "{whole}");
    let from_4_s = flown("?calibrate=4..13");
    assert_eq!(from_4_s["bit_for_bit"], true, "{from_4_s}");
    assert!(from_4_s["ticks"].as_u64().unwrap() < 4397, "what is before the window is not flown: {from_4_s}");
    for (query, says) in [
        ("?calibrate=13..4", "ends before it starts"),
        ("?calibrate=--help", "expected START..END"),
        ("?model=x", "not a time option"),
    ] {
        let refused = studio.ask(&format!("POST /api/fly/0{query}"), &[], model);
        assert!(refused.status == 400 && refused.body.contains(says), "{query}: {}", refused.body);
    }
    let has_launch = studio.ask("POST /api/fly/0?airborne=1..9", &[], model);
    assert!(has_launch.status == 422 && has_launch.body.contains("launch column"), "{}", has_launch.body);
}

#[test]
fn two_studios_on_one_model_lose_no_revision() {
    let folder = folder();
    let file = folder.path().join("ours.toml");
    let studios = [(); 2].map(|()| Studio::start(folder.path(), &["--model", "ours.toml"]));
    let read = studios[0].ask("GET /api/model", &[], "");
    let first = version(&read.body);
    assert_eq!(first, version(&studios[1].ask("GET /api/model", &[], "").body));

    let if_match = |version: &str| format!("If-Match: \"{version}\"");
    let no_model = studios[0].ask("PUT /api/model", &[&if_match(&first)], "settling_s = \"long\"\n");
    assert_eq!(
        (no_model.status, fs::read_to_string(&file).unwrap()),
        (422, "# ours\n".to_owned()),
        "{}",
        no_model.body
    );
    assert_eq!(studios[0].ask("PUT /api/model", &[], "# unasked\n").status, 428);

    // Both write at the same time, many times each: in the end every line of both is there.
    const LINES: usize = 8;
    std::thread::scope(|scope| {
        for (name, studio) in ["a", "b"].iter().zip(&studios) {
            scope.spawn(move || {
                let (mut served, mut line) = (studio.ask("GET /api/model", &[], "").body, 0);
                while line < LINES {
                    let json: serde_json::Value = serde_json::from_str(&served).unwrap();
                    let text = format!("{}# {name} {line}\n", json["model"]["text"].as_str().unwrap());
                    let answer = studio.ask("PUT /api/model", &[&if_match(&version(&served))], &text);
                    match answer.status {
                        200 => line += 1,
                        412 => {}
                        other => panic!("{other}: {}", answer.body),
                    }
                    served = answer.body;
                }
            });
        }
    });
    let text = fs::read_to_string(&file).unwrap();
    for line in 0..LINES {
        assert!(text.contains(&format!("# a {line}\n")) && text.contains(&format!("# b {line}\n")), "{text}");
    }
    assert_eq!(text.lines().count(), 1 + 2 * LINES, "{text}");
}

#[test]
fn what_can_not_be_opened_is_said_at_once() {
    let folder = folder();
    let said = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_pylon"))
            .current_dir(folder.path())
            .env("PYLON_STUDIO", folder.path().join("nowhere.html"))
            .args(["studio", "--no-browser"])
            .args(arguments)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said.lines().filter(|line| line.starts_with("error: ")).count(), 1, "{said}");
        said
    };
    assert!(said(&["none.csv"]).contains("none.csv: there is no such file"));
    assert!(said(&["--model", "none.toml"]).contains("touch none.toml"));
    assert!(said(&["--model", "default"]).contains("is a preset"));
    fs::write(folder.path().join("bad.toml"), "settling = 1\n").unwrap();
    assert!(said(&["--model", "bad.toml"]).contains("bad.toml"));
    assert!(said(&[]).contains("cargo xtask site"));
}
