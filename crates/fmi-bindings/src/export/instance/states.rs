//! Saving and restoring.

use super::Instance;
use crate::export::notice::{Notice, Outcome};
use crate::export::saved::{self, Snapshot};

/// What an `FMUstate` of the importer points to.
pub(in crate::export) struct SavedState {
    /// The instance that frees it; never followed.
    owner: *const Instance,
    /// The saved state's place in the owner's list.
    slot: usize,
    /// Fingerprint of the model that it belongs to.
    fingerprint: String,
    snapshot: Snapshot,
}

/// Saved states. All pointers are those of [`save`](Instance::save) and
/// [`deserialize`](Instance::deserialize), not freed; the edges' contracts say so.
impl Instance {
    fn snapshot(&self) -> Snapshot {
        Snapshot {
            progress: self.progress,
            slopes: self.slopes.clone(),
            past: self.past.clone(),
            context: self.system.context().clone(),
        }
    }

    fn keep(&mut self, snapshot: Snapshot) -> *mut SavedState {
        let state = SavedState {
            owner: std::ptr::from_ref(self),
            slot: self.states.len(),
            fingerprint: self.fingerprint.clone(),
            snapshot,
        };
        let pointer = Box::into_raw(Box::new(state));
        self.states.push(pointer);
        pointer
    }

    /// Saves the state: into memory of an earlier save where there is some, without allocating.
    ///
    /// # Safety
    /// `old` is null or a saved state that is not freed.
    pub(in crate::export) unsafe fn save(
        &mut self,
        old: *mut SavedState,
    ) -> Result<*mut SavedState, Notice> {
        if old.is_null() {
            let snapshot = self.snapshot();
            return Ok(self.keep(snapshot));
        }
        // SAFETY: a saved state that is not freed, as the caller promises.
        let state = unsafe { &mut *old };
        self.check_model(state)?;
        state.snapshot.progress = self.progress;
        state.snapshot.slopes.clone_from(&self.slopes);
        state.snapshot.past.copy_from(&self.past);
        state.snapshot.context.copy_from(self.system.context());
        Ok(old)
    }

    /// Goes back to a saved state, which stays saved. The stop time is what the importer set for
    /// this run and stays as it is: a run that goes on from a saved state may have another one.
    pub(in crate::export) fn restore(&mut self, state: &SavedState) -> Outcome {
        self.check_model(state)?;
        let Snapshot { progress, slopes, past, context } = &state.snapshot;
        self.system.restore(context).map_err(|error| Notice::error(error.to_string()))?;
        let stop = self.progress.experiment.stop;
        self.progress = *progress;
        self.progress.experiment.stop = stop;
        self.slopes.clone_from(slopes);
        self.past.copy_from(past);
        Ok(())
    }

    /// Frees a saved state.
    ///
    /// # Safety
    /// `state` is a saved state that is not freed; it is not used again.
    pub(in crate::export) unsafe fn free(&mut self, state: *mut SavedState) -> Outcome {
        // SAFETY: a saved state that is not freed, as the caller promises.
        let (owner, slot) = unsafe { ((*state).owner, (*state).slot) };
        if !std::ptr::eq(owner, self) || self.states.get(slot) != Some(&state) {
            return Err(Notice::error(
                "this FMU state was saved by another instance; free it with that one",
            ));
        }
        self.states.swap_remove(slot);
        if let Some(moved) = self.states.get(slot) {
            // SAFETY: states in the list are alive.
            unsafe { (**moved).slot = slot }
        }
        // SAFETY: it came from `Box::into_raw` and has just left the list.
        drop(unsafe { Box::from_raw(state) });
        Ok(())
    }

    /// Number of bytes of a saved state.
    pub(in crate::export) fn serialized_size(&self, state: &SavedState) -> usize {
        saved::byte_len(&state.snapshot)
    }

    /// A saved state as bytes.
    pub(in crate::export) fn serialize(
        &self,
        state: &SavedState,
        room: usize,
    ) -> Result<Vec<u8>, Notice> {
        let needed = self.serialized_size(state);
        if room < needed {
            return Err(Notice::error(format!(
                "the serialised state has {needed} bytes, room is given for {room}; ask for the \
                 size first"
            )));
        }
        Ok(saved::to_bytes(&state.snapshot, &state.fingerprint))
    }

    /// A saved state from bytes: into memory of an earlier one where there is some.
    ///
    /// # Safety
    /// `old` is null or a saved state that is not freed.
    pub(in crate::export) unsafe fn deserialize(
        &mut self,
        bytes: &[u8],
        old: *mut SavedState,
    ) -> Result<*mut SavedState, Notice> {
        let snapshot =
            saved::from_bytes(bytes, &self.snapshot(), &self.fingerprint, self.system.period())
                .map_err(Notice::error)?;
        if old.is_null() {
            return Ok(self.keep(snapshot));
        }
        // SAFETY: a saved state that is not freed, as the caller promises.
        let state = unsafe { &mut *old };
        self.check_model(state)?;
        state.snapshot = snapshot;
        Ok(old)
    }

    fn check_model(&self, state: &SavedState) -> Outcome {
        if state.fingerprint == self.fingerprint {
            return Ok(());
        }
        Err(Notice::error(format!(
            "this FMU state belongs to another model: its GUID is \"{}\", this instance's \"{}\"",
            state.fingerprint, self.fingerprint
        )))
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        for state in self.states.drain(..) {
            // SAFETY: states in the list came from `Box::into_raw` and are freed once.
            drop(unsafe { Box::from_raw(state) });
        }
    }
}
