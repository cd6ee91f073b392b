//! The curves as a page and a picture.

use std::fmt::Write as _;

use super::residuals::{CAPTIVE_S, FREE_S, Half, Launch, Made, Real, made, real};
use super::rules::Rule;
use super::{Curve, Fault};

/// False alarms an hour in the tables.
const RATES: [f64; 3] = [10.0, 1.0, 0.1];
/// Multipliers of the paper's rule and of the default.
const MULTIPLIERS: [(&str, f64); 2] = [("paper, multiplier 1", 1.0), ("default, multiplier 3", 3.0)];
/// Number of launches that are flown with each fault.
const FAULTY: usize = 150;
const COLOURS: [&str; 7] = ["#d62728", "#7f7f7f", "#8c564b", "#9ecae1", "#4292c6", "#084594", "#2ca02c"];

/// One kind of residual with every rule's curve.
struct Panel {
    name: &'static str,
    about: String,
    curves: Vec<Curve>,
}

/// The page (Markdown) and the picture (SVG); `seed` and `launches` are those of the generated residuals.
#[must_use]
pub fn page(seed: u64, launches: usize) -> (String, String) {
    let development = real(Half::Development);
    let unseen = real(Half::Final);
    let panels: Vec<Panel> = [
        ("white", "2 m, independent, five a second".to_owned(), made(Made::White, launches, seed)),
        (
            "wandering",
            "2 m of wander over 60 s and 0.5 m of white noise, five a second".to_owned(),
            made(Made::Wandering, launches, seed + 1),
        ),
        (
            "heavy tails",
            "the same with Student's t of three degrees of freedom, and steps that decay".to_owned(),
            made(Made::HeavyTails, launches, seed + 2),
        ),
        ("real, seen", about(&development), development.launches.clone()),
        ("real, unseen", about(&unseen), unseen.launches.clone()),
    ]
    .into_iter()
    .filter(|(_, _, launches)| !launches.is_empty())
    .map(|(name, about, launches): (_, _, Vec<Launch>)| {
        let curves = Rule::ALL.into_iter().map(|rule| Curve::draw(rule, &launches, FAULTY)).collect();
        Panel { name, about, curves }
    })
    .collect();
    (text(&panels, &development, &unseen, seed, launches), picture(&panels))
}

fn about(real: &Real) -> String {
    format!("{} pieces of {} logs", real.launches.len(), real.used.len())
}

// Writing to a string cannot fail, here and below.
fn text(panels: &[Panel], development: &Real, unseen: &Real, seed: u64, launches: usize) -> String {
    let mut text = String::new();
    let _ = write!(
        text,
        "{}",
        HEAD.replace("{seed}", &seed.to_string())
            .replace("{launches}", &launches.to_string())
            .replace("{captive}", &CAPTIVE_S.to_string())
            .replace("{free}", &FREE_S.to_string())
    );
    for panel in panels {
        let hours = panel.curves.first().map_or(0.0, Curve::hours);
        let _ =
            writeln!(text, "\n## {}\n\n{}; {hours:.1} hours of healthy flight.\n", panel.name, panel.about);
        let faults: Vec<String> = Fault::ALL.iter().map(|fault| fault.name()).collect();
        let _ = writeln!(text, "| rule | threshold | false alarms/h | {} |", faults.join(" | "));
        let _ = writeln!(text, "|---|---|---|{}", "---|".repeat(Fault::ALL.len()));
        if let Some(curve) = panel.curves.first() {
            for (name, threshold) in MULTIPLIERS {
                row(&mut text, name, curve, threshold);
            }
        }
        for rate in RATES {
            // A rate needs at least three alarms to be determined.
            if rate * hours < 3.0 {
                let _ = writeln!(
                    text,
                    "| *{rate}/h: {hours:.1} hours are too few* | | | {}",
                    "| ".repeat(Fault::ALL.len())
                );
                continue;
            }
            for (rule, curve) in Rule::ALL.into_iter().zip(&panel.curves) {
                row(&mut text, &format!("{}, {rate}/h", rule.name()), curve, curve.threshold(rate));
            }
        }
    }
    for (name, real) in [("seen", development), ("unseen", unseen)] {
        let _ = writeln!(text, "\n## Real logs, {name}\n\nUsed: {}.\n", listed(&real.used));
        let _ = writeln!(text, "Skipped: {}.", listed(&real.skipped));
    }
    text
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join("; ") }
}

fn row(text: &mut String, name: &str, curve: &Curve, threshold: f64) {
    let delays: Vec<String> =
        (0..Fault::ALL.len()).map(|fault| seconds(curve.delay_s(fault, threshold))).collect();
    let rate = curve.false_alarms_per_hour(threshold);
    let _ = writeln!(text, "| {name} | {threshold:.2} | {rate:.2} | {} |", delays.join(" | "));
}

fn seconds(delay_s: f64) -> String {
    if delay_s.is_infinite() {
        "never".to_owned()
    } else if delay_s.is_nan() {
        "-".to_owned()
    } else {
        format!("{delay_s:.1}")
    }
}

/// A row of panels for a drift of 1 m/s, and one for a step of 5 sigma.
fn picture(panels: &[Panel]) -> String {
    const SHOWN: [usize; 2] = [1, 4];
    const LARGEST_S: [f64; 2] = [30.0, 6.0];
    let (wide, high) = (210.0, 190.0);
    let width = 60.0 + panels.len() as f64 * (wide + 34.0);
    let height = 2.0 * (high + 55.0) + 40.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for (line, (fault, largest_s)) in SHOWN.into_iter().zip(LARGEST_S).enumerate() {
        for (column, panel) in panels.iter().enumerate() {
            let left = 50.0 + column as f64 * (wide + 34.0);
            let top = 25.0 + line as f64 * (high + 55.0);
            let x = |rate: f64| left + wide * (rate / 0.05).log10() / (200.0_f64 / 0.05).log10();
            let y = |delay_s: f64| top + high * (1.0 - delay_s / largest_s);
            let _ = writeln!(
                svg,
                "<rect x=\"{left}\" y=\"{top}\" width=\"{wide}\" height=\"{high}\" fill=\"none\" stroke=\"#999\"/>\n\
                 <text x=\"{left}\" y=\"{:.1}\">{}, {}</text>",
                top - 6.0,
                panel.name,
                Fault::ALL[fault].name(),
            );
            for rate in [0.1, 1.0, 10.0, 100.0] {
                let _ = writeln!(
                    svg,
                    "<line x1=\"{0:.1}\" x2=\"{0:.1}\" y1=\"{top}\" y2=\"{1}\" stroke=\"#eee\"/><text x=\"{0:.1}\" y=\"{2}\" text-anchor=\"middle\">{rate}</text>",
                    x(rate),
                    top + high,
                    top + high + 13.0,
                );
            }
            for step in 0..=3 {
                let delay_s = largest_s * f64::from(step) / 3.0;
                let _ = writeln!(
                    svg,
                    "<line x1=\"{left}\" x2=\"{}\" y1=\"{1:.1}\" y2=\"{1:.1}\" stroke=\"#eee\"/><text x=\"{2}\" y=\"{3:.1}\" text-anchor=\"end\">{delay_s:.0} s</text>",
                    left + wide,
                    y(delay_s),
                    left - 3.0,
                    y(delay_s) + 4.0,
                );
            }
            for (curve, colour) in panel.curves.iter().zip(COLOURS) {
                let least = (3.0 / curve.hours()).max(0.05);
                let points: Vec<String> = (0..40)
                    .map(|k| least * (150.0 / least).powf(f64::from(k) / 39.0))
                    .map(|rate| (rate, curve.delay_s(fault, curve.threshold(rate))))
                    .filter(|(_, delay_s)| *delay_s <= largest_s)
                    .map(|(rate, delay_s)| format!("{:.1},{:.1}", x(rate), y(delay_s)))
                    .collect();
                let _ = writeln!(
                    svg,
                    "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"/>",
                    points.join(" ")
                );
            }
            if let Some(curve) = panel.curves.first() {
                for (_, multiplier) in MULTIPLIERS {
                    let (rate, delay_s) =
                        (curve.false_alarms_per_hour(multiplier), curve.delay_s(fault, multiplier));
                    if (0.05..=200.0).contains(&rate) && delay_s <= largest_s {
                        let _ = writeln!(
                            svg,
                            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{}\"/>",
                            x(rate),
                            y(delay_s),
                            COLOURS[0]
                        );
                    }
                }
            }
        }
    }
    let legend = height - 30.0;
    for (k, (rule, colour)) in Rule::ALL.into_iter().zip(COLOURS).enumerate() {
        let left = 50.0 + k as f64 * 120.0;
        let _ = writeln!(
            svg,
            "<line x1=\"{left}\" x2=\"{}\" y1=\"{legend}\" y2=\"{legend}\" stroke=\"{colour}\" stroke-width=\"3\"/><text x=\"{}\" y=\"{}\">{}</text>",
            left + 20.0,
            left + 25.0,
            legend + 4.0,
            rule.name()
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"50\" y=\"{}\">across: false alarms an hour; up: median delay; points: the paper's rule and the default</text>\n</svg>",
        height - 8.0
    );
    svg
}

const HEAD: &str = include_str!("head.md");
