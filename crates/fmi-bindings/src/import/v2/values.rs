//! Values of an FMI 2.0 instance: get, set, derivatives.
//!
//! Slices go straight to the FMU; nothing is allocated but for texts. An empty slice makes no
//! call.

use std::ptr;

use super::super::error::Error;
use super::super::text::{c_text, text_of};
use super::instance::Instance;
use crate::fmi2::*;

/// Booleans are C ints at the edge; so many are converted on the stack at once.
const CHUNK: usize = 32;

impl Instance {
    /// Reads Real variables (`fmi2GetReal`).
    #[inline]
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        const CALL: &str = "fmi2GetReal";
        let Some(component) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        let get = self.functions().get_real;
        // SAFETY: the instance is alive, both slices have the length given.
        let status =
            unsafe { get(component, references.as_ptr(), references.len(), values.as_mut_ptr()) };
        self.check(CALL, status)
    }

    /// Writes Real variables (`fmi2SetReal`).
    #[inline]
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        const CALL: &str = "fmi2SetReal";
        let Some(component) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        let set = self.functions().set_real;
        // SAFETY: the instance is alive, both slices have the length given.
        let status =
            unsafe { set(component, references.as_ptr(), references.len(), values.as_ptr()) };
        self.check(CALL, status)
    }

    /// Reads Integer and Enumeration variables (`fmi2GetInteger`).
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Result<(), Error> {
        const CALL: &str = "fmi2GetInteger";
        let get = self.optional(self.functions().get_integer, CALL)?;
        let Some(component) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        // SAFETY: the instance is alive, both slices have the length given.
        let status =
            unsafe { get(component, references.as_ptr(), references.len(), values.as_mut_ptr()) };
        self.check(CALL, status)
    }

    /// Writes Integer and Enumeration variables (`fmi2SetInteger`).
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Result<(), Error> {
        const CALL: &str = "fmi2SetInteger";
        let set = self.optional(self.functions().set_integer, CALL)?;
        let Some(component) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        // SAFETY: the instance is alive, both slices have the length given.
        let status =
            unsafe { set(component, references.as_ptr(), references.len(), values.as_ptr()) };
        self.check(CALL, status)
    }

    /// Reads Boolean variables (`fmi2GetBoolean`); anything but 0 is true.
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [bool]) -> Result<(), Error> {
        const CALL: &str = "fmi2GetBoolean";
        let get = self.optional(self.functions().get_boolean, CALL)?;
        self.same_length(CALL, references.len(), values.len())?;
        for (references, values) in references.chunks(CHUNK).zip(values.chunks_mut(CHUNK)) {
            let component = self.alive(&CALL)?;
            let mut ints = [fmi2False; CHUNK];
            // SAFETY: the instance is alive; a chunk is not longer than `ints`.
            let status =
                unsafe { get(component, references.as_ptr(), references.len(), ints.as_mut_ptr()) };
            self.check(CALL, status)?;
            for (value, int) in values.iter_mut().zip(ints) {
                *value = int != fmi2False;
            }
        }
        Ok(())
    }

    /// Writes Boolean variables (`fmi2SetBoolean`).
    pub fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Result<(), Error> {
        const CALL: &str = "fmi2SetBoolean";
        let set = self.optional(self.functions().set_boolean, CALL)?;
        self.same_length(CALL, references.len(), values.len())?;
        for (references, values) in references.chunks(CHUNK).zip(values.chunks(CHUNK)) {
            let mut ints = [fmi2False; CHUNK];
            for (int, value) in ints.iter_mut().zip(values) {
                *int = (*value).into();
            }
            let component = self.alive(&CALL)?;
            // SAFETY: the instance is alive; a chunk is not longer than `ints`.
            let status =
                unsafe { set(component, references.as_ptr(), references.len(), ints.as_ptr()) };
            self.check(CALL, status)?;
        }
        Ok(())
    }

    /// Reads String variables (`fmi2GetString`), one by one: the FMU's text lives only until the
    /// next call. The buffers of `values` are reused; null is read as empty.
    pub fn get_string(&mut self, references: &[u32], values: &mut [String]) -> Result<(), Error> {
        const CALL: &str = "fmi2GetString";
        let get = self.optional(self.functions().get_string, CALL)?;
        self.same_length(CALL, references.len(), values.len())?;
        for (reference, value) in references.iter().zip(values) {
            let component = self.alive(&CALL)?;
            let mut text: fmi2String = ptr::null();
            // SAFETY: the instance is alive; one reference, one place.
            let status = unsafe { get(component, reference, 1, &raw mut text) };
            self.check(CALL, status)?;
            value.clear();
            // SAFETY: after success null or a zero-terminated text, valid until the next call.
            value.push_str(&unsafe { text_of(text) });
        }
        Ok(())
    }

    /// Writes String variables (`fmi2SetString`).
    ///
    /// # Errors
    /// [`Error::ZeroByte`] before anything is written, besides a failed call.
    pub fn set_string(&mut self, references: &[u32], values: &[&str]) -> Result<(), Error> {
        const CALL: &str = "fmi2SetString";
        let set = self.optional(self.functions().set_string, CALL)?;
        let texts = values
            .iter()
            .map(|value| c_text(&self.name, "the value", value))
            .collect::<Result<Vec<_>, _>>()?;
        let pointers: Vec<fmi2String> = texts.iter().map(|text| text.as_ptr()).collect();
        let Some(component) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        // SAFETY: the instance is alive; the texts outlive the call.
        let status =
            unsafe { set(component, references.as_ptr(), references.len(), pointers.as_ptr()) };
        self.check(CALL, status)
    }

    /// Time derivatives of Real inputs for the next step (`fmi2SetRealInputDerivatives`), one
    /// order per reference, in units per second to that order.
    pub fn set_real_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Error> {
        const CALL: &str = "fmi2SetRealInputDerivatives";
        let set = self.optional(self.functions().set_real_input_derivatives, CALL)?;
        self.same_length(CALL, references.len(), orders.len())?;
        let Some(component) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        let count = references.len();
        // SAFETY: the instance is alive, all slices have the length given.
        let status =
            unsafe { set(component, references.as_ptr(), count, orders.as_ptr(), values.as_ptr()) };
        self.check(CALL, status)
    }

    /// Time derivatives of Real outputs (`fmi2GetRealOutputDerivatives`), one order per reference.
    pub fn get_real_output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<(), Error> {
        const CALL: &str = "fmi2GetRealOutputDerivatives";
        let get = self.optional(self.functions().get_real_output_derivatives, CALL)?;
        self.same_length(CALL, references.len(), orders.len())?;
        let Some(component) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        let count = references.len();
        // SAFETY: the instance is alive, all slices have the length given.
        let status = unsafe {
            get(component, references.as_ptr(), count, orders.as_ptr(), values.as_mut_ptr())
        };
        self.check(CALL, status)
    }

    /// Directional derivative (`fmi2GetDirectionalDerivative`):
    /// `d_unknown = ∂unknown/∂known · d_known`.
    pub fn get_directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        d_known: &[f64],
        d_unknown: &mut [f64],
    ) -> Result<(), Error> {
        const CALL: &str = "fmi2GetDirectionalDerivative";
        let get = self.optional(self.functions().get_directional_derivative, CALL)?;
        self.same_length(CALL, knowns.len(), d_known.len())?;
        let Some(component) = self.ready(&CALL, unknowns.len(), d_unknown.len())? else {
            return Ok(());
        };
        // SAFETY: the instance is alive, the slices have the lengths given.
        let status = unsafe {
            get(
                component,
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                d_known.as_ptr(),
                d_unknown.as_mut_ptr(),
            )
        };
        self.check(CALL, status)
    }

    /// The component, if a call is to be made: lengths agree and are not zero.
    #[inline]
    fn ready(
        &self,
        call: &'static &'static str,
        references: usize,
        values: usize,
    ) -> Result<Option<fmi2Component>, Error> {
        self.same_length(call, references, values)?;
        if references == 0 {
            return Ok(None);
        }
        self.alive(call).map(Some)
    }

    #[inline]
    fn same_length(
        &self,
        call: &'static str,
        references: usize,
        values: usize,
    ) -> Result<(), Error> {
        if references == values {
            return Ok(());
        }
        Err(Error::Length { fmu: self.name.clone(), call, references, values })
    }
}
