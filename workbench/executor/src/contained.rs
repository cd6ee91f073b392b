//! A panic in one place that is not to cost the rest: a defect, told as such.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{self, AssertUnwindSafe, catch_unwind};
use std::sync::Once;

thread_local! {
    /// Within [`contained`]: where the newest panic of this thread was.
    static PLACE: RefCell<Option<String>> = const { RefCell::new(None) };
    static DEPTH: RefCell<u32> = const { RefCell::new(0) };
}

/// Does something, and goes on after a panic of it. The panic is not printed.
///
/// # Errors
/// What the panic said, and where it was if it was in this thread.
pub fn contained<T>(work: impl FnOnce() -> T) -> Result<T, String> {
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
    // What `work` had in hand is given up with it.
    let done = catch_unwind(AssertUnwindSafe(work));
    DEPTH.with_borrow_mut(|depth| *depth -= 1);
    done.map_err(|payload| {
        let place = PLACE.take().map_or_else(String::new, |place| format!(" ({place})"));
        format!("{}{place}", said(payload.as_ref()))
    })
}

fn said(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("a panic without a word")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_panics_says_so_and_the_rest_goes_on() {
        assert_eq!(contained(|| 5), Ok(5));
        let number = 7;
        let error = contained(|| -> u8 { panic!("number {number}") }).unwrap_err();
        assert!(error.starts_with("number 7 (") && error.contains("contained.rs"), "{error}");
        assert_eq!(contained(|| 6), Ok(6));
    }
}
