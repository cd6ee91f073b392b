//! The aircraft's motion and the sensors' trust, as spans of time.

use analysis::compare::{Manoeuvre, Motion};
use kf_core::sensor::Sensor;

use crate::engine::{Attachments, Engine, Progress, Refused};
use crate::protocol::{CompareRequest, MotionNumbers, Ribbons, Span};

/// The ribbons of a flight.
pub fn ribbons(
    engine: &mut Engine,
    request: &CompareRequest,
    attachments: &mut Attachments,
    progress: &mut Progress<'_>,
) -> Result<Ribbons, Refused> {
    let recording = engine.recording(&request.flight, &request.model, request.times, progress)?;
    let times = &recording.time_s;
    let end_s = times.last().copied().unwrap_or(0.0);
    let spans = |starts: &[(usize, &'static str)]| -> Vec<Span> {
        let start_s =
            |place: usize| starts.get(place).and_then(|(tick, _)| times.get(*tick).copied()).unwrap_or(end_s);
        let each = starts.iter().enumerate();
        each.map(|(place, (_, what))| Span {
            from_s: start_s(place),
            to_s: start_s(place + 1),
            what: (*what).to_owned(),
        })
        .collect()
    };
    let there = || {
        let tracks = Sensor::ALL.into_iter().zip(&recording.sensors);
        tracks.filter(|(_, track)| !track.error_m.is_empty())
    };
    let motion = &recording.motion;
    let start_s = motion.start_us as f64 * 1e-6;
    let mut put = |quantity: fn(&Motion) -> Option<f64>| {
        attachments.put(motion.motions.iter().map(|motion| quantity(motion).unwrap_or(f64::NAN)))
    };
    let numbers = MotionNumbers {
        climb_rate_mps: put(|motion| motion.climb_rate_mps),
        speed_mps: put(|motion| motion.speed_mps),
        load_factor: put(|motion| motion.load_factor),
        turn_rate_radps: put(|motion| motion.turn_rate_radps),
        time_s: attachments.put((0..motion.motions.len()).map(|second| start_s + second as f64 + 0.5)),
    };
    Ok(Ribbons {
        phases: spans(&recording.phases),
        trust: there().map(|(sensor, track)| (sensor.name().to_owned(), spans(&track.trust))).collect(),
        manoeuvres: manoeuvres(&motion.manoeuvres, start_s, end_s),
        motion: numbers,
        sources: motion.sources.clone(),
        bounds_m: there()
            .filter_map(|(sensor, track)| Some((sensor.name().to_owned(), track.bound_m?)))
            .collect(),
        launch_s: recording.launch_s,
    })
}

/// Runs of the same manoeuvre; `seconds` has one entry per second.
fn manoeuvres(seconds: &[Manoeuvre], start_s: f64, end_s: f64) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    for (second, manoeuvre) in seconds.iter().enumerate() {
        let from_s = start_s + second as f64;
        match spans.last_mut() {
            Some(span) if span.what == manoeuvre.name() => span.to_s = (from_s + 1.0).min(end_s),
            _ => spans.push(Span {
                from_s,
                to_s: (from_s + 1.0).min(end_s),
                what: manoeuvre.name().to_owned(),
            }),
        }
    }
    spans
}
