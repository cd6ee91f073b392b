//! An effect by formula: checked as a definition of the model, and roughly fitted to a flight for display.

use std::ops::Range;

use analysis::discover::{NewDefinition, largest_plausible, with_new_definition};
use flight_data::{Channel, Flight};
use kf_core::effect::{EffectId, Regressor};
use model::formula::{Columns, Formula, FormulaError};
use model::{Model, ModelError};

use crate::curve::{Flown, curve, in_error};
use crate::engine::{Attachments, Engine, Progress, Refused, refused, replay};
use crate::protocol::{Defined, FormulaChecked, FormulaProblem, FormulaRequest, ModelText};

/// Limit on the points of the picture.
const POINTS: usize = 400;
/// Least number of values for a fit.
const FEWEST: usize = 10;

/// Checks a formula. An error in it is part of the answer, not a refusal.
pub fn checked(
    engine: &mut Engine,
    request: &FormulaRequest,
    attachments: &mut Attachments,
    progress: &mut Progress<'_>,
) -> Result<FormulaChecked, Refused> {
    let wrong = |problem| Ok(FormulaChecked { problem: Some(problem), definition: None });
    // Compiled without the model where possible; effects that it names are known only to the model.
    let alone = Formula::compile(&request.regressor, &mut Columns::default());
    let unit =
        alone.as_ref().map_or_else(|_| "1".to_owned(), |formula| formula.coefficient_unit().to_string());
    let id =
        request.id.clone().unwrap_or_else(|| own_id(&request.on, alone.as_ref().ok(), &request.model.text));
    let text = |largest: f64| {
        let new = NewDefinition {
            id: &id,
            on: &request.on,
            regressor: &request.regressor,
            unit: &unit,
            largest,
            about: &request.about,
        };
        with_new_definition(&request.model.text, &new)
            .map_err(|error| refused(format!("{}: {error}", request.model.name)))
    };
    // Any range will do for parsing.
    let (effect, read) = match definition(&text(request.largest.unwrap_or(1.0))?, &id) {
        Ok(found) => found,
        Err(error) => return wrong(problem(error, &request.regressor)),
    };
    let open = engine.flight(&request.flight)?;
    if let Some(column) = effect.needs().iter().find(|column| !has(&open.flight, column)) {
        return wrong(missing(column, &request.regressor));
    }
    let defining = ModelText { name: request.model.name.clone(), text: read };
    let says = in_error(&replay(open, &defining, request.times)?, Regressor::new(effect), 1.0);
    let flown = Flown { flight: &request.flight, model: &request.model, times: request.times };
    let error = curve(engine, &flown, &request.error, progress)?;
    let from_s = request.from_s.unwrap_or(f64::NEG_INFINITY);
    let mut pairs = Vec::new();
    let mut says = says.into_iter().peekable();
    let mut last = None;
    error.each(error.range(from_s, f64::INFINITY), &mut |_, time_s, error_m| {
        while let Some(point) = says.next_if(|(at_s, _)| *at_s <= time_s) {
            last = Some(point.1);
        }
        if let Some(regressor_m) = last {
            pairs.push((regressor_m, error_m));
        }
    });
    let whole = |message: &str| FormulaProblem {
        message: message.to_owned(),
        from: 0,
        to: utf16(&request.regressor, request.regressor.len()),
    };
    let Some(fit) = Fit::of(&pairs) else {
        return wrong(whole(
            "The formula is constant over this flight, or has no value: the flight cannot determine its coefficient.",
        ));
    };
    let largest = request.largest.unwrap_or_else(|| largest_plausible(fit.coefficient));
    let text = text(largest)?;
    if let Err(error) = Model::parse(&text) {
        return wrong(problem(error, &request.regressor));
    }
    let blocks = blocks(pairs.len());
    let mean = |of: fn(&(f64, f64)) -> f64| {
        let means = blocks.iter().map(|block| {
            let values = pairs.get(block.clone()).unwrap_or_default();
            values.iter().map(of).sum::<f64>() / values.len() as f64
        });
        means.collect::<Vec<f64>>()
    };
    Ok(FormulaChecked {
        problem: None,
        definition: Some(Defined {
            effect: id,
            unit: effect.unit().to_owned(),
            largest,
            coefficient: fit.coefficient,
            explained: fit.explained,
            x: attachments.put(mean(|pair| pair.0)),
            y: attachments.put(mean(|pair| pair.1)),
            model: ModelText { name: request.model.name.clone(), text },
        }),
    })
}

/// The effect defined in a model's text, and the text.
fn definition(text: &str, id: &str) -> Result<(EffectId, String), ModelError> {
    let model = Model::parse(text)?;
    let found = model.definitions().iter().find(|effect| effect.name() == id).copied();
    found.map(|effect| (effect, text.to_owned())).ok_or_else(|| ModelError::Value {
        key: "id".to_owned(),
        found: id.to_owned(),
        expected: "the id of a definition",
    })
}

/// An id made from what the formula acts on and reads, as for a law; numbered if the model already has it.
fn own_id(on: &str, formula: Option<&Formula>, text: &str) -> String {
    const LONGEST: usize = 36;
    let subject = match on {
        "imu_slave" | "imu_master" => "imu",
        "every sensor" => "all",
        other => other,
    };
    let reads = formula.map_or_else(Vec::new, |formula| {
        let known = formula.signals().iter().flat_map(|signal| signal.needs()).map(|name| (*name).to_owned());
        known.chain(formula.columns().iter().cloned()).collect::<Vec<String>>()
    });
    let mut words = String::new();
    for name in &reads {
        let next = if words.is_empty() { name.clone() } else { format!("{words}_by_{name}") };
        if subject.len() + 1 + next.len() <= LONGEST {
            words = next;
        }
    }
    let is_word = words.starts_with(|letter: char| letter.is_ascii_alphabetic());
    let base = format!("{subject}.{}", if is_word { words.to_ascii_lowercase() } else { "own".to_owned() });
    let is_taken = |id: &str| text.contains(&format!("\"{id}\"")) || EffectId::from_name(id).is_some();
    let numbered = (2..100).map(|number| format!("{base}_{number}"));
    std::iter::once(base.clone()).chain(numbered).find(|id| !is_taken(id)).unwrap_or(base)
}

fn has(flight: &Flight, column: &str) -> bool {
    let extra = flight.extra.iter().any(|(name, _)| name == column);
    extra || Channel::from_name(column).is_some_and(|channel| flight.channel(channel).is_some())
}

/// An error with its position, as JavaScript counts.
fn problem(error: ModelError, regressor: &str) -> FormulaProblem {
    let (message, span) = match error {
        ModelError::Formula { error, .. } => {
            let FormulaError { message, span, .. } = *error;
            (message, span)
        }
        other => (other.to_string(), 0..regressor.len()),
    };
    placed(message, &span, regressor)
}

fn missing(column: &str, regressor: &str) -> FormulaProblem {
    let is_part = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let is_whole = |start: usize| {
        let before = regressor.get(..start).and_then(|text| text.chars().next_back());
        let behind = regressor.get(start + column.len()..).and_then(|text| text.chars().next());
        !before.is_some_and(is_part) && !behind.is_some_and(is_part)
    };
    let found = regressor.match_indices(column).map(|(start, _)| start).find(|start| is_whole(*start));
    let span = found.map_or(0..regressor.len(), |start| start..start + column.len());
    placed(format!("This flight has no column '{column}'."), &span, regressor)
}

fn placed(message: String, span: &Range<usize>, regressor: &str) -> FormulaProblem {
    FormulaProblem { message, from: utf16(regressor, span.start), to: utf16(regressor, span.end) }
}

fn utf16(text: &str, bytes: usize) -> u32 {
    text.get(..bytes).unwrap_or(text).encode_utf16().count() as u32
}

/// A least-squares fit with a constant.
#[derive(Debug, PartialEq)]
struct Fit {
    coefficient: f64,
    /// Explained share of the variance.
    explained: f64,
}

impl Fit {
    /// `None` if the first value of the pairs is constant within rounding, or there are too few pairs.
    fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        if pairs.len() < FEWEST {
            return None;
        }
        let count = pairs.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
        let (mean_x, mean_y) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let (mut xx, mut xy, mut yy, mut largest) = (0.0, 0.0, 0.0, 0.0_f64);
        for (x, y) in pairs {
            let (dx, dy) = (x - mean_x, y - mean_y);
            xx += dx * dx;
            xy += dx * dy;
            yy += dy * dy;
            largest = largest.max(x.abs());
        }
        let rounding = largest * f64::from(f32::EPSILON);
        if !(xx / count > rounding * rounding && xy.is_finite()) {
            return None;
        }
        let explained = if yy > 0.0 { xy * xy / (xx * yy) } else { 0.0 };
        Some(Self { coefficient: xy / xx, explained })
    }
}

/// Divides this many values into blocks of equal length, at most as many blocks as points are drawn.
fn blocks(values: usize) -> Vec<Range<usize>> {
    let length = values.div_ceil(POINTS).max(1);
    (0..values).step_by(length).map(|start| start..(start + length).min(values)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_and_a_constant_is_not() {
        let line: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), 3.0 - 0.5 * f64::from(k))).collect();
        let fit = Fit::of(&line).unwrap();
        assert!((fit.coefficient + 0.5).abs() < 1e-12 && (fit.explained - 1.0).abs() < 1e-12, "{fit:?}");
        // Half of the values have the opposite sign.
        let crossed: Vec<(f64, f64)> = line.iter().flat_map(|(x, y)| [(*x, *y), (*x, -*y)]).collect();
        let fit = Fit::of(&crossed).unwrap();
        assert!(fit.coefficient.abs() < 1e-12 && fit.explained < 1e-12, "{fit:?}");
        let constant: Vec<(f64, f64)> = (0..100).map(|k| (7.0 + 1e-8 * f64::from(k), f64::from(k))).collect();
        assert_eq!(Fit::of(&constant), None);
        assert_eq!(Fit::of(&line[..5]), None);
    }

    #[test]
    fn a_place_is_counted_as_javascript_does_and_names_are_whole() {
        let of = |text: &str| {
            let problem = missing("flap", text);
            (problem.from, problem.to)
        };
        assert_eq!(of("flaps + 2*flap"), (10, 14));
        assert_eq!(utf16("é𝄞x", "é𝄞".len()), 3);
        assert_eq!(blocks(1_000).len(), 334);
        assert_eq!(blocks(1_000).last(), Some(&(999..1_000)));
    }
}
