//! The terms that the page uses.

use maud::{Markup, html};

const WORDS: &[(&str, &str)] = &[
    (
        "gps",
        "the reference: what the other sensors are compared with. It has errors too, which wander over minutes.",
    ),
    ("imu_master, imu_slave", "altitude by inertial navigation, of the mother ship and of the UAV."),
    ("baro", "altitude by static pressure."),
    (
        "captive flight, launch, free flight",
        "the UAV hangs under its mother ship, leaves it, and flies by itself.",
    ),
    ("settling", "the first seconds of captive flight, which are ignored."),
    ("bias", "a constant error; it is estimated in captive flight and subtracted in free flight."),
    ("latch", "at launch the calibration is copied once and never changed again."),
    ("residual, error", "what a sensor read minus what the model says it should have read, in metres."),
    ("sigma", "one standard deviation: two thirds of all errors are smaller, if they are Gaussian."),
    ("rms", "root mean square: the size of errors whatever their sign."),
    ("alarm limit", "a number of sigmas of the residual, set in the model."),
    (
        "doubtful, untrustworthy",
        "the error has exceeded the alarm limit; after that, its moving average has too.",
    ),
    ("unmonitored", "there is no reference, so the sensor cannot be judged."),
    (
        "effect",
        "a physical cause that adds a coefficient times something measured (its regressor) to what a sensor reads.",
    ),
    ("revision", "a change of the model: an effect that was learned, or learned again."),
    (
        "identified, indistinguishable, unknown effect",
        "one effect explains the misfit; several could, or one may, and these flights cannot show which or whether; nothing in the catalogue does.",
    ),
    ("held out", "judged on data that the coefficient was not learned from."),
];

pub(super) fn section() -> Markup {
    html! {
        section #words {
            h2 { "Words" }
            dl { @for (word, meaning) in WORDS { dt { (word) } dd { (meaning) } } }
        }
    }
}
