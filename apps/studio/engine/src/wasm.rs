//! The module's interface: numbers and memory, as WebAssembly provides them.
//!
//! The caller requests memory ([`allocate`]), writes the request's JSON and its bytes there, and hands both
//! over ([`ask`]). It gets the address of six numbers: the addresses and lengths of the answer's JSON, its
//! numbers (f64) and its bytes. They remain valid until the next call.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::engine::Reply;

/// Addresses and lengths of the parts of an answer.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Places {
    json: usize,
    json_length: usize,
    numbers: usize,
    numbers_length: usize,
    bytes: usize,
    bytes_length: usize,
}

/// The last answer, and the addresses of its parts.
struct Last {
    reply: Reply,
    places: Places,
}

static LAST: Mutex<Option<Box<Last>>> = Mutex::new(None);

#[cfg(target_arch = "wasm32")]
#[link(wasm_import_module = "pylon")]
unsafe extern "C" {
    /// Receives what is being done (UTF-8), the number of steps done and their total; 0 if the total is not
    /// known.
    fn progress(what: *const u8, length: usize, done: f64, of: f64);
}

#[cfg(target_arch = "wasm32")]
fn tell(what: &str, done: u64, of: u64) {
    // SAFETY: the page's function reads `length` bytes from `what` during the call, and these exist.
    unsafe { progress(what.as_ptr(), what.len(), done as f64, of as f64) }
}

#[cfg(not(target_arch = "wasm32"))]
const fn tell(_: &str, _: u64, _: u64) {}

/// Allocates memory for a request or for the bytes that come with it; [`ask`] releases it.
#[unsafe(no_mangle)]
pub extern "C" fn allocate(size: usize) -> *mut u8 {
    Box::into_raw(vec![0_u8; size].into_boxed_slice()).cast()
}

/// Answers a request.
///
/// # Safety
/// Both pointers must come from [`allocate`] with these lengths, and must not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ask(
    request: *mut u8,
    request_length: usize,
    bytes: *mut u8,
    bytes_length: usize,
) -> *const Places {
    // SAFETY: the caller guarantees that these are boxes of this length, made by `allocate`, with no other
    // owner.
    let [request, bytes] = [(request, request_length), (bytes, bytes_length)]
        .map(|(at, length)| unsafe { Box::from_raw(std::ptr::slice_from_raw_parts_mut(at, length)) });
    let reply = answered(&request, &bytes);
    let places = Places {
        json: reply.json.as_ptr() as usize,
        json_length: reply.json.len(),
        numbers: reply.numbers.as_ptr() as usize,
        numbers_length: reply.numbers.len(),
        bytes: reply.bytes.as_ptr() as usize,
        bytes_length: reply.bytes.len(),
    };
    let mut last = locked();
    &raw const last.insert(Box::new(Last { reply, places })).places
}

fn locked() -> MutexGuard<'static, Option<Box<Last>>> {
    LAST.lock().unwrap_or_else(PoisonError::into_inner)
}

fn answered(request: &[u8], bytes: &[u8]) -> Reply {
    use std::cell::RefCell;

    use crate::engine::Engine;

    thread_local! {
        static ENGINE: RefCell<Engine> = RefCell::new(Engine::new(&executor::Inline));
    }
    // The last answer's memory is freed for the next.
    drop(locked().take());
    ENGINE.with_borrow_mut(|engine| engine.ask(request, bytes, &mut tell))
}

impl std::fmt::Debug for Last {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Last").field("places", &self.places).field("reply", &self.reply).finish()
    }
}
