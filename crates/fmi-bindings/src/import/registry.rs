//! Which instance an environment pointer stands for.
//!
//! An FMU hands the environment pointer that it was given back to the logger. FMUs are known that
//! hand over others: null, a number, their component, the pointer of an instance that is gone. So
//! the pointer is looked up here, and never followed.

use std::cell::Cell;
use std::collections::{BTreeMap, VecDeque};
use std::ffi::c_void;
use std::path::Path;
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

/// A call. Every step notes some, so it has few words to write.
struct Calling {
    /// Of the instance that was called last.
    place: Cell<usize>,
    /// None when it has returned.
    function: Cell<Option<&'static &'static str>>,
}

thread_local! {
    /// What this thread calls.
    static CALLED: Calling = const { Calling { place: Cell::new(0), function: Cell::new(None) } };
    /// The library that this thread loads.
    static LOADED: Cell<Option<*const Path>> = const { Cell::new(None) };
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

    /// From now on, until it [has returned](returned), this thread is in this function of the instance.
    #[inline]
    pub(super) fn call(&self, function: &'static &'static str) {
        note(|called| {
            called.place.set(self.0);
            called.function.set(Some(function));
        });
    }
}

/// The function that this thread called has returned.
#[inline]
pub(super) fn returned() {
    note(|called| called.function.set(None));
}

/// Notes something of this thread's call. `try_with` becomes a store in the caller, `with` stays a call: 10 ns of each step of two
/// FMUs. What has no destructor is always there.
#[inline(always)]
fn note(what: impl FnOnce(&Calling)) {
    let noted = CALLED.try_with(what);
    debug_assert!(noted.is_ok(), "a thread-local without destructor");
}

/// Place of the instance that this thread calls, and the function.
fn calling() -> Option<(usize, &'static str)> {
    CALLED.with(|called| Some((called.place.get(), *called.function.get()?)))
}

impl Drop for Token {
    fn drop(&mut self) {
        let mut registry = registry();
        registry.live.remove(&self.0);
        registry.resting.push_back(self.0);
    }
}

/// Until it is dropped, this thread loads a library, or asks it for its version.
pub(super) struct Loading<'a>(std::marker::PhantomData<&'a Path>);

impl<'a> Loading<'a> {
    pub(super) fn of(path: &'a Path) -> Self {
        LOADED.set(Some(ptr::from_ref(path)));
        Loading(std::marker::PhantomData)
    }
}

impl Drop for Loading<'_> {
    fn drop(&mut self) {
        LOADED.set(None);
    }
}

/// Tells the FMU that this thread is inside of, by its name or that of its library, and the call, if there
/// is one. For the handler of a signal: it neither waits nor allocates.
pub fn called(tell: &mut dyn FnMut(&[u8], &str)) {
    if let Some(path) = LOADED.get() {
        // SAFETY: the path outlives the `Loading`, which has not been dropped.
        let name = unsafe { &*path }.file_name().unwrap_or_default();
        return tell(name.as_encoded_bytes(), "the loading of its library");
    }
    let Some((place, function)) = calling() else { return };
    let registry = REGISTRY.try_lock();
    let known = registry.as_ref().ok().and_then(|registry| registry.live.get(&place));
    tell(known.map(|known| known.name.as_bytes()).unwrap_or_default(), function);
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
    let called = calling().and_then(|(place, _)| registry.live.get(&place));
    let by_name = || {
        let name = name()?;
        let mut named = registry.live.values().filter(|known| known.name == name);
        named.next().filter(|_| named.next().is_none())
    };
    let newest = || registry.live.values().max_by_key(|known| known.number);
    let guess = called.or_else(by_name).or_else(newest);
    guess.and_then(|known| known.log.upgrade()).map_or(Speaker::Gone, Speaker::Guessed)
}
