//! The functions and constants that a formula can call.

use kf_core::atmosphere::STANDARD_GRAVITY_MPS2;

macro_rules! functions {
    ($($(#[$doc:meta])* $variant:ident = $name:literal, $arguments:literal, $about:literal;)*) => {
        /// A function of a formula.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Function {
            $(#[doc = $about] $variant,)*
        }

        /// Every function.
        pub const FUNCTIONS: &[Function] = &[$(Function::$variant),*];

        impl Function {
            /// Its name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// Number of its arguments.
            #[must_use]
            pub const fn arguments(self) -> usize {
                match self { $(Self::$variant => $arguments,)* }
            }

            /// Explanation for the reader.
            #[must_use]
            pub const fn about(self) -> &'static str {
                match self { $(Self::$variant => $about,)* }
            }
        }
    };
}

functions! {
    Absolute = "abs", 1, "the number without its sign";
    Min = "min", 2, "the smaller of two";
    Max = "max", 2, "the larger of two";
    Clamp = "clamp", 3, "clamp(x, low, high): x, but no less than low and no more than high";
    Root = "sqrt", 1, "square root";
    Exponential = "exp", 1, "e to the power of a plain number";
    Logarithm = "ln", 1, "natural logarithm of a plain number";
    Sine = "sin", 1, "sine of an angle in radians";
    Cosine = "cos", 1, "cosine of an angle in radians";
    Step = "step", 1, "1 where the argument is above 0, else 0";
    Rate = "rate", 1, "change a second, from sample to sample of the argument's signals";
    Integral = "integral", 1, "integral over time from launch on; 0 before";
    DoubleIntegral = "integral2", 1, "integral of the integral from launch on; 0 before";
    LowPass = "lowpass", 2, "lowpass(x, tau): first-order low pass with the time constant tau, seconds";
    Delay = "delay", 2, "delay(x, s): x as it was s seconds ago, 60 at most, from 16 samples over that time";
    Captive = "captive", 1, "mean over the calibration in captive flight; constant after launch";
    AtCalibration = "at_calibration", 1, "the value at the calibration's first sample";
    AtLaunch = "at_launch", 1, "the value itself before launch, after launch its value at launch";
    IsaAltitude = "isa_altitude", 1, "pressure altitude (m) of a pressure (Pa), ICAO standard atmosphere";
    IsaPressure = "isa_pressure", 1, "pressure (Pa) at an altitude (m), ICAO standard atmosphere";
    IsaTemperature = "isa_temperature", 1, "temperature (K) at an altitude (m), ICAO standard atmosphere";
    IsaDensity = "isa_density", 1, "density (Pa s^2/m^2, which is kg/m^3) at an altitude (m), ICAO standard atmosphere";
}

impl Function {
    /// The function with this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        FUNCTIONS.iter().copied().find(|function| function.name() == name)
    }
}

/// Name, value, unit and meaning of the constants.
pub const CONSTANTS: [(&str, f64, &str, &str); 4] = [
    ("g", STANDARD_GRAVITY_MPS2 as f64, "m/s^2", "standard gravity"),
    ("R", 6_371_008.8_f32 as f64, "m", "mean radius of the earth"),
    ("Omega", 7.292_115e-5_f32 as f64, "1/s", "rotation rate of the earth"),
    ("pi", std::f64::consts::PI, "1", "half a turn, as a plain number"),
];
