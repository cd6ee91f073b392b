//! Effects by formula: compiles text to a program that the estimator runs.
//!
//! [`Formula::compile`] does all of it: parse, check dimensions, compile. The language is described in
//! `docs/effects.md`; in short, arithmetic, powers, comparisons and functions over the columns of a flight,
//! in SI units, with a result in metres per unit of the coefficient.
//!
//! ```
//! use kf_core::formula::{Evaluation, Frame, Signal};
//! use model::formula::{Columns, Dimension, Formula};
//!
//! // A column that the estimator does not know gets a number, the same for all formulas of a model.
//! let mut columns = Columns::default();
//! let formula = Formula::compile("tas_mps^2 / (2*g) * flap * step(launch)", &mut columns).unwrap();
//! assert_eq!(formula.dimension().to_string(), "m");
//! assert_eq!(columns.iter().next().unwrap().name(), "flap");
//! // The unit of the coefficient: metres over the formula's.
//! assert!(formula.check_unit("1").is_ok() && formula.check_unit("rad").is_err());
//!
//! let mut evaluation = Evaluation::new(formula.program(), 60.0);
//! let mut frame = Frame::default();
//! frame.begin(0.005, true, false);
//! frame.set(Signal::Launch.place(), 1.0);
//! frame.set(Signal::TrueAirspeed.place(), 19.613_3);
//! assert!(evaluation.step(&frame).is_err()); // the flap has not been seen
//! frame.set(Signal::column_place(0), 0.5);
//! assert!((evaluation.step(&frame).unwrap() - 9.806_65).abs() < 1e-5);
//! ```

mod ast;
mod catalogue;
mod columns;
mod compile;
mod dimension;
mod error;
mod functions;
mod parse;

pub use ast::{Expression, Kind, Operator};
pub use catalogue::of_catalogue;
pub use columns::{Column, Columns};
pub use compile::Formula;
pub use dimension::{Dimension, Ratio};
pub use error::FormulaError;
pub use functions::{CONSTANTS, FUNCTIONS, Function};
pub use parse::parse;

#[cfg(test)]
mod tests;
