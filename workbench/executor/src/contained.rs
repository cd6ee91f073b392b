//! Contains a panic, so that it does not stop the rest: it is reported as a defect.

use std::any::Any;
use std::cell::RefCell;
use std::fmt;
use std::panic::{self, AssertUnwindSafe, catch_unwind};
use std::sync::Once;

thread_local! {
    /// Within [`contained`]: place of this thread's latest panic.
    static PLACE: RefCell<Option<String>> = const { RefCell::new(None) };
    static DEPTH: RefCell<u32> = const { RefCell::new(0) };
}

/// A panic that was contained.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Panicked {
    /// Its message.
    pub message: String,
    /// File, line and column, if it was in the thread that contained it.
    pub place: Option<String>,
}

impl fmt::Display for Panicked {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)?;
        self.place.as_ref().map_or(Ok(()), |place| write!(formatter, " ({place})"))
    }
}

impl std::error::Error for Panicked {}

/// Does some work and continues after its panic. The panic is not printed.
///
/// # Errors
/// [`Panicked`].
pub fn contained<T>(work: impl FnOnce() -> T) -> Result<T, Panicked> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if DEPTH.with_borrow(|depth| *depth == 0) {
                usual(info);
            } else {
                PLACE.set(info.location().map(ToString::to_string));
            }
        }));
    });
    DEPTH.with_borrow_mut(|depth| *depth += 1);
    // What `work` was using is dropped with it.
    let done = catch_unwind(AssertUnwindSafe(work));
    DEPTH.with_borrow_mut(|depth| *depth -= 1);
    done.map_err(|payload| Panicked { message: message(payload.as_ref()).to_owned(), place: PLACE.take() })
}

fn message(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("a panic without a message")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_panics_says_so_and_the_rest_goes_on() {
        assert_eq!(contained(|| 5), Ok(5));
        let number = 7;
        let error = contained(|| -> u8 { panic!("number {number}") }).unwrap_err().to_string();
        assert!(error.starts_with("number 7 (") && error.contains("contained.rs"), "{error}");
        assert_eq!(contained(|| 6), Ok(6));
    }
}
