//! What happens when what must not happen does: it is logged, and the board is stopped (emulated) or
//! reset.

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m_rt::{ExceptionFrame, exception};
use flight_record::ExitStatus;

use crate::board;

/// The failure may be one of the log itself: it is told to the log once only.
static LOGGED: AtomicBool = AtomicBool::new(false);

fn is_first() -> bool {
    // No read-modify-write: nothing that runs after a failure returns to what ran before it.
    let first = !LOGGED.load(Ordering::Relaxed);
    LOGGED.store(true, Ordering::Relaxed);
    first
}

#[panic_handler]
fn panicked(info: &PanicInfo) -> ! {
    if is_first() {
        match info.location() {
            Some(location) => defmt::error!("panic at {=str}:{=u32}", location.file(), location.line()),
            None => defmt::error!("panic"),
        }
    }
    board::exit(ExitStatus::Panic)
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    if is_first() {
        defmt::error!("hard fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr());
    }
    board::exit(ExitStatus::HardFault)
}
