//! Which instance an environment pointer stands for.
//!
//! An FMU hands the environment pointer that it was given back to the logger. FMUs are known that
//! hand over others: null, a number, their component, the pointer of an instance that is gone. So
//! the pointer is looked up here, and never followed.

use std::cell::Cell;
use std::collections::{BTreeMap, VecDeque};
use std::ffi::c_void;
use std::ptr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use super::log::Log;
use crate::fmi2::fmi2CallbackFunctions;

/// A place whose instance is gone rests until so many others do: an FMU that speaks late is not taken
/// for another one.
const RESTING: usize = 1024;

/// What an environment pointer points to: zeros, for an FMU that looks, and the callbacks of FMI 2.0,
/// which FMUs made for its first releases keep by address. It is never given back to the operating
/// system, only used again.
#[repr(C)]
struct Place {
    zeros: [usize; 8],
    callbacks: fmi2CallbackFunctions,
}

struct Registry {
    /// By the address of the place.
    live: BTreeMap<usize, Known>,
    resting: VecDeque<usize>,
    entered: u64,
}

struct Known {
    log: Weak<Log>,
    name: String,
    /// The newest has the greatest.
    number: u64,
}

static REGISTRY: Mutex<Registry> =
    Mutex::new(Registry { live: BTreeMap::new(), resting: VecDeque::new(), entered: 0 });

thread_local! {
    /// Place of the instance that this thread calls; 0: of none.
    static CALLED: Cell<usize> = const { Cell::new(0) };
}

fn registry() -> MutexGuard<'static, Registry> {
    REGISTRY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An instance's entry in the registry; dropping it takes the entry out.
pub(super) struct Token(usize);

impl Token {
    /// Enters the log of an instance of this name.
    pub(super) fn new(log: &Arc<Log>, name: &str) -> Self {
        let mut registry = registry();
        let rested =
            if registry.resting.len() < RESTING { None } else { registry.resting.pop_front() };
        let place = match rested {
            Some(place) => place,
            None => {
                let callbacks = fmi2CallbackFunctions {
                    logger: None,
                    allocateMemory: None,
                    freeMemory: None,
                    stepFinished: None,
                    componentEnvironment: ptr::null_mut(),
                };
                Box::into_raw(Box::new(Place { zeros: [0; 8], callbacks })).expose_provenance()
            }
        };
        registry.entered += 1;
        let number = registry.entered;
        let known = Known { log: Arc::downgrade(log), name: name.to_owned(), number };
        registry.live.insert(place, known);
        Token(place)
    }

    /// The environment pointer of the instance.
    pub(super) fn environment(&self) -> *mut c_void {
        ptr::with_exposed_provenance_mut(self.0)
    }

    /// Keeps these callbacks at an address that stays readable.
    pub(super) fn keep(&self, callbacks: fmi2CallbackFunctions) -> *const fmi2CallbackFunctions {
        let place = self.environment().cast::<Place>();
        // SAFETY: the place was made by `Token::new` and is never freed; no FMU knows it yet, or
        // only one whose instance was gone long ago.
        unsafe {
            (*place).zeros = [0; 8];
            (*place).callbacks = callbacks;
            &raw const (*place).callbacks
        }
    }

    /// Until the result is dropped, this thread calls the instance.
    #[inline]
    pub(super) fn call(&self) -> Called {
        Called(CALLED.replace(self.0))
    }
}

impl Drop for Token {
    fn drop(&mut self) {
        let mut registry = registry();
        registry.live.remove(&self.0);
        registry.resting.push_back(self.0);
    }
}

/// See [`Token::call`].
pub(super) struct Called(usize);

impl Drop for Called {
    #[inline]
    fn drop(&mut self) {
        CALLED.set(self.0);
    }
}

/// The names of the instances that there are, without waiting for anybody.
#[must_use]
pub fn names() -> Vec<String> {
    let registry = REGISTRY.try_lock();
    registry.map(|r| r.live.values().map(|k| k.name.clone()).collect()).unwrap_or_default()
}

/// Whose message it is.
pub(super) enum Speaker {
    /// The pointer is that of this instance.
    Own(Arc<Log>),
    /// The pointer is of no instance; by name and thread this one must have spoken.
    Guessed(Arc<Log>),
    /// The instance is gone.
    Gone,
}

/// Looks up who speaks; `name` is what the FMU says it is called.
pub(super) fn speaker(environment: *mut c_void, name: impl FnOnce() -> Option<String>) -> Speaker {
    let registry = registry();
    let address = environment.addr();
    if let Some(known) = registry.live.get(&address) {
        return known.log.upgrade().map_or(Speaker::Gone, Speaker::Own);
    }
    if registry.resting.contains(&address) {
        return Speaker::Gone;
    }
    // The instance that this thread calls, else the one of the name, else the newest.
    let called = registry.live.get(&CALLED.get());
    let by_name = || {
        let name = name()?;
        let mut named = registry.live.values().filter(|known| known.name == name);
        named.next().filter(|_| named.next().is_none())
    };
    let newest = || registry.live.values().max_by_key(|known| known.number);
    let guess = called.or_else(by_name).or_else(newest);
    guess.and_then(|known| known.log.upgrade()).map_or(Speaker::Gone, Speaker::Guessed)
}
