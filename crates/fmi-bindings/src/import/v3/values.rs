//! Values of an FMI 3.0 instance: get, set, derivatives.
//!
//! An array variable has one reference and as many values as elements, in row-major order, so
//! there may be more values than references. Slices go straight to the FMU; nothing is allocated
//! but for texts. An empty slice makes no call.

use std::ptr;

use super::super::error::Error;
use super::super::text::{c_text, text_of};
use super::instance::Instance;
use crate::fmi3::*;

/// Booleans are read as bytes, so many at once.
const CHUNK: usize = 64;

/// A pair of get and set for a numeric type: `fmi3Get…` and `fmi3Set…` differ in it alone.
macro_rules! numbers {
    ($($type:ty: $get:ident $get_name:literal, $set:ident $set_name:literal;)*) => { $(
        #[doc = concat!("`", $get_name, "`")]
        pub fn $get(&mut self, references: &[u32], values: &mut [$type]) -> Result<(), Error> {
            let get = self.optional(self.functions().$get, $get_name)?;
            let Some(instance) = self.ready(&$get_name, references.len(), values.len())? else {
                return Ok(());
            };
            // SAFETY: the instance is alive, both slices have the lengths given.
            let status = unsafe {
                get(instance, references.as_ptr(), references.len(), values.as_mut_ptr(),
                    values.len())
            };
            self.check($get_name, status)
        }

        #[doc = concat!("`", $set_name, "`")]
        pub fn $set(&mut self, references: &[u32], values: &[$type]) -> Result<(), Error> {
            let set = self.optional(self.functions().$set, $set_name)?;
            let Some(instance) = self.ready(&$set_name, references.len(), values.len())? else {
                return Ok(());
            };
            // SAFETY: the instance is alive, both slices have the lengths given.
            let status = unsafe {
                set(instance, references.as_ptr(), references.len(), values.as_ptr(), values.len())
            };
            self.check($set_name, status)
        }
    )* };
}

impl Instance {
    numbers! {
        f32: get_float32 "fmi3GetFloat32", set_float32 "fmi3SetFloat32";
        i8: get_int8 "fmi3GetInt8", set_int8 "fmi3SetInt8";
        u8: get_uint8 "fmi3GetUInt8", set_uint8 "fmi3SetUInt8";
        i16: get_int16 "fmi3GetInt16", set_int16 "fmi3SetInt16";
        u16: get_uint16 "fmi3GetUInt16", set_uint16 "fmi3SetUInt16";
        i32: get_int32 "fmi3GetInt32", set_int32 "fmi3SetInt32";
        u32: get_uint32 "fmi3GetUInt32", set_uint32 "fmi3SetUInt32";
        i64: get_int64 "fmi3GetInt64", set_int64 "fmi3SetInt64";
        u64: get_uint64 "fmi3GetUInt64", set_uint64 "fmi3SetUInt64";
    }

    /// `fmi3GetFloat64`
    #[inline]
    pub fn get_float64(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        const CALL: &str = "fmi3GetFloat64";
        let Some(instance) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        let (get, count) = (self.functions().get_float64, values.len());
        // SAFETY: the instance is alive, both slices have the lengths given.
        let status = unsafe {
            get(instance, references.as_ptr(), references.len(), values.as_mut_ptr(), count)
        };
        self.check(CALL, status)
    }

    /// `fmi3SetFloat64`
    #[inline]
    pub fn set_float64(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        const CALL: &str = "fmi3SetFloat64";
        let Some(instance) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        let (set, count) = (self.functions().set_float64, values.len());
        // SAFETY: the instance is alive, both slices have the lengths given.
        let status =
            unsafe { set(instance, references.as_ptr(), references.len(), values.as_ptr(), count) };
        self.check(CALL, status)
    }

    /// `fmi3GetBoolean`; anything but 0 is true. Scalars allocate nothing.
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [bool]) -> Result<(), Error> {
        if references.len() != values.len() {
            let mut bytes = vec![0; values.len()];
            return self.get_boolean_bytes(references, &mut bytes, values);
        }
        for (references, values) in references.chunks(CHUNK).zip(values.chunks_mut(CHUNK)) {
            let mut bytes = [0; CHUNK];
            self.get_boolean_bytes(references, &mut bytes[..references.len()], values)?;
        }
        Ok(())
    }

    /// Reads truth values as bytes, of which there are as many as values.
    fn get_boolean_bytes(
        &mut self,
        references: &[u32],
        bytes: &mut [u8],
        values: &mut [bool],
    ) -> Result<(), Error> {
        const CALL: &str = "fmi3GetBoolean";
        let get = self.optional(self.functions().get_boolean, CALL)?;
        let Some(instance) = self.ready(&CALL, references.len(), bytes.len())? else {
            return Ok(());
        };
        let (count, place) = (references.len(), bytes.as_mut_ptr().cast());
        // SAFETY: the instance is alive, both slices have the lengths given, and C's `bool` is one
        // byte.
        let status = unsafe { get(instance, references.as_ptr(), count, place, bytes.len()) };
        self.check(CALL, status)?;
        values.iter_mut().zip(bytes).for_each(|(value, byte)| *value = *byte != 0);
        Ok(())
    }

    /// `fmi3SetBoolean`
    pub fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Result<(), Error> {
        const CALL: &str = "fmi3SetBoolean";
        let set = self.optional(self.functions().set_boolean, CALL)?;
        let Some(instance) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        // SAFETY: the instance is alive, both slices have the lengths given.
        let status = unsafe {
            set(instance, references.as_ptr(), references.len(), values.as_ptr(), values.len())
        };
        self.check(CALL, status)
    }

    /// `fmi3GetString`, of scalars, one by one: the FMU's text lives only until the next call. The
    /// buffers of `values` are reused; null is read as empty.
    pub fn get_string(&mut self, references: &[u32], values: &mut [String]) -> Result<(), Error> {
        const CALL: &str = "fmi3GetString";
        let get = self.optional(self.functions().get_string, CALL)?;
        self.same_length(CALL, references.len(), values.len())?;
        for (reference, value) in references.iter().zip(values) {
            let instance = self.alive(&CALL)?;
            let mut text: fmi3String = ptr::null();
            // SAFETY: the instance is alive; one reference, one place.
            let status = unsafe { get(instance, reference, 1, &raw mut text, 1) };
            self.check(CALL, status)?;
            value.clear();
            // SAFETY: after success null or a zero-terminated text, valid until the next call.
            value.push_str(&unsafe { text_of(text) });
        }
        Ok(())
    }

    /// `fmi3SetString`
    ///
    /// # Errors
    /// [`Error::ZeroByte`] before anything is written, besides a failed call.
    pub fn set_string(&mut self, references: &[u32], values: &[&str]) -> Result<(), Error> {
        const CALL: &str = "fmi3SetString";
        let set = self.optional(self.functions().set_string, CALL)?;
        let texts = values
            .iter()
            .map(|value| c_text(&self.name, "the value", value))
            .collect::<Result<Vec<_>, _>>()?;
        let pointers: Vec<fmi3String> = texts.iter().map(|text| text.as_ptr()).collect();
        let Some(instance) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        let (count, texts_of_c) = (references.len(), pointers.as_ptr());
        // SAFETY: the instance is alive; the texts outlive the call.
        let status =
            unsafe { set(instance, references.as_ptr(), count, texts_of_c, pointers.len()) };
        self.check(CALL, status)
    }

    /// Directional derivative (`fmi3GetDirectionalDerivative`):
    /// `sensitivity = ∂unknown/∂known · seed`.
    pub fn get_directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), Error> {
        const CALL: &str = "fmi3GetDirectionalDerivative";
        let get = self.optional(self.functions().get_directional_derivative, CALL)?;
        let Some(instance) = self.ready(&CALL, unknowns.len(), sensitivity.len())? else {
            return Ok(());
        };
        // SAFETY: the instance is alive, the slices have the lengths given.
        let status = unsafe {
            get(
                instance,
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seed.as_ptr(),
                seed.len(),
                sensitivity.as_mut_ptr(),
                sensitivity.len(),
            )
        };
        self.check(CALL, status)
    }

    /// Time derivatives of outputs (`fmi3GetOutputDerivatives`), one order per reference.
    pub fn get_output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<(), Error> {
        const CALL: &str = "fmi3GetOutputDerivatives";
        let get = self.optional(self.functions().get_output_derivatives, CALL)?;
        self.same_length(CALL, references.len(), orders.len())?;
        let Some(instance) = self.ready(&CALL, references.len(), values.len())? else {
            return Ok(());
        };
        let (count, places) = (references.len(), values.as_mut_ptr());
        // SAFETY: the instance is alive, the slices have the lengths given.
        let status = unsafe {
            get(instance, references.as_ptr(), count, orders.as_ptr(), places, values.len())
        };
        self.check(CALL, status)
    }

    /// The instance, if a call is to be made: not for no references. An array may have more values
    /// than references, but none has fewer.
    #[inline]
    fn ready(
        &self,
        call: &'static &'static str,
        references: usize,
        values: usize,
    ) -> Result<Option<fmi3Instance>, Error> {
        if values < references || (references == 0 && values > 0) {
            return Err(Error::Length { fmu: self.name.clone(), call, references, values });
        }
        if references == 0 {
            return Ok(None);
        }
        self.alive(call).map(Some)
    }

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
