//! The models and effects that come with Pylon, and the contents of a model.

use analysis::effect_guide::explanation;
use kf_core::effect::EffectId;
use model::Model;

use crate::headline::title;
use crate::protocol::{EffectGuide, ModelFacts, ModelText, Preset, RevisionFacts, TermFacts};

/// The built-in models.
pub fn presets() -> Vec<Preset> {
    let preset = |name: &str, text: &str, about: &str| Preset {
        model: ModelText { name: name.to_owned(), text: text.to_owned() },
        about: about.to_owned(),
    };
    vec![
        preset("default", "", "Today's small sensors and GPS, without any effect."),
        preset(
            "paper",
            include_str!("../../../../flights/models/paper.toml"),
            "The paper's own: its sensors' noise, and its rule for the monitor.",
        ),
    ]
}

/// The contents of a model.
pub fn facts(model: &Model) -> ModelFacts {
    let effects = model.effects.iter().map(|effect| {
        let id = effect.term.id();
        let has_time = id.has_time_constant();
        TermFacts {
            effect: id.name().to_owned(),
            coefficient: effect.term.coefficient.into(),
            sigma: effect.term.sigma.into(),
            unit: id.unit().to_owned(),
            estimate: effect.estimate,
            time_constant_s: has_time.then(|| effect.term.regressor.time_constant_s.into()),
            since: has_time.then(|| effect.term.regressor.since.name().to_owned()),
            learned_from: effect.learned_from.clone(),
            date: effect.date.clone(),
        }
    });
    let revisions = model.revisions.iter().map(|revision| RevisionFacts {
        number: revision.number,
        effect: revision.effect.map(|effect| effect.name().to_owned()),
        date: revision.date.clone(),
    });
    ModelFacts { effects: effects.collect(), revisions: revisions.collect(), warnings: model.warnings() }
}

/// The catalogue of effects.
pub fn effects() -> Vec<EffectGuide> {
    let guide = |effect: EffectId| {
        let explained = explanation(effect)?;
        Some(EffectGuide {
            effect: effect.name().to_owned(),
            subject: effect.subject().name().to_owned(),
            title: title(effect.name()).to_owned(),
            what: explained.what.to_owned(),
            formula: explained.formula.to_owned(),
            unit: effect.unit().to_owned(),
            plausible: effect.plausible().map(f64::from),
            source: explained.source.to_owned(),
            looks_like: explained.looks_like.to_owned(),
            needs: effect.needs().iter().map(|column| (*column).to_owned()).collect(),
            has_time_constant: effect.has_time_constant(),
        })
    };
    EffectId::ALL.into_iter().filter_map(guide).collect()
}
