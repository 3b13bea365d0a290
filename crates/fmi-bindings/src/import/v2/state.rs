//! Saved states of an FMI 2.0 instance.

use super::super::error::Error;
use super::super::state::SavedState;
use super::instance::Instance;
use crate::fmi2::*;

impl Instance {
    /// Saves the complete state (`fmi2GetFMUstate`).
    pub fn save_state(&mut self) -> Result<SavedState, Error> {
        let pointer = self.get_fmu_state(std::ptr::null_mut())?;
        Ok(self.states.insert(pointer))
    }

    /// Saves the complete state into memory of an earlier save, which most FMUs do without
    /// allocating.
    pub fn save_state_into(&mut self, state: &SavedState) -> Result<(), Error> {
        let old = self.pointer(state)?;
        let new = self.get_fmu_state(old)?;
        self.states.replace(state, new);
        Ok(())
    }

    /// Goes back to a saved state (`fmi2SetFMUstate`), which stays saved.
    pub fn restore_state(&mut self, state: &SavedState) -> Result<(), Error> {
        const CALL: &str = "fmi2SetFMUstate";
        let set = self.optional(self.functions().set_fmu_state, CALL)?;
        let pointer = self.pointer(state)?;
        let component = self.alive(&CALL)?;
        // SAFETY: the state was saved by this instance and is not freed.
        let status = unsafe { set(component, pointer) };
        self.check(CALL, status)
    }

    /// Frees a saved state (`fmi2FreeFMUstate`).
    pub fn free_state(&mut self, state: SavedState) -> Result<(), Error> {
        const CALL: &str = "fmi2FreeFMUstate";
        let free = self.optional(self.functions().free_fmu_state, CALL)?;
        let mut pointer = self.pointer(&state)?;
        let component = self.alive(&CALL)?;
        self.states.remove(&state);
        // SAFETY: the state was saved by this instance, and its handle is gone after this.
        let status = unsafe { free(component, &raw mut pointer) };
        self.check(CALL, status)
    }

    /// A saved state as bytes (`fmi2SerializeFMUstate`), for another process.
    pub fn serialize_state(&mut self, state: &SavedState) -> Result<Vec<u8>, Error> {
        const SIZE: &str = "fmi2SerializedFMUstateSize";
        const CALL: &str = "fmi2SerializeFMUstate";
        let size_of = self.optional(self.functions().serialized_fmu_state_size, SIZE)?;
        let serialize = self.optional(self.functions().serialize_fmu_state, CALL)?;
        let pointer = self.pointer(state)?;
        let component = self.alive(&SIZE)?;
        let mut size = 0;
        // SAFETY: the state was saved by this instance and is not freed.
        let status = unsafe { size_of(component, pointer, &raw mut size) };
        self.check(SIZE, status)?;
        let mut bytes = vec![0_u8; size];
        let component = self.alive(&CALL)?;
        // SAFETY: as before; the buffer has the size the FMU asked for.
        let status = unsafe { serialize(component, pointer, bytes.as_mut_ptr().cast(), size) };
        self.check(CALL, status)?;
        Ok(bytes)
    }

    /// A saved state from bytes (`fmi2DeSerializeFMUstate`). It is not yet the current one: see
    /// [`Instance::restore_state`].
    pub fn deserialize_state(&mut self, bytes: &[u8]) -> Result<SavedState, Error> {
        const CALL: &str = "fmi2DeSerializeFMUstate";
        let deserialize = self.optional(self.functions().deserialize_fmu_state, CALL)?;
        let component = self.alive(&CALL)?;
        let mut pointer: fmi2FMUstate = std::ptr::null_mut();
        // SAFETY: the instance is alive; the FMU reads the bytes and allocates the state itself.
        let status =
            unsafe { deserialize(component, bytes.as_ptr().cast(), bytes.len(), &raw mut pointer) };
        self.check(CALL, status)?;
        Ok(self.states.insert(pointer))
    }

    fn get_fmu_state(&mut self, mut pointer: fmi2FMUstate) -> Result<fmi2FMUstate, Error> {
        const CALL: &str = "fmi2GetFMUstate";
        let get = self.optional(self.functions().get_fmu_state, CALL)?;
        let component = self.alive(&CALL)?;
        // SAFETY: the pointer is null or a state of this instance that is not freed.
        let status = unsafe { get(component, &raw mut pointer) };
        self.check(CALL, status).map(|()| pointer)
    }

    fn pointer(&self, state: &SavedState) -> Result<fmi2FMUstate, Error> {
        self.states.get(&self.name, state)
    }

    /// Frees what nobody freed; the instance is about to go.
    pub(super) fn free_all_states(&mut self) {
        let Some(free) = self.functions().free_fmu_state else { return };
        for mut pointer in self.states.take_all() {
            let Ok(instance) = self.alive(&"fmi2FreeFMUstate") else { return };
            // SAFETY: saved by this instance, never used again.
            unsafe { free(instance, &raw mut pointer) };
        }
    }
}
