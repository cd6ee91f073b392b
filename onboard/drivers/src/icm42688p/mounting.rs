//! Orientation of the chip in the vehicle, and its ranges.

/// An axis of the chip (DS-000347, section 12, "Orientation of axes").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum ChipAxis {
    PlusX,
    MinusX,
    PlusY,
    MinusY,
    PlusZ,
    MinusZ,
}

/// The axes of the chip that point along the axes of the body (forward-right-down).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mounting {
    /// The chip's axis that points forward.
    pub forward: ChipAxis,
    /// The chip's axis that points right.
    pub right: ChipAxis,
    /// The chip's axis that points down.
    pub down: ChipAxis,
}

impl Mounting {
    /// The chip's x forward, its y right, its z down: its top faces the ground.
    pub const ALIGNED: Self =
        Self { forward: ChipAxis::PlusX, right: ChipAxis::PlusY, down: ChipAxis::PlusZ };

    pub(super) fn to_body(self, chip: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = chip;
        [self.forward, self.right, self.down].map(|axis| match axis {
            ChipAxis::PlusX => x,
            ChipAxis::MinusX => -x,
            ChipAxis::PlusY => y,
            ChipAxis::MinusY => -y,
            ChipAxis::PlusZ => z,
            ChipAxis::MinusZ => -z,
        })
    }
}

/// Full scale of the accelerometer (DS-000347, 14.38).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum AccelRange {
    G16,
    G8,
    G4,
    G2,
}

impl AccelRange {
    /// ACCEL_FS_SEL.
    pub(super) const fn field(self) -> u8 {
        match self {
            Self::G16 => 0,
            Self::G8 => 1,
            Self::G4 => 2,
            Self::G2 => 3,
        }
    }

    /// m/s^2 per count: full scale is 2^15 counts; g is standard gravity.
    #[must_use]
    pub const fn mps2_per_count(self) -> f32 {
        let full_scale_g = match self {
            Self::G16 => 16.0,
            Self::G8 => 8.0,
            Self::G4 => 4.0,
            Self::G2 => 2.0,
        };
        full_scale_g * kf_core::atmosphere::STANDARD_GRAVITY_MPS2 / 32_768.0
    }
}

/// Full scale of the gyro (DS-000347, 14.37).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum GyroRange {
    Dps2000,
    Dps1000,
    Dps500,
    Dps250,
}

impl GyroRange {
    /// GYRO_FS_SEL.
    pub(super) const fn field(self) -> u8 {
        match self {
            Self::Dps2000 => 0,
            Self::Dps1000 => 1,
            Self::Dps500 => 2,
            Self::Dps250 => 3,
        }
    }

    /// rad/s per count: full scale is 2^15 counts. (Table 1 rounds 16.384 counts per degree a second to
    /// 16.4.)
    #[must_use]
    pub const fn radps_per_count(self) -> f32 {
        let full_scale_dps = match self {
            Self::Dps2000 => 2_000.0,
            Self::Dps1000 => 1_000.0,
            Self::Dps500 => 500.0,
            Self::Dps250 => 250.0,
        };
        full_scale_dps * (core::f32::consts::PI / 180.0) / 32_768.0
    }
}
