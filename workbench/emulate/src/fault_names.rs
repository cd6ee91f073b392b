//! Names of chip faults, as a user writes them.

use chip_models::flown::{Chip, Fault, Quantity};

/// Every fault, as a user writes it.
pub(super) const FAULTS: &str = "stuck-low, stuck-high, bus-error, frozen, stalled, slow=MICROSECONDS, offset=BY[,QUANTITY], \
    vibration=HZ,AMPLITUDE[,QUANTITY], flip-prom=BYTE,MASK, unplugged, garbage=SEED, refuses, silent, held, no-fix, \
    stranger=METRES, lies=METRES, not-a-number, holds, torn, open, shorted, unreadable, bounces=MICROSECONDS, \
    cold-start=METRES,SECONDS[,dishonest] (START..END); reset, flip-bits=MASK[,AFTER], flip-register=ADDRESS,MASK, \
    flip-data=MASK[,RESULTS[,QUANTITY]], spike=BY[,RESULTS[,QUANTITY]], lose-bytes=COUNT, lose-conversions=COUNT, \
    generation-8=BAUD (START)";

/// One example of every fault that a chip can have.
const EXAMPLES: [&str; 33] = [
    "stuck-low",
    "stuck-high",
    "bus-error",
    "frozen",
    "slow=1",
    "stalled",
    "offset=1",
    "vibration=1,1",
    "flip-prom=0,1",
    "unplugged",
    "refuses",
    "silent",
    "held",
    "no-fix",
    "cold-start=1,1",
    "reset",
    "flip-bits=1",
    "flip-register=0,1",
    "flip-data=1",
    "spike=1",
    "lose-bytes=1",
    "lose-conversions=1",
    "generation-8=9600",
    "garbage=1",
    "stranger=1",
    "lies=1",
    "not-a-number",
    "holds",
    "torn",
    "open",
    "shorted",
    "unreadable",
    "bounces=1",
];

/// MAVLink system and component of an unknown sender on the umbilical.
const STRANGER: (u8, u8) = (42, 1);

/// Names of the quantities that chips measure; without a name, the chip's first one is meant.
const QUANTITIES: [(&str, Quantity); 12] = [
    ("pressure", Quantity::Pressure),
    ("temperature", Quantity::Temperature),
    ("accel-z", Quantity::Force(2)),
    ("accel-x", Quantity::Force(0)),
    ("accel-y", Quantity::Force(1)),
    ("gyro-x", Quantity::Rate(0)),
    ("gyro-y", Quantity::Rate(1)),
    ("gyro-z", Quantity::Rate(2)),
    ("altitude", Quantity::Altitude),
    ("velocity-north", Quantity::Velocity(0)),
    ("velocity-east", Quantity::Velocity(1)),
    ("velocity-down", Quantity::Velocity(2)),
];

/// The words after a fault's `=`, taken in order.
struct Words<'a> {
    chip: Chip,
    words: Vec<&'a str>,
    next: usize,
}

impl Words<'_> {
    fn word(&mut self) -> Option<&str> {
        let word = self.words.get(self.next).copied();
        self.next += 1;
        word
    }

    /// A whole number, decimal or, after 0x, hexadecimal.
    fn number(&mut self) -> Option<u32> {
        let word = self.word()?;
        word.strip_prefix("0x").map_or_else(|| word.parse().ok(), |hex| u32::from_str_radix(hex, 16).ok())
    }

    fn positive(&mut self) -> Option<u32> {
        self.number().filter(|number| *number > 0)
    }

    fn byte(&mut self) -> Option<u8> {
        self.number().and_then(|number| u8::try_from(number).ok())
    }

    fn mask(&mut self) -> Option<u8> {
        self.byte().filter(|mask| *mask != 0)
    }

    /// A number as thousandths, not zero; `None` beyond 32 bits.
    fn milli(&mut self) -> Option<i32> {
        let milli = (self.word()?.parse::<f64>().ok()? * 1_000.0).round();
        let fits = milli != 0.0 && milli.abs() <= f64::from(i32::MAX);
        fits.then_some(milli as i32)
    }

    /// The next word, if there is one; else the default.
    fn or<T>(&mut self, otherwise: T, take: impl FnOnce(&mut Self) -> Option<T>) -> Option<T> {
        if self.next < self.words.len() { take(self) } else { Some(otherwise) }
    }

    fn quantity(&mut self) -> Option<Quantity> {
        let chip = self.chip;
        let has = |quantity: Quantity| chip.can(Fault::Offset { quantity, by_milli: 1 });
        if self.next >= self.words.len() {
            // A chip that measures nothing cannot have this fault, whatever the quantity.
            return Some(QUANTITIES.iter().map(|(_, q)| *q).find(|q| has(*q)).unwrap_or(Quantity::Pressure));
        }
        let word = self.word()?;
        QUANTITIES.iter().find(|(name, _)| *name == word).map(|(_, quantity)| *quantity)
    }
}

/// A chip's fault from its name and the words after it.
pub(super) fn parse_fault(chip: Chip, text: &str) -> Option<Fault> {
    let (name, words) = text
        .split_once('=')
        .map_or((text, Vec::new()), |(name, words)| (name, words.split(',').map(str::trim).collect()));
    let mut words = Words { chip, words, next: 0 };
    let fault = named(name, &mut words)?;
    // No word may be left over.
    (words.next >= words.words.len()).then_some(fault)
}

fn named(name: &str, words: &mut Words<'_>) -> Option<Fault> {
    Some(match name {
        "stuck-low" => Fault::StuckLow,
        "stuck-high" => Fault::StuckHigh,
        "bus-error" => Fault::BusError,
        "stalled" => Fault::Stalled,
        "frozen" => Fault::Frozen,
        "unplugged" => Fault::Unplugged,
        "refuses" => Fault::Refuses,
        "silent" => Fault::Silent,
        "held" => Fault::Held,
        "no-fix" => Fault::NoFix,
        "not-a-number" => Fault::NotANumber,
        "holds" => Fault::Holds,
        "torn" => Fault::Torn,
        "open" => Fault::Open,
        "shorted" => Fault::Shorted,
        "unreadable" => Fault::Unreadable,
        "reset" => Fault::Reset,
        "slow" => Fault::Slow { by_us: words.positive()? },
        "lose-bytes" => Fault::LoseBytes { count: words.positive()? },
        "lose-conversions" => Fault::LoseConversions { count: words.positive()? },
        "generation-8" => Fault::Generation8 { baud: words.positive()? },
        "flip-bits" => Fault::FlipBits { mask: words.mask()?, after_bytes: words.or(0, Words::number)? },
        "flip-register" => Fault::FlipRegister { address: words.byte()?, mask: words.mask()? },
        "flip-prom" => Fault::FlipProm { byte: words.byte()?, mask: words.mask()? },
        "garbage" => Fault::Garbage { seed: words.number()? },
        "stranger" => {
            let (system, component) = STRANGER;
            Fault::Stranger { system, component, altitude_m: words.number()?.try_into().ok()? }
        }
        "lies" => Fault::Lies { by_m: words.number()?.try_into().ok()? },
        "bounces" => {
            let mean_us = words.positive()?;
            Fault::Bounces { open_us: mean_us, closed_us: mean_us, seed: mean_us }
        }
        "flip-data" => Fault::FlipData {
            mask: words.positive()?,
            results: words.or(1, Words::positive)?,
            quantity: words.quantity()?,
        },
        "spike" => Fault::Spike {
            by_milli: words.milli()?,
            results: words.or(1, Words::positive)?,
            quantity: words.quantity()?,
        },
        "offset" => Fault::Offset { by_milli: words.milli()?, quantity: words.quantity()? },
        "vibration" => Fault::Vibration {
            frequency_mhz: words.milli()?.try_into().ok()?,
            amplitude_milli: words.milli()?.try_into().ok()?,
            quantity: words.quantity()?,
        },
        "cold-start" => Fault::ColdStart {
            error_mm: words.milli()?,
            decay_s: words.positive()?.try_into().ok()?,
            is_honest: words.or(true, |words| (words.word()? == "dishonest").then_some(false))?,
        },
        _ => return None,
    })
}

/// The names of the faults that a chip can have.
pub(super) fn possible(chip: Chip) -> String {
    let can = |text: &&&str| parse_fault(chip, text).is_some_and(|fault| chip.can(fault));
    let names: Vec<&str> = EXAMPLES.iter().filter(can).filter_map(|text| text.split('=').next()).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read_and_said() {
        for text in EXAMPLES {
            let name = text.split('=').next().unwrap();
            assert!(FAULTS.split([' ', '=', ',']).any(|word| word == name), "{name} is not in the help");
            let of = [Chip::Baro, Chip::Imu, Chip::Gps, Chip::Umbilical, Chip::Wire];
            assert!(of.into_iter().any(|chip| possible(chip).split(", ").any(|word| word == name)), "{name}");
        }
    }

    #[test]
    fn what_follows_a_name_is_read_in_its_order() {
        for (chip, text, fault) in [
            (
                Chip::Baro,
                "spike=-500.5",
                Fault::Spike { quantity: Quantity::Pressure, by_milli: -500_500, results: 1 },
            ),
            (
                Chip::Imu,
                "spike=20,3,gyro-y",
                Fault::Spike { quantity: Quantity::Rate(1), by_milli: 20_000, results: 3 },
            ),
            (Chip::Imu, "offset=1", Fault::Offset { quantity: Quantity::Force(2), by_milli: 1_000 }),
            (Chip::Gps, "offset=30", Fault::Offset { quantity: Quantity::Altitude, by_milli: 30_000 }),
            (
                Chip::Baro,
                "flip-data=0x400000,2",
                Fault::FlipData { quantity: Quantity::Pressure, mask: 1 << 22, results: 2 },
            ),
            (
                Chip::Imu,
                "vibration=199.9,20",
                Fault::Vibration {
                    quantity: Quantity::Force(2),
                    frequency_mhz: 199_900,
                    amplitude_milli: 20_000,
                },
            ),
            (
                Chip::Gps,
                "cold-start=-25,120,dishonest",
                Fault::ColdStart { error_mm: -25_000, decay_s: 120, is_honest: false },
            ),
            (Chip::Imu, "flip-bits=0x30,24", Fault::FlipBits { after_bytes: 24, mask: 0x30 }),
            (Chip::Gps, "garbage=7", Fault::Garbage { seed: 7 }),
        ] {
            assert_eq!(parse_fault(chip, text), Some(fault), "{text}");
            assert!(chip.can(fault), "{text}");
        }
    }

    #[test]
    fn what_is_left_over_or_missing_is_no_fault() {
        for text in [
            "stalled=1",
            "spike",
            "spike=0",
            "spike=nan",
            "spike=3e6",
            "spike=1,0",
            "spike=1,1,depth",
            "spike=1,1,pressure,1",
            "cold-start=5",
            "cold-start=5,60,honestly",
            "flip-register=5",
            "flip-register=5,0",
            "vibration=-200,1",
            "garbage",
        ] {
            assert_eq!(parse_fault(Chip::Imu, text), None, "{text}");
        }
    }
}
