//! The firmware's copy of a model is the host's model, bit for bit.

mod sources;

use kf_core::config::{MissionConfig, SecondCorrection};
use kf_core::effect::EffectTerm;
use model::{Model, Shape};

macro_rules! generated {
    ($($name:ident),*) => {
        $(mod $name {
            include!(concat!(env!("OUT_DIR"), "/", stringify!($name), ".rs"));
        })*
    };
}

generated!(default, paper, estimated, constant);

/// Every float as bits (so that -0 is not 0), everything else by value.
fn bits<const E: usize>(config: &MissionConfig<E>) -> (Vec<u32>, String) {
    let reference = &config.reference;
    let quality = &config.quality;
    let rate = reference.climb_rate;
    let mut floats = vec![
        config.settling_s,
        reference.sigma_m,
        reference.correlation_time_s,
        reference.prior_altitude_m.unwrap_or(f32::NAN),
        reference.prior_sigma_m,
        rate.map_or(f32::NAN, |rate| rate.sigma_mps),
        rate.map_or(f32::NAN, |rate| rate.correlation_time_s),
        reference.lost_after_s,
        config.monitor.multiplier,
        config.monitor.window_s,
        quality.minimum_duration_s,
        quality.trimmed_altitude_m,
        quality.trimmed_airspeed_mps,
        quality.reference_drift_m,
        quality.vertical_accuracy_m,
        quality.bias_drift_sigmas,
        quality.implausible_share,
    ];
    for sensor in &config.sensors {
        floats.extend([sensor.sigma_m, sensor.correlation_time_s, sensor.prior_bias_m]);
        floats.extend([sensor.prior_sigma_m, sensor.wander_m_per_sqrt_s]);
    }
    let effects: Vec<&EffectTerm> = config.estimated_effects.iter().chain(&config.constant_effects).collect();
    floats.push(config.latitude_deg);
    floats.extend(effects.iter().flat_map(|effect| {
        let [least, largest] = effect.envelope_m.unwrap_or([f32::NAN; 2]);
        [effect.coefficient, effect.sigma, effect.regressor.time_constant_s, least, largest]
    }));
    if let SecondCorrection::Kalman { wander_m_per_sqrt_s } = config.second_correction {
        floats.push(wander_m_per_sqrt_s);
    }
    let names: Vec<_> =
        effects.iter().map(|effect| (effect.id().name(), effect.regressor.since.name())).collect();
    let rest = format!(
        "{:?} {:?} {} {names:?}",
        config.monitor.sigma, config.second_correction, quality.minimum_satellites
    );
    (floats.into_iter().map(f32::to_bits).collect(), rest)
}

macro_rules! same_as_host {
    ($name:ident, $text:ident) => {
        #[test]
        fn $name() {
            let model = Model::parse(sources::$text).unwrap();
            let shape =
                Shape { head: super::$name::HEAD, tail: super::$name::TAIL, effects: super::$name::EFFECTS };
            assert_eq!(shape, model.shape());
            assert_eq!(super::$name::FINGERPRINT, model.fingerprint().unwrap());
            let host = model.mission_config::<{ super::$name::EFFECTS }>().unwrap();
            let generated = super::$name::mission_config();
            assert_eq!(generated, host);
            assert_eq!(bits(&generated), bits(&host));
        }
    };
}

mod models {
    use super::{Model, Shape, bits, sources};
    same_as_host!(default, DEFAULT);
    same_as_host!(paper, PAPER);
    same_as_host!(estimated, ESTIMATED);
    same_as_host!(constant, CONSTANT);
}
