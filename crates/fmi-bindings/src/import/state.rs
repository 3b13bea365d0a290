//! Saved states of an instance, of FMI 2.0 and 3.0 alike.
//!
//! The FMU owns the memory of a saved state and needs its instance to free it, so the instance
//! keeps the pointers and hands out handles; what is not freed by hand is freed with it.

use std::ffi::c_void;
use std::sync::atomic::{AtomicU64, Ordering};

use super::error::Error;

/// A handle of a state that an instance has saved. Only that instance can use it.
#[derive(Debug, PartialEq, Eq)]
pub struct SavedState {
    owner: u64,
    slot: usize,
}

/// `fmi2FMUstate` and `fmi3FMUState`.
pub(super) type Pointer = *mut c_void;

/// The saved states of one instance; a freed slot is `None` and is used again.
pub(super) struct States {
    owner: u64,
    slots: Vec<Option<Pointer>>,
}

impl Default for States {
    fn default() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        States { owner: NEXT.fetch_add(1, Ordering::Relaxed), slots: Vec::new() }
    }
}

impl States {
    /// Pointer of a handle.
    ///
    /// # Errors
    /// [`Error::UnknownState`] if it is freed or foreign.
    pub(super) fn get(&self, fmu: &str, state: &SavedState) -> Result<Pointer, Error> {
        let pointer = self.slots.get(state.slot).copied().flatten();
        pointer
            .filter(|_| state.owner == self.owner)
            .ok_or_else(|| Error::UnknownState { fmu: fmu.to_owned() })
    }

    /// Keeps a new state.
    pub(super) fn insert(&mut self, pointer: Pointer) -> SavedState {
        let free = self.slots.iter().position(Option::is_none);
        let slot = free.unwrap_or_else(|| {
            self.slots.push(None);
            self.slots.len() - 1
        });
        self.slots[slot] = Some(pointer);
        SavedState { owner: self.owner, slot }
    }

    /// The FMU may have moved a state that it saved anew.
    pub(super) fn replace(&mut self, state: &SavedState, pointer: Pointer) {
        if let Some(slot) = self.slots.get_mut(state.slot) {
            *slot = Some(pointer);
        }
    }

    /// The state is freed.
    pub(super) fn remove(&mut self, state: &SavedState) {
        if let Some(slot) = self.slots.get_mut(state.slot) {
            *slot = None;
        }
    }

    /// All states that nobody freed.
    pub(super) fn take_all(&mut self) -> impl Iterator<Item = Pointer> + use<> {
        std::mem::take(&mut self.slots).into_iter().flatten()
    }
}
