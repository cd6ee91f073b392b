//! The loopback server: serves the page, the flights that were named, and the model that may be written.
//! Nothing else is read or written, whatever is requested: a file is requested by its position on the command
//! line, never by a path.

use std::fs::File;
use std::io::{self, Cursor, Read as _};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use serde::Serialize;
use tiny_http::{Header, Method, Request, Response, StatusCode};

use super::fly::{Flying, NotFlown};
use super::guard::{Guard, Refusal, header};
use super::model_file::{ModelFile, Saved, ServedModel};
use crate::cli::failure::Failure;
use pylon::replay::{AirborneError, GivenTimes, WindowError};

/// Limit on a model's length, bytes.
const LONGEST_MODEL: u64 = 4 << 20;
/// Threads that the server starts before it listens. If it cannot start one, it panics in another of its own
/// threads and answers nothing.
const SERVER_THREADS: usize = 5;
/// The policy with which the page may fetch nothing; as served here it may send requests to this server.
const FROM_DISK: &str = "connect-src 'none'";
const FROM_HERE: &str = "connect-src 'self'";

/// A listening server.
pub struct Server {
    http: tiny_http::Server,
    address: String,
    served: Arc<Served>,
}

/// What is served.
struct Served {
    guard: Guard,
    page: String,
    logs: Vec<PathBuf>,
    model: Option<ModelFile>,
    flying: Flying,
}

/// What a page is sent at its start.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Session {
    /// The logs' file names, without folders.
    flights: Vec<String>,
    model: Option<ServedModel>,
    can_fly: bool,
}

/// An answer: its status, its media type and its text.
struct Answer {
    status: u16,
    media: &'static str,
    body: Body,
}

enum Body {
    Text(String),
    File(File),
}

impl Answer {
    fn text(status: u16, media: &'static str, text: String) -> Self {
        Self { status, media, body: Body::Text(text) }
    }

    fn plain(status: u16, text: &str) -> Self {
        Self::text(status, "text/plain; charset=utf-8", format!("{text}\n"))
    }

    fn json(status: u16, value: &impl Serialize) -> Self {
        match serde_json::to_string(value) {
            Ok(text) => Self::text(status, "application/json", text),
            Err(error) => Self::plain(500, &error.to_string()),
        }
    }
}

impl Server {
    /// Listens on a port of this machine, for requests from this machine only.
    pub fn bind(
        port: u16,
        page: String,
        logs: Vec<PathBuf>,
        model: Option<ModelFile>,
    ) -> Result<Self, Failure> {
        let http = tiny_http::Server::http(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))
            .map_err(|error| Failure::input(format!("cannot listen on port {port}: {error}")))?;
        let address =
            http.server_addr().to_ip().ok_or_else(|| Failure::input("the server has no address"))?;
        let guard = Guard::new(address).map_err(|error| {
            Failure::input(format!("the system could not generate a random token: {error}"))
        })?;
        let token = guard.token();
        // The policy comes first in the page. The same words in its script must stay, or the script's hash
        // changes.
        let page = page.replacen(FROM_DISK, FROM_HERE, 1).replacen(
            "<head>",
            &format!("<head>\n<meta name=\"pylon-token\" content=\"{token}\">"),
            1,
        );
        let address = format!("http://{address}/?token={token}");
        Ok(Self {
            http,
            address,
            served: Arc::new(Served { guard, page, logs, model, flying: Flying::default() }),
        })
    }

    /// The address of the page, with this run's token.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Serves until the process is stopped.
    pub fn serve(self) -> Result<(), Failure> {
        loop {
            let request =
                self.http.recv().map_err(|error| Failure::input(format!("the server stopped: {error}")))?;
            let served = Arc::clone(&self.served);
            let waiting = Arc::new(Mutex::new(Some(request)));
            let answer = {
                let waiting = Arc::clone(&waiting);
                move || {
                    let request = waiting.lock().unwrap_or_else(PoisonError::into_inner).take();
                    if let Some(request) = request {
                        served.answer(request);
                    }
                }
            };
            // A long log must not delay the page; if no thread can be started, it does.
            if thread::Builder::new().spawn(answer).is_err()
                && let Some(request) = waiting.lock().unwrap_or_else(PoisonError::into_inner).take()
            {
                self.served.answer(request);
            }
        }
    }
}

/// Refuses to start unless enough threads are available: the server's own and one for an answer.
pub fn check_threads() -> Result<(), Failure> {
    let threads = SERVER_THREADS + 1;
    let gate = Mutex::new(());
    let started: io::Result<()> = thread::scope(|scope| {
        // Closed until all threads are running.
        let _closed = gate.lock().unwrap_or_else(PoisonError::into_inner);
        let wait = || drop(gate.lock().unwrap_or_else(PoisonError::into_inner));
        (0..threads).try_for_each(|_| thread::Builder::new().spawn_scoped(scope, wait).map(drop))
    });
    started.map_err(|error| Failure::input(format!("the studio needs {threads} threads: {error}")))
}

impl Served {
    fn answer(&self, mut request: Request) {
        let answer = match self.guard.check(&request) {
            Ok(()) => self.found(&mut request),
            Err(Refusal::Host) => Answer::plain(403, "the request was addressed to another host"),
            Err(Refusal::Origin) => Answer::plain(403, "this studio answers only its own page"),
            Err(Refusal::Token) => Answer::plain(
                403,
                "the token is missing or from an earlier run: use the address that `pylon studio` printed",
            ),
        };
        // It is no error if the page was closed in the meantime.
        let _ = respond(request, answer);
    }

    fn found(&self, request: &mut Request) -> Answer {
        let path = request.url().split('?').next().unwrap_or_default().to_owned();
        match (request.method(), path.as_str()) {
            (Method::Get, "/") => Answer::text(200, "text/html; charset=utf-8", self.page.clone()),
            (Method::Get, "/api/session") => self.session(),
            (Method::Get, "/api/model") => match self.model.as_ref().map(ModelFile::read) {
                Some(Ok(served)) => Answer::json(200, &served),
                Some(Err(failure)) => Answer::plain(500, failure.message()),
                None => Answer::plain(404, "no model was named: pylon studio --model ours.toml"),
            },
            (Method::Put, "/api/model") => self.save(request),
            (Method::Post, path) => match path.strip_prefix("/api/fly/").and_then(|place| place.parse().ok())
            {
                Some(place) => self.fly(place, request),
                None => Answer::plain(404, "there is no such page"),
            },
            (Method::Get, path) => {
                match path.strip_prefix("/api/flight/").and_then(|place| place.parse().ok()) {
                    Some(place) => self.log(place),
                    None => Answer::plain(404, "there is no such page"),
                }
            }
            _ => Answer::plain(405, "this request method is not supported here"),
        }
    }

    fn session(&self) -> Answer {
        let name =
            |file: &PathBuf| file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        match self.model.as_ref().map(ModelFile::read).transpose() {
            Ok(model) => {
                let flights = self.logs.iter().map(name).collect();
                Answer::json(200, &Session { flights, model, can_fly: true })
            }
            Err(failure) => Answer::plain(500, failure.message()),
        }
    }

    fn log(&self, place: usize) -> Answer {
        let Some(file) = self.logs.get(place) else { return Answer::plain(404, "there is no such flight") };
        match File::open(file) {
            Ok(log) => Answer { status: 200, media: "application/octet-stream", body: Body::File(log) },
            Err(error) => Answer::plain(500, &format!("{}: cannot be read: {error}", file.display())),
        }
    }

    /// Flies a named flight in the emulator, with the model in the request.
    fn fly(&self, place: usize, request: &mut Request) -> Answer {
        let Some(log) = self.logs.get(place) else { return Answer::plain(404, "there is no such flight") };
        let times = match times(request.url()) {
            Ok(times) => times,
            Err(why) => return Answer::plain(400, &why),
        };
        let text = match model_text(request) {
            Ok(text) => text,
            Err(answer) => return answer,
        };
        match self.flying.fly(log, &text, times) {
            Ok(json) => Answer::text(200, "application/json", json),
            Err(why @ NotFlown::Busy) => Answer::plain(409, &why.to_string()),
            Err(why) => Answer::plain(422, &why.to_string()),
        }
    }

    fn save(&self, request: &mut Request) -> Answer {
        let Some(model) = &self.model else {
            return Answer::plain(404, "no model was named: pylon studio --model ours.toml");
        };
        let Some(version) = header(request, "If-Match").map(|value| value.trim_matches('"').to_owned())
        else {
            return Answer::plain(428, "the request does not name the version of the model to replace");
        };
        let text = match model_text(request) {
            Ok(text) => text,
            Err(answer) => return answer,
        };
        match model.save(text, &version) {
            Ok(Saved::Written(served)) => Answer::json(200, &served),
            Ok(Saved::Changed(served)) => Answer::json(412, &served),
            Ok(Saved::NoModel(why)) => Answer::plain(422, &why),
            Err(failure) => Answer::plain(500, failure.message()),
        }
    }
}

/// The flight's times from a request's address, in the command line's notation:
/// `?calibrate=10..80&airborne=12..640`.
fn times(url: &str) -> Result<GivenTimes, String> {
    let mut times = GivenTimes::default();
    let query = url.split_once('?').map_or("", |(_, query)| query);
    for part in query.split('&').filter(|part| !part.is_empty()) {
        match part.split_once('=') {
            Some(("calibrate", window)) => {
                times.calibration = Some(window.parse().map_err(|error: WindowError| error.to_string())?);
            }
            Some(("airborne", airborne)) => {
                times.airborne = Some(airborne.parse().map_err(|error: AirborneError| error.to_string())?);
            }
            _ => {
                return Err(format!(
                    "'{part}' is not a time option; expected calibrate=A..B or airborne=A..B"
                ));
            }
        }
    }
    Ok(times)
}

/// The model in a request.
fn model_text(request: &mut Request) -> Result<String, Answer> {
    let mut text = String::new();
    match request.as_reader().take(LONGEST_MODEL + 1).read_to_string(&mut text) {
        Ok(_) if text.len() as u64 > LONGEST_MODEL => Err(Answer::plain(413, "the model is too long")),
        Ok(_) => Ok(text),
        Err(error) => Err(Answer::plain(400, &format!("the model could not be received: {error}"))),
    }
}

fn respond(request: Request, answer: Answer) -> std::io::Result<()> {
    let status = StatusCode(answer.status);
    let headers = [
        ("Content-Type", answer.media),
        ("Cache-Control", "no-store"),
        ("Referrer-Policy", "no-referrer"),
        ("X-Content-Type-Options", "nosniff"),
        ("X-Frame-Options", "DENY"),
        ("Content-Security-Policy", "frame-ancestors 'none'"),
        ("Cross-Origin-Opener-Policy", "same-origin"),
        ("Cross-Origin-Resource-Policy", "same-origin"),
    ];
    let headers: Vec<Header> = headers
        .into_iter()
        .filter_map(|(name, value)| Header::from_bytes(name.as_bytes(), value.as_bytes()).ok())
        .collect();
    match answer.body {
        Body::Text(text) => {
            let length = text.len();
            request.respond(Response::new(status, headers, Cursor::new(text), Some(length), None))
        }
        Body::File(file) => {
            let length = file.metadata().ok().and_then(|facts| usize::try_from(facts.len()).ok());
            request.respond(Response::new(status, headers, file, length, None))
        }
    }
}
