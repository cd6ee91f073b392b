//! The catalogue of effects, explained: [`analysis::effect_guide`], as text.

mod picture;

use std::fmt::Write as _;

use kf_core::effect::EffectId;

pub use analysis::effect_guide::{Explanation, explanation};
pub use picture::Picture;

/// The effects whose names are that one, or begin with it (`baro` for all of the barometer's).
#[must_use]
pub fn named(name: &str) -> Vec<EffectId> {
    let exact = EffectId::from_name(name);
    let of_subject = || {
        let prefix = format!("{}.", name.trim_end_matches('.'));
        EffectId::ALL.into_iter().filter(|effect| effect.name().starts_with(&prefix)).collect()
    };
    exact.map_or_else(of_subject, |effect| vec![effect])
}

/// What stands for an effect's name that is none, if one is near.
#[must_use]
pub fn nearest(name: &str) -> Option<&'static str> {
    let distance = |effect: &EffectId| strsim::osa_distance(name, effect.name());
    let nearest = EffectId::ALL.into_iter().min_by_key(distance)?;
    (distance(&nearest) <= nearest.name().len() / 3).then(|| nearest.name())
}

fn range(effect: EffectId) -> String {
    let [least, most] = effect.plausible();
    let unit = if effect.unit() == "1" { String::new() } else { format!(" {}", effect.unit()) };
    format!("{least} to {most}{unit}")
}

/// The catalogue, a line an effect.
#[must_use]
pub fn list() -> String {
    let width = |text: fn(EffectId) -> usize| EffectId::ALL.into_iter().map(text).max().unwrap_or(0);
    let (names, ranges) = (width(|effect| effect.name().len()), width(|effect| range(effect).len()));
    let mut text = format!("{:names$}  {:ranges$}  what it is\n", "effect", "plausible");
    for effect in EffectId::ALL {
        let what = explanation(effect).map_or("", |explanation| explanation.what);
        let _ = writeln!(text, "{:names$}  {:ranges$}  {what}", effect.name(), range(effect));
    }
    text + "\n'pylon effects NAME' explains one: its formula, the columns that it needs, and what it looks like.\n"
}

/// One effect, explained.
#[must_use]
pub fn explained(effect: EffectId) -> String {
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
            let text = explained(effect);
            for part in [effect.name(), found.formula, &range(effect)] {
                assert!(text.contains(part), "{part}: {text}");
            }
            effect.needs().iter().for_each(|column| assert!(text.contains(column), "{column}: {text}"));
            assert_eq!(
                list().lines().filter(|line| line.starts_with(&format!("{} ", effect.name()))).count(),
                1
            );
        }
    }

    #[test]
    fn a_name_is_one_effect_or_all_of_a_sensors() {
        assert_eq!(named("baro.lag"), [EffectId::BaroLag]);
        assert_eq!(named("gps").len(), 3);
        assert_eq!(named("lag"), []);
        assert_eq!((nearest("baro.lga"), nearest("weather")), (Some("baro.lag"), None));
    }
}
