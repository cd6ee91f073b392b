//! A flight and its name, and the block means that have been computed for it.

use std::sync::OnceLock;

use executor::Executor;
use replay::Replay;

use super::candidates::{Candidate, candidates};
use super::epochs::Epochs;
use super::from_replay::{Measured, epochs};
use super::physical_range::measures_climb_rate;

/// A flight ready to be replayed, and the user's name for it.
pub struct NamedReplay<'a> {
    /// The file.
    pub file: String,
    /// The flight, the model and the calibration.
    pub replay: Replay<'a>,
    kept: OnceLock<BlockMeans>,
}

/// The means of every candidate that a diagnosis of this flight alone would try.
struct BlockMeans {
    candidates: Vec<Candidate>,
    epochs: Epochs,
}

impl<'a> NamedReplay<'a> {
    /// A replay with a name.
    #[must_use]
    pub const fn new(file: String, replay: Replay<'a>) -> Self {
        Self { file, replay, kept: OnceLock::new() }
    }

    /// The first of the diagnosis' two passes over the flight, which can observe a pass made for another
    /// purpose. `None` where block means are kept already.
    #[must_use]
    pub fn measuring(&self) -> Option<Measured> {
        self.kept.get().is_none().then(|| Measured::of(&self.replay))
    }

    /// Computes the block means from that pass, and keeps them for every diagnosis of this flight.
    pub fn keep(&self, measured: Measured, executor: &dyn Executor) {
        self.kept.get_or_init(|| {
            let candidates = self.own_candidates();
            let epochs = measured.epochs(&self.replay, &candidates, executor);
            BlockMeans { candidates, epochs }
        });
    }

    /// Computes the block means and keeps them, unless this has been done.
    pub(super) fn keep_all(&self, executor: &dyn Executor) {
        self.kept.get_or_init(|| {
            let candidates = self.own_candidates();
            let epochs = epochs(&self.replay, &candidates, executor);
            BlockMeans { candidates, epochs }
        });
    }

    /// The block means of these candidates: the kept ones if they include all of them, else new ones.
    pub(super) fn epochs(&self, candidates: &[Candidate], executor: &dyn Executor) -> Epochs {
        let kept = self.kept.get().and_then(|kept| {
            let place = |candidate: &Candidate| kept.candidates.iter().position(|other| other == candidate);
            let places: Option<Vec<usize>> = candidates.iter().map(place).collect();
            Some(kept.epochs.of_columns(&places?))
        });
        kept.unwrap_or_else(|| epochs(&self.replay, candidates, executor))
    }

    /// Together with flights that lack a measured climb rate, some of these are not tried, but no others are.
    fn own_candidates(&self) -> Vec<Candidate> {
        let (tried, known) = candidates(self.replay.model(), measures_climb_rate(&self.replay), None);
        [tried, known].concat()
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use executor::Inline;
    use kf_core::effect::EffectId;
    use model::Model;

    use super::*;
    use crate::diagnose::delay::DelayShape;

    /// A minute at 10 Hz, launched halfway.
    fn flight() -> flight_data::Flight {
        let header = "time_s,launch,gps_alt_m,gps_vn_mps,gps_ve_mps,gps_vd_mps,baro_alt_m";
        let mut csv = format!("# pylon-flight: 1\n{header}\n");
        for k in 0..600_u32 {
            let t = 0.1 * f64::from(k);
            let (gained_m, climb_mps) = (60.0 * (1.0 - (t / 9.0).cos()), 60.0 / 9.0 * (t / 9.0).sin());
            let (launch, baro_m) = (u8::from(k >= 300), gained_m - 0.7 * climb_mps);
            let _ = writeln!(csv, "{t:.3},{launch},{gained_m:.3},30,0,{:.3},{baro_m:.3}", -climb_mps);
        }
        flight_data::parse(csv.as_bytes()).unwrap().0
    }

    #[test]
    fn block_means_that_were_kept_are_those_that_would_be_made_anew() {
        let (flight, model) = (flight(), Model::default());
        let named = || NamedReplay::new("a".to_owned(), Replay::to_diagnose(&flight, &model, None).unwrap());
        let kept = named();
        kept.keep_all(&Inline);
        // All of them, and those that are tried together with a flight that lacks the climb rate.
        for has_climb_rate in [true, false] {
            let (asked, _) = candidates(&model, has_climb_rate, None);
            let (from_kept, anew) = (kept.epochs(&asked, &Inline), named().epochs(&asked, &Inline));
            assert_eq!(format!("{from_kept:?}"), format!("{anew:?}"));
            assert!(anew.available.contains(&true) && anew.available.contains(&false));
            assert_eq!(anew.series.columns.len(), asked.len());
        }
        // Block means that were not kept are computed: a lag in a shape that is not the catalogue's.
        let mut other = kept.own_candidates();
        let lag = other.iter().position(|candidate| candidate.effect() == EffectId::BaroLag).unwrap();
        other[lag].delay = DelayShape::LowPass(0.375);
        let (found, anew) = (kept.epochs(&other, &Inline), named().epochs(&other, &Inline));
        assert_eq!(format!("{found:?}"), format!("{anew:?}"));
    }
}
