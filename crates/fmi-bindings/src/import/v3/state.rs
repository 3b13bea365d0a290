//! Saved states of an FMI 3.0 instance.

use super::super::error::Error;
use super::super::state::SavedState;
use super::instance::Instance;
use crate::fmi3::*;

impl Instance {
    /// Saves the complete state (`fmi3GetFMUState`).
    pub fn save_state(&mut self) -> Result<SavedState, Error> {
        let pointer = self.get_fmu_state(std::ptr::null_mut())?;
        Ok(self.states.insert(pointer))
    }

    /// Saves the complete state into memory of an earlier save, which most FMUs do without
    /// allocating.
    pub fn save_state_into(&mut self, state: &SavedState) -> Result<(), Error> {
        let old = self.saved(state)?;
        let new = self.get_fmu_state(old)?;
        self.states.replace(state, new);
        Ok(())
    }

    /// Goes back to a saved state (`fmi3SetFMUState`), which stays saved.
    pub fn restore_state(&mut self, state: &SavedState) -> Result<(), Error> {
        const CALL: &str = "fmi3SetFMUState";
        let set = self.optional(self.functions().set_fmu_state, CALL)?;
        let pointer = self.saved(state)?;
        let instance = self.alive(&CALL)?;
        // SAFETY: the state was saved by this instance and is not freed.
        let status = unsafe { set(instance, pointer) };
        self.check(CALL, status)
    }

    /// Frees a saved state (`fmi3FreeFMUState`).
    pub fn free_state(&mut self, state: SavedState) -> Result<(), Error> {
        const CALL: &str = "fmi3FreeFMUState";
        let free = self.optional(self.functions().free_fmu_state, CALL)?;
        let mut pointer = self.saved(&state)?;
        let instance = self.alive(&CALL)?;
        self.states.remove(&state);
        // SAFETY: the state was saved by this instance, and its handle is gone after this.
        let status = unsafe { free(instance, &raw mut pointer) };
        self.check(CALL, status)
    }

    /// A saved state as bytes (`fmi3SerializeFMUState`), for another process.
    pub fn serialize_state(&mut self, state: &SavedState) -> Result<Vec<u8>, Error> {
        const SIZE: &str = "fmi3SerializedFMUStateSize";
        const CALL: &str = "fmi3SerializeFMUState";
        let size_of = self.optional(self.functions().serialized_fmu_state_size, SIZE)?;
        let serialize = self.optional(self.functions().serialize_fmu_state, CALL)?;
        let pointer = self.saved(state)?;
        let instance = self.alive(&SIZE)?;
        let mut size = 0;
        // SAFETY: the state was saved by this instance and is not freed.
        let status = unsafe { size_of(instance, pointer, &raw mut size) };
        self.check(SIZE, status)?;
        let mut bytes = vec![0_u8; size];
        let instance = self.alive(&CALL)?;
        // SAFETY: as before; the buffer has the size the FMU asked for.
        let status = unsafe { serialize(instance, pointer, bytes.as_mut_ptr(), size) };
        self.check(CALL, status)?;
        Ok(bytes)
    }

    /// A saved state from bytes (`fmi3DeserializeFMUState`). It is not yet the current one: see
    /// [`Instance::restore_state`].
    pub fn deserialize_state(&mut self, bytes: &[u8]) -> Result<SavedState, Error> {
        const CALL: &str = "fmi3DeserializeFMUState";
        let deserialize = self.optional(self.functions().deserialize_fmu_state, CALL)?;
        let instance = self.alive(&CALL)?;
        let mut pointer: fmi3FMUState = std::ptr::null_mut();
        // SAFETY: the instance is alive; the FMU reads the bytes and allocates the state itself.
        let status =
            unsafe { deserialize(instance, bytes.as_ptr(), bytes.len(), &raw mut pointer) };
        self.check(CALL, status)?;
        Ok(self.states.insert(pointer))
    }

    fn get_fmu_state(&mut self, mut pointer: fmi3FMUState) -> Result<fmi3FMUState, Error> {
        const CALL: &str = "fmi3GetFMUState";
        let get = self.optional(self.functions().get_fmu_state, CALL)?;
        let instance = self.alive(&CALL)?;
        // SAFETY: the pointer is null or a state of this instance that is not freed.
        let status = unsafe { get(instance, &raw mut pointer) };
        self.check(CALL, status).map(|()| pointer)
    }

    fn saved(&self, state: &SavedState) -> Result<fmi3FMUState, Error> {
        self.states.get(&self.name, state)
    }

    /// Frees what nobody freed; the instance is about to go.
    pub(super) fn free_all_states(&mut self) {
        let Some(free) = self.functions().free_fmu_state else { return };
        for mut pointer in self.states.take_all() {
            let Ok(instance) = self.alive(&"fmi3FreeFMUState") else { return };
            // SAFETY: saved by this instance, never used again.
            unsafe { free(instance, &raw mut pointer) };
        }
    }
}
