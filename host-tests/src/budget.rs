//! Budgets of the firmware (`firmware/budgets.toml`): measured values and their limits.

use std::fmt::Display;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use flight_computer::Part;
use model::Model;
use pylon::fly::{Board, FlyReport, Image, Program, build};
use serde::{Deserialize, Serialize};

use crate::bench::{Row, cheapest_peer, named};

/// The benchmark's name for the filter with the monitors.
const FILTER_AND_MONITORS: &str = "kf-core filter and monitors";
/// The benchmark's name for the filter with eight states.
const FILTER_4_EFFECTS: &str = "kf-core filter 4 effects";
/// The benchmark's names for formulas, each with its number of operations: a typical effect, all operations
/// that are the machine's own, and all operations with a memory.
const FORMULA_EFFECT: (&str, f64) = ("formula effect of 9 operations", 9.0);
const FORMULA_ARITHMETIC: (&str, f64) = ("formula arithmetic of 24 operations", 24.0);
const FORMULA_MEMORY: (&str, f64) = ("formula memory of 17 operations", 17.0);

/// Effects by formula over what the board measures, as a user writes them, each with its unit and its sigma:
/// a static port that reads differently in turns, a rotor's wash at low speed, a heater in the bay, a slow
/// pressure line.
const FORMULAS: [(&str, &str, &str, &str, f64); 4] = [
    ("baro.port_in_turns", "baro", "airspeed_mps^2 / (2*g) * (load_factor - 1) * step(launch)", "1", 0.1),
    ("baro.rotor_wash", "baro", "max(20[m/s] - airspeed_mps, 0) * step(launch)", "s", 0.1),
    ("baro.bay_heater", "baro", "baro_temp_c - captive(baro_temp_c)", "m/K", 0.3),
    ("baro.slow_line", "baro", "lowpass(climb_rate_mps, 2[s])", "s", 0.3),
];

/// Like [`FORMULAS`], with the most expensive functions: a delay on the reference, a double integral from
/// launch on, a threshold, and one with a density, an exponential, a rate and a mean. Together they have 43
/// operations and 42 of the 48 numbers that four may remember.
const EXPENSIVE_FORMULAS: [(&str, &str, &str, &str, f64); 4] = [
    ("gps.late_climb", "gps", "delay(climb_rate_mps, 0.4[s])", "s", 0.3),
    ("imu.cross_axis", "imu_slave", "integral2(lowpass(accel_x_mps2, 0.5[s]) * gyro_y_radps)", "s/rad", 0.02),
    (
        "baro.loaded_port",
        "baro",
        "airspeed_mps^2 / (2*g) * lowpass(max(load_factor - 1, 0), 2[s]) * step(launch)",
        "1",
        0.1,
    ),
    (
        "baro.heated_line",
        "baro",
        "isa_density(altitude_m) / isa_density(at_launch(altitude_m)) * exp((baro_temp_c - captive(baro_temp_c)) / 30[K]) \
         * rate(lowpass(airspeed_mps^2, 3[s]))",
        "s^3/m",
        0.01,
    ),
];

/// The models that the budgets apply to: both presets, one with four effects as states, and two with four
/// effects by formula as states.
///
/// The catalogue's four are expensive: two on the reference, whose own row of H then has no zeros to skip,
/// one that is integrated from launch on, one with a low pass. For those by formula see `FORMULAS` and
/// `EXPENSIVE_FORMULAS`.
///
/// # Errors
/// The model is invalid.
pub fn models() -> Result<[(&'static str, Model); 5]> {
    let effects = [("gps.lever_arm", 2.0), ("gps.latency", 0.3), ("imu.tilt", 0.02), ("baro.lag", 0.3)].map(
        |(id, sigma)| {
            format!("[[effect]]\nid = \"{id}\"\ncoefficient = 0.0\nsigma = {sigma}\nestimate = true\n")
        },
    );
    let four_effects = Model::parse(&effects.concat()).context("the model with four effects")?;
    let by_formula = |formulas: &[(&str, &str, &str, &str, f64); 4]| {
        let texts = formulas.map(|(id, on, regressor, unit, sigma)| {
            format!(
                "[[effect_definition]]\nid = \"{id}\"\non = \"{on}\"\nregressor = \"{regressor}\"\nunit = \"{unit}\"\n\
                 plausible = [-1, 1]\n\
                 [[effect]]\nid = \"{id}\"\ncoefficient = 0.0\nsigma = {sigma}\nestimate = true\n"
            )
        });
        Model::parse(&texts.concat())
    };
    let four_formulas = by_formula(&FORMULAS).context("the model with four formulas")?;
    let four_expensive = by_formula(&EXPENSIVE_FORMULAS).context("the model with four expensive formulas")?;
    Ok([
        ("default", Model::default()),
        ("paper", Model::paper()),
        ("four effects", four_effects),
        ("four formulas", four_formulas),
        ("four expensive formulas", four_expensive),
    ])
}

/// The budgets; the file explains each.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budgets {
    /// Sizes of the flight computer's image.
    pub image: ImageBudget,
    /// An emulated flight.
    pub flight: FlightBudget,
    /// A restart in flight.
    pub restart: RestartBudget,
    /// The image that contains only the mission's tick.
    pub core_only: SymbolBudget,
    /// The image that contains only the drivers and the mission.
    pub chain_only: SymbolBudget,
    /// The benchmark.
    pub bench: BenchBudget,
    /// Values known to exceed their budgets.
    #[serde(default)]
    pub known_excess: Vec<KnownExcess>,
}

/// A known and documented excess over a budget; it may not grow.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownExcess {
    /// Name of the measured value, as [`Check::what`].
    pub what: String,
    /// Limit on the excess: nothing beyond it is accepted.
    pub limit: f64,
}

/// Sizes of the flight computer's image.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageBudget {
    /// Flash, bytes.
    pub flash_bytes: u64,
    /// Flash of the emulated board, which includes the models of its chips, bytes.
    pub emulated_flash_bytes: u64,
    /// RAM of static variables, bytes.
    pub static_ram_bytes: u64,
}

/// An emulated flight.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlightBudget {
    /// High-water mark of the stack, bytes.
    pub stack_bytes: u32,
    /// Mean instructions of a tick.
    pub instructions_mean: f64,
    /// Instructions of the most expensive tick.
    pub instructions_worst: u32,
    /// Instructions of the most expensive tick's telemetry.
    pub messages_instructions_worst: u32,
    /// Largest difference in instructions between the start of one tick on its grid and another's.
    pub start_jitter_instructions: u64,
}

/// A restart in flight.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RestartBudget {
    /// Instructions from the reset until the first tick can come.
    pub instructions: u32,
    /// High-water mark of the stack, bytes.
    pub stack_bytes: u32,
}

/// Symbols that an image may not be linked with.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SymbolBudget {
    /// Parts of names that no symbol may contain.
    pub forbidden_symbols: Vec<String>,
}

/// The benchmark; instructions of one tick, mean.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BenchBudget {
    /// Four states, four measurements, two monitors.
    pub filter_and_monitors: f64,
    /// Eight states, four measurements.
    pub filter_4_effects: f64,
    /// Least ratio of the cheapest peer's cost to that of the filter with the monitors.
    pub times_cheaper: f64,
    /// Limit for one operation of a formula.
    pub formula_operation: f64,
}

/// One measured value and its budget.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Check {
    /// Name of the measured value.
    pub what: String,
    /// The measured value.
    pub measured: String,
    /// Its limit.
    pub budget: String,
    /// Whether the budget is met.
    pub kept: bool,
}

impl Check {
    /// One line, for those who want to see the measured value.
    #[must_use]
    pub fn line(&self) -> String {
        format!("{}: {} ({})", self.what, self.measured, self.budget)
    }

    fn at_most<T: PartialOrd + Display>(what: impl Into<String>, measured: T, budget: T) -> Self {
        let kept = measured <= budget;
        Self { what: what.into(), measured: measured.to_string(), budget: format!("<= {budget}"), kept }
    }

    fn at_least<T: PartialOrd + Display>(what: impl Into<String>, measured: T, budget: T) -> Self {
        let kept = measured >= budget;
        Self { what: what.into(), measured: measured.to_string(), budget: format!(">= {budget}"), kept }
    }
}

impl Budgets {
    /// Reads the budgets from the file.
    ///
    /// # Errors
    /// The file is missing or invalid.
    pub fn read() -> Result<Self> {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware/budgets.toml");
        let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        toml::from_str(&text).with_context(|| file.display().to_string())
    }

    /// Builds the flight computer's images for all boards with every model, and the image of the mission's
    /// tick alone, and checks them.
    ///
    /// # Errors
    /// An image does not build.
    pub fn check_images(&self) -> Result<Vec<Check>> {
        let mut checks = Vec::new();
        for (preset, model) in models()? {
            for board in [Board::Qemu, Board::Hil, Board::F405] {
                let image = Image::read(&build(Program::Flight(board), &model, None)?)?;
                let flash_bytes = match board {
                    Board::Qemu | Board::Hil => self.image.emulated_flash_bytes,
                    Board::F405 => self.image.flash_bytes,
                };
                let name = format!("flight image, {board:?}, {preset} model");
                checks.extend(self.image(&name, &image, flash_bytes));
            }
        }
        for (name, program, budget, ours) in [
            ("core-only", Program::CoreOnly, &self.core_only, &["kf_core"][..]),
            ("chain-only", Program::ChainOnly, &self.chain_only, &["kf_core", "drivers::umbilical"][..]),
        ] {
            let image = Image::read(&build(program, &Model::default(), None)?)?;
            checks.extend(budget.check(name, &image, ours));
        }
        Ok(checks)
    }

    /// Unexpected results, one line each: a budget that is not met without being a known excess, and an
    /// excess larger than known.
    #[must_use]
    pub fn unexpected(&self, checks: &[Check]) -> Vec<String> {
        let known = |check: &Check| self.known_excess.iter().find(|known| known.what == check.what);
        let line = |check: &Check| match (check.kept, known(check)) {
            (true, _) => None,
            (false, None) => Some(check.line()),
            (false, Some(known)) => {
                let is_no_worse = check.measured.parse::<f64>().is_ok_and(|measured| {
                    if check.budget.starts_with("<=") {
                        measured <= known.limit
                    } else {
                        measured >= known.limit
                    }
                });
                (!is_no_worse).then(|| format!("{}: worse than the known {}", check.line(), known.limit))
            }
        };
        checks.iter().filter_map(line).collect()
    }

    fn image(&self, name: &str, image: &Image, flash_bytes: u64) -> [Check; 3] {
        [
            Check::at_most(
                format!("{name}: contains paths of cargo's registry"),
                u32::from(image.names_registry),
                0_u32,
            ),
            Check::at_most(format!("{name}: flash, bytes"), image.flash_bytes, flash_bytes),
            Check::at_most(
                format!("{name}: static RAM, bytes"),
                image.static_ram_bytes,
                self.image.static_ram_bytes,
            ),
        ]
    }

    /// Checks an emulated flight.
    #[must_use]
    pub fn check_flight(&self, name: &str, report: &FlyReport) -> [Check; 5] {
        let budget = &self.flight;
        let messages = report.parts.iter().find(|part| part.part == Part::Messages);
        [
            Check::at_most(format!("{name}: stack, bytes"), report.stack_used_bytes, budget.stack_bytes),
            Check::at_most(
                format!("{name}: instructions a tick, mean"),
                report.instructions_mean.round(),
                budget.instructions_mean,
            ),
            Check::at_most(
                format!("{name}: instructions a tick, worst"),
                report.instructions_worst,
                budget.instructions_worst,
            ),
            Check::at_most(
                format!("{name}: instructions of a tick's messages, below it, worst"),
                messages.map_or(u32::MAX, |part| part.instructions_worst),
                budget.messages_instructions_worst,
            ),
            Check::at_most(
                format!("{name}: jitter of the tick's start, instructions"),
                report.start_jitter,
                budget.start_jitter_instructions,
            ),
        ]
    }

    /// Checks the most expensive tick of a sample of the fault campaign.
    #[must_use]
    pub fn check_campaign(&self, instructions_worst: u32) -> Check {
        let what = "fault campaign: instructions a tick, worst";
        Check::at_most(what, instructions_worst, self.flight.instructions_worst)
    }

    /// Checks the cost of a restart: instructions from the reset until the first tick can come, and bytes of
    /// the stack, which the flight after it hardly uses.
    #[must_use]
    pub fn check_restart(&self, instructions: u32, stack_used_bytes: u32) -> [Check; 2] {
        let what = "restart in free flight";
        [
            Check::at_most(format!("{what}: instructions"), instructions, self.restart.instructions),
            Check::at_most(format!("{what}: stack, bytes"), stack_used_bytes, self.restart.stack_bytes),
        ]
    }

    fn check_formula(&self, rows: &[Row], (name, operations): (&str, f64)) -> Result<Check> {
        let each = (named(rows, name)?.mean / operations * 10.0).round() / 10.0;
        Ok(Check::at_most(format!("{name}: instructions an operation"), each, self.bench.formula_operation))
    }

    /// Checks the benchmark.
    ///
    /// # Errors
    /// A row is missing.
    pub fn check_bench(&self, rows: &[Row]) -> Result<[Check; 6]> {
        let budget = &self.bench;
        let ours = named(rows, FILTER_AND_MONITORS)?;
        let peer = cheapest_peer(rows)?;
        let times = (peer.mean / ours.mean * 100.0).round() / 100.0;
        Ok([
            Check::at_most("filter and monitors: instructions a tick", ours.mean, budget.filter_and_monitors),
            Check::at_most(
                "filter with 4 effects: instructions a tick",
                named(rows, FILTER_4_EFFECTS)?.mean,
                budget.filter_4_effects,
            ),
            Check::at_least(
                format!("filter and monitors: times cheaper than the filter alone of {}", peer.name),
                times,
                budget.times_cheaper,
            ),
            self.check_formula(rows, FORMULA_EFFECT)?,
            self.check_formula(rows, FORMULA_ARITHMETIC)?,
            self.check_formula(rows, FORMULA_MEMORY)?,
        ])
    }
}

impl SymbolBudget {
    /// Checks an image, which must have symbols with each of these names: an empty image would meet every
    /// budget.
    fn check(&self, name: &str, image: &Image, ours: &[&str]) -> Vec<Check> {
        let check = |forbidden: &String| {
            let found: Vec<&str> = image
                .symbols
                .iter()
                .filter(|symbol| symbol.contains(forbidden))
                .map(String::as_str)
                .collect();
            Check {
                what: format!("{name} image: symbols with {forbidden}"),
                measured: if found.is_empty() { "none".to_owned() } else { found.join(", ") },
                budget: "none".to_owned(),
                kept: found.is_empty(),
            }
        };
        let present = ours.iter().map(|ours| {
            let is_there = image.symbols.iter().any(|symbol| symbol.contains(ours));
            Check {
                what: format!("{name} image: symbols of {ours}"),
                measured: if is_there { "some" } else { "none" }.to_owned(),
                budget: "some".to_owned(),
                kept: is_there,
            }
        });
        self.forbidden_symbols.iter().map(check).chain(present).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::Role;

    fn kept(checks: &[Check]) -> Vec<bool> {
        checks.iter().map(|check| check.kept).collect()
    }

    #[test]
    fn the_file_is_as_it_should_be() {
        let budgets = Budgets::read().unwrap();
        assert_eq!(
            budgets.image,
            ImageBudget {
                flash_bytes: 160 * 1024,
                emulated_flash_bytes: 184 * 1024 + 512,
                static_ram_bytes: 40 * 1024
            }
        );
        assert!(toml::from_str::<Budgets>("[image]\nflash_bytes = 1").is_err());
    }

    #[test]
    fn a_known_excess_may_get_no_worse() {
        let known = |what: &str, limit| KnownExcess { what: what.to_owned(), limit };
        let budgets =
            Budgets { known_excess: vec![known("a", 12.0), known("b", 2.0)], ..Budgets::read().unwrap() };
        let unexpected = |what: &str, measured: u32| {
            let least = what == "b";
            let check =
                if least { Check::at_least(what, measured, 3) } else { Check::at_most(what, measured, 10) };
            !budgets.unexpected(&[check]).is_empty()
        };
        assert_eq!([10, 11, 12, 13].map(|measured| unexpected("a", measured)), [false, false, false, true]);
        assert_eq!([1, 2, 3].map(|measured| unexpected("b", measured)), [true, false, false]);
        assert_eq!([10, 11].map(|measured| unexpected("c", measured)), [false, true]);
    }

    #[test]
    fn an_image_of_one_byte_too_many_is_found() {
        let budgets = Budgets::read().unwrap();
        let image = Image { flash_bytes: 163_840, static_ram_bytes: 40_960, ..Image::default() };
        assert_eq!(kept(&budgets.image("", &image, budgets.image.flash_bytes)), [true; 3]);
        let image = Image {
            flash_bytes: 163_841,
            static_ram_bytes: 40_961,
            names_registry: true,
            ..Image::default()
        };
        assert_eq!(kept(&budgets.image("", &image, budgets.image.flash_bytes)), [false; 3]);
    }

    #[test]
    fn a_restart_of_one_instruction_or_byte_too_many_is_found() {
        let budgets = Budgets::read().unwrap();
        assert_eq!(kept(&budgets.check_restart(200_000, 17_203)), [true, true]);
        assert_eq!(kept(&budgets.check_restart(200_001, 17_204)), [false, false]);
    }

    #[test]
    fn forbidden_symbols_and_an_empty_image_are_found() {
        let budgets = Budgets::read().unwrap();
        let image = |names: &[&str]| Image {
            symbols: names.iter().map(|&name| name.to_owned()).collect(),
            ..Image::default()
        };
        let all_kept = |image: &Image| {
            kept(&budgets.core_only.check("", image, &["kf_core"])).into_iter().all(|kept| kept)
        };
        assert!(all_kept(&image(&["kf_core::mission::Mission::tick", "__aeabi_f2ulz"])));
        assert!(!all_kept(&image(&["main"])));
        for forbidden in ["core::panicking::panic_fmt", "__aeabi_dmul", "libm::math::sqrt::sqrtf"] {
            assert!(!all_kept(&image(&["kf_core::mission::Mission::tick", forbidden])), "{forbidden}");
        }
    }

    #[test]
    fn a_filter_too_dear_or_not_cheap_enough_is_found() {
        let budgets = Budgets::read().unwrap();
        let row = |name: &str, role, mean| Row {
            name: name.to_owned(),
            role,
            mean,
            least: 0,
            most: 0,
            agrees: Some(true),
        };
        let rows = |monitored, effects, peer, operation: f64| {
            [
                row(FILTER_AND_MONITORS, Role::Ours, monitored),
                row(FILTER_4_EFFECTS, Role::Ours, effects),
                row("peer", Role::Peer, peer),
                row("reference", Role::Reference, 1.0),
                row(FORMULA_EFFECT.0, Role::Ours, operation * FORMULA_EFFECT.1),
                row(FORMULA_ARITHMETIC.0, Role::Ours, operation * FORMULA_ARITHMETIC.1),
                row(FORMULA_MEMORY.0, Role::Ours, operation * FORMULA_MEMORY.1),
            ]
        };
        let kept = |monitored, effects, peer, operation| {
            kept(&budgets.check_bench(&rows(monitored, effects, peer, operation)).unwrap())
        };
        assert_eq!(kept(250.0, 1_200.0, 750.0, 25.0), [true; 6]);
        assert_eq!(kept(250.5, 1_200.5, 749.0, 25.2), [false; 6]);
        assert!(budgets.check_bench(&[]).is_err());
    }
}
