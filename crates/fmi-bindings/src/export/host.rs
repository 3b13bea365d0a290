//! What is around a model inside WebAssembly: in a source-code FMU the C file `sources/fmu.h`, which
//! copies arguments in and results out and knows the importer.

use std::ffi::CStr;
#[cfg(not(feature = "component"))]
use std::ffi::c_char;

use super::notice::Status;

#[cfg(not(feature = "component"))]
#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// A message to the importer's logger.
    fn tell_importer(status: u32, category: *const c_char, message: *const c_char);
    /// The text of a panic, right before it ends the instance.
    fn keep_panic(text: *const u8, length: usize);
}

/// Sends a message to the importer.
pub(super) fn tell(status: Status, category: &CStr, message: &CStr) {
    #[cfg(feature = "component")]
    super::component::say(status as u32, category, message);
    // SAFETY: both texts end with a zero byte and live until the call returns.
    #[cfg(not(feature = "component"))]
    unsafe {
        tell_importer(status as u32, category.as_ptr(), message.as_ptr())
    }
}

/// Keeps the text of a panic outside, where it outlives the instance.
pub(super) fn panicked(text: &[u8]) {
    #[cfg(feature = "component")]
    super::component::panicked(text);
    // SAFETY: the length is that of the text.
    #[cfg(not(feature = "component"))]
    unsafe {
        keep_panic(text.as_ptr(), text.len())
    }
}

/// Exports what the C around the core calls beside the functions of FMI, for the models that `$build` makes of
/// bytes (`fn(&[u8]) -> Result<System, String>`), and names the factory of the FMI functions `$factory`.
#[macro_export]
macro_rules! export_core {
    ($factory:ident, $build:path) => {
        /// The model's bytes.
        static SPEC: ::std::sync::Mutex<Vec<u8>> = ::std::sync::Mutex::new(Vec::new());
        /// Where arguments and results lie; words, so that numbers are aligned.
        static ROOM: ::std::sync::Mutex<Vec<u64>> = ::std::sync::Mutex::new(Vec::new());

        /// Room for `length` bytes of the model, which are read at the next instantiation.
        #[unsafe(no_mangle)]
        pub extern "C" fn piezoloop_spec(length: usize) -> *mut u8 {
            let mut spec = SPEC.lock().unwrap_or_else(|broken| broken.into_inner());
            *spec = vec![0; length];
            spec.as_mut_ptr()
        }

        /// Room for `length` bytes of arguments and results; it stays where it is until more is asked for.
        #[unsafe(no_mangle)]
        pub extern "C" fn piezoloop_room(length: usize) -> *mut u64 {
            let mut room = ROOM.lock().unwrap_or_else(|broken| broken.into_inner());
            let words = length.div_ceil(8);
            if room.len() < words {
                *room = vec![0; words];
            }
            room.as_mut_ptr()
        }

        /// Builds the model whose bytes are there.
        fn $factory(_resources: &::std::path::Path) -> Result<::model::System, String> {
            let bytes = ::std::mem::take(&mut *SPEC.lock().map_err(|broken| broken.to_string())?);
            $build(&bytes)
        }
    };
}
