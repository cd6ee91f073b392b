//! The catalogue of effects, explained: [`analysis::effect_guide`], as text.

mod picture;

use std::fmt::Write as _;

use kf_core::effect::{EffectId, Parts};
use kf_core::formula::MAX_OPS;
use model::{Board, Model};

pub use analysis::effect_guide::{Explanation, explanation};
pub use picture::Picture;

/// Effects with exactly this name, or else those whose name begins with it (`baro` for all of the
/// barometer's).
#[must_use]
pub fn named(model: &Model, name: &str) -> Vec<EffectId> {
    let exact = model.effect_named(name);
    let of_subject = || {
        let prefix = format!("{}.", name.trim_end_matches('.'));
        model.catalogue().filter(|effect| effect.name().starts_with(&prefix)).collect()
    };
    exact.map_or_else(of_subject, |effect| vec![effect])
}

/// The effect whose name is nearest to an unknown one, if any is near.
#[must_use]
pub fn nearest(model: &Model, name: &str) -> Option<&'static str> {
    let distance = |effect: &EffectId| strsim::osa_distance(name, effect.name());
    let nearest = model.catalogue().min_by_key(distance)?;
    (distance(&nearest) <= nearest.name().len() / 3).then(|| nearest.name())
}

fn range(effect: EffectId) -> String {
    let [least, most] = effect.plausible();
    let unit = if effect.unit() == "1" { String::new() } else { format!(" {}", effect.unit()) };
    format!("{least} to {most}{unit}")
}

/// The catalogue and the model's own effects, one line each.
#[must_use]
pub fn list(model: &Model) -> String {
    let width = |text: fn(EffectId) -> usize| model.catalogue().map(text).max().unwrap_or(0);
    let (names, ranges) = (width(|effect| effect.name().len()), width(|effect| range(effect).len()));
    let mut text = format!("{:names$}  {:ranges$}  what it is\n", "effect", "plausible");
    for effect in model.catalogue() {
        let own = || effect.formula().map_or("", |parts| parts.about);
        let what = explanation(effect).map_or_else(own, |explanation| explanation.what);
        let _ = writeln!(text, "{:names$}  {:ranges$}  {what}", effect.name(), range(effect));
    }
    text + "\n'pylon effects NAME' explains one: its formula, the columns that it needs, and what it looks like.\n"
}

/// One of the model's own effects, explained.
fn defined(model: &Model, effect: EffectId, parts: &Parts) -> String {
    let name = effect.name();
    let columns = model.columns().iter().filter(|column| parts.needs.contains(&column.name()));
    let units: String = columns.map(|column| format!("               {}\n", column.unit_said())).collect();
    let has = |board| model.check_signals_of(effect, board).is_ok();
    let flies = match (has(Board::Recorded), has(Board::F405)) {
        (true, true) => "on every board",
        (true, false) => {
            "in QEMU and where a vehicle delivers its signals; the F405 board's own sensors do not"
        }
        _ => "on no flight computer: not all of its columns are available there; for analysis only",
    };
    format!(
        "{name}, on {subject}, by formula of the model\n  {about}\n\n  adds         coefficient x {law}\n  coefficient  {unit}, \
         plausibly {range}\n  needs        {needs}\n{units}  takes        {ops} operations of {most} and {words} numbers of memory\n  \
         flies        {flies}\n\nWhether a flight has it: pylon diagnose FLIGHT --model MODEL.toml. To learn it: pylon add {name} \
         --model MODEL.toml --from FLIGHT.\n",
        subject = effect.subject().name(),
        about = if parts.about.is_empty() { "(the model does not describe it)" } else { parts.about },
        law = parts.law,
        unit = if effect.unit() == "1" { "a number" } else { effect.unit() },
        range = range(effect),
        needs = if parts.needs.is_empty() { "nothing but time".to_owned() } else { parts.needs.join(", ") },
        ops = parts.program.ops().len(),
        most = MAX_OPS,
        words = parts.program.state_words(),
    )
}

/// One effect, explained.
#[must_use]
pub fn explained(model: &Model, effect: EffectId) -> String {
    if let Some(parts) = effect.formula() {
        return defined(model, effect, parts);
    }
    let needs =
        if effect.needs().is_empty() { "nothing but time".to_owned() } else { effect.needs().join(", ") };
    let Some(Explanation { what, formula, source, looks_like }) = explanation(effect) else {
        return format!("{}\n", effect.name());
    };
    let name = effect.name();
    format!(
        "{name}, on {subject}\n  {what}\n\n  adds         coefficient x {formula}\n  coefficient  {unit}, plausibly {range}\n  \
         because      {source}\n  needs        {needs}\n  looks like   {looks_like}\n\nWhether a flight has it: pylon diagnose \
         FLIGHT. To learn it: pylon add {name} --model MODEL.toml --from FLIGHT.\n",
        subject = effect.subject().name(),
        unit = if effect.unit() == "1" { "a number" } else { effect.unit() },
        range = range(effect),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_of_the_catalogue_is_explained_once() {
        let mut seen = std::collections::BTreeSet::new();
        for effect in EffectId::ALL {
            let found = explanation(effect).unwrap_or_else(|| panic!("{} is not explained", effect.name()));
            assert!(seen.insert(found.what), "{}", effect.name());
            for sentence in [found.what, found.looks_like] {
                assert!(sentence.ends_with('.') && !sentence.trim_end_matches('.').is_empty(), "{sentence}");
            }
            let text = explained(&Model::default(), effect);
            for part in [effect.name(), found.formula, &range(effect)] {
                assert!(text.contains(part), "{part}: {text}");
            }
            effect.needs().iter().for_each(|column| assert!(text.contains(column), "{column}: {text}"));
            assert_eq!(
                list(&Model::default())
                    .lines()
                    .filter(|line| line.starts_with(&format!("{} ", effect.name())))
                    .count(),
                1
            );
        }
    }

    #[test]
    fn a_name_is_one_effect_or_all_of_a_sensors() {
        let model = Model::default();
        assert_eq!(named(&model, "baro.lag"), [EffectId::BaroLag]);
        assert_eq!(named(&model, "gps").len(), 3);
        assert_eq!(named(&model, "lag"), []);
        assert_eq!((nearest(&model, "baro.lga"), nearest(&model, "weather")), (Some("baro.lag"), None));
    }
}
