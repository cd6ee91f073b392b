//! Stand-in until the formula language is there.
pub struct Unit { pub unit: String, pub factor: f64, pub offset: f64, pub is_guessed: bool }
pub fn of(name: &str) -> Unit {
    let _ = name;
    Unit { unit: "1".into(), factor: 1.0, offset: 0.0, is_guessed: true }
}
pub fn of_coefficient(regressor: &str) -> String { let _ = regressor; "1".into() }
