//! The module's interface: numbers and memory, as WebAssembly has them.
//!
//! The caller asks for memory ([`allocate`]), writes a request's JSON and the bytes with it there, and hands
//! both over ([`ask`]). What it gets is the place of six numbers: where the answer's JSON, its numbers (f64)
//! and its bytes lie, and how many of each there are. They are there until the next call.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::engine::Reply;

/// Where the parts of an answer lie.
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

/// The last answer, and where its parts lie.
struct Last {
    reply: Reply,
    places: Places,
}

static LAST: Mutex<Option<Box<Last>>> = Mutex::new(None);

#[cfg(target_arch = "wasm32")]
#[link(wasm_import_module = "pylon")]
unsafe extern "C" {
    /// Is told what is being done (UTF-8), how many steps are done, and of how many; 0: nobody knows.
    fn progress(what: *const u8, length: usize, done: f64, of: f64);
}

#[cfg(target_arch = "wasm32")]
fn tell(what: &str, done: u64, of: u64) {
    // SAFETY: the page's function reads `length` bytes from `what` while it runs, which are there.
    unsafe { progress(what.as_ptr(), what.len(), done as f64, of as f64) }
}

#[cfg(not(target_arch = "wasm32"))]
const fn tell(_: &str, _: u64, _: u64) {}

/// Memory of so many bytes, for a request or what comes with it; it is given back by [`ask`].
#[unsafe(no_mangle)]
pub extern "C" fn allocate(size: usize) -> *mut u8 {
    Box::into_raw(vec![0_u8; size].into_boxed_slice()).cast()
}

/// Answers a request.
///
/// # Safety
/// Both places must have come from [`allocate`] with these lengths, and are not to be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ask(
    request: *mut u8,
    request_length: usize,
    bytes: *mut u8,
    bytes_length: usize,
) -> *const Places {
    // SAFETY: as the caller promises, these are boxes of that length, made by `allocate`, and nobody else's.
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
    // The last answer's memory is the next one's.
    drop(locked().take());
    ENGINE.with_borrow_mut(|engine| engine.ask(request, bytes, &mut tell))
}

impl std::fmt::Debug for Last {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Last").field("places", &self.places).field("reply", &self.reply).finish()
    }
}
