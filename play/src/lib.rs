//! The doors of the module: texts go in and out as bytes in pieces of eight, so that neither side reads the memory of
//! the other.
//!
//! | export | what it does |
//! |---|---|
//! | `put(bytes, count)` | appends the `count` lowest bytes, least significant first, to the request |
//! | `answer() -> length` | answers the request and forgets it; how many bytes the answer has |
//! | `get(index) -> bytes` | the eight bytes of the answer from `8 index` on, zero beyond its end |
//!
//! | import of `host` | what it is asked for |
//! |---|---|
//! | `seconds() -> number` | time on any clock |
//! | `progress(share, length)` | told while a run goes on: the share done, NaN if not known; `get` reads what is done |

use std::cell::RefCell;

use hangtime_cli::Calls;

#[derive(Default)]
struct Module {
    calls: Calls,
    request: Vec<u8>,
}

thread_local! {
    static MODULE: RefCell<Module> = RefCell::default();
    /// What can be read: an answer, or what is being done.
    static OUTPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

#[expect(
    unsafe_code,
    reason = "functions of the host can only be declared so; both take and give plain numbers"
)]
#[cfg(target_family = "wasm")]
mod host {
    #[link(wasm_import_module = "host")]
    unsafe extern "C" {
        pub(crate) safe fn seconds() -> f64;
        pub(crate) safe fn progress(share: f64, length: u32);
    }
}

/// Built for a machine of its own, the module has no host.
#[cfg(not(target_family = "wasm"))]
mod host {
    pub(crate) fn progress(_share: f64, _length: u32) {}
}

#[expect(unsafe_code, reason = "an export of the module keeps its name")]
#[unsafe(no_mangle)]
extern "C" fn put(bytes: u64, count: u32) {
    let bytes = bytes.to_le_bytes();
    let count = (count as usize).min(bytes.len());
    MODULE.with_borrow_mut(|module| module.request.extend(&bytes[..count]));
}

#[expect(unsafe_code, reason = "an export of the module keeps its name")]
#[unsafe(no_mangle)]
extern "C" fn answer() -> u32 {
    #[cfg(target_family = "wasm")]
    hangtime::set_clock(|| host::seconds());
    let mut progress = |share: Option<f64>, what: &str| {
        let length = show(what);
        host::progress(share.unwrap_or(f64::NAN), length);
    };
    let answer = MODULE.with_borrow_mut(|module| {
        let request = std::mem::take(&mut module.request);
        let request = String::from_utf8_lossy(&request);
        module.calls.answer(&request, &mut progress)
    });
    show(&answer)
}

#[expect(unsafe_code, reason = "an export of the module keeps its name")]
#[unsafe(no_mangle)]
extern "C" fn get(index: u32) -> u64 {
    OUTPUT.with_borrow(|output| {
        let rest = output.get(8 * index as usize..).unwrap_or_default();
        let mut bytes = [0; 8];
        let count = rest.len().min(8);
        bytes[..count].copy_from_slice(&rest[..count]);
        u64::from_le_bytes(bytes)
    })
}

/// Makes a text readable; its length in bytes.
fn show(text: &str) -> u32 {
    OUTPUT.with_borrow_mut(|output| {
        output.clear();
        output.extend(text.as_bytes());
    });
    text.len() as u32
}
