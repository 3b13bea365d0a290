//! The C edge of the bench's gateways: a shared library with the six functions of `gateway.h`
//! ([`HEADER`]), opened, called, and never believed.
//!
//! Rust calls C here and is never called back, so no panic crosses the edge. What a library writes is
//! checked: version, number of positions, positions that it left out, numbers beyond the last one.

use std::error::Error as _;
use std::ffi::{CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::ptr;

use libloading::Library;
use thiserror::Error;

/// The text of `gateway.h`.
pub const HEADER: &str = include_str!("../gateway.h");
/// `PIEZOLOOP_GATEWAY_VERSION` of that text.
pub const VERSION: u32 = 1;

const GOOD: i32 = 0;
const NO_SAMPLE: i32 = 1;
const VALID: u32 = 1;
const POWERED: u32 = 2;
/// Longest text that is taken from a library, in bytes.
const TEXT: usize = 1024;
/// Numbers behind the positions that must stay as they are.
const GUARD: usize = 64;
/// A NaN that no sensor sends: what was not written still has these bits.
const UNWRITTEN: u64 = 0x7ff4_5049_455a_4f00;

type VersionFn = unsafe extern "C" fn() -> u32;
type OpenFn = unsafe extern "C" fn(*const c_char, u32, f64, *mut *mut c_void) -> i32;
type DescribeFn = unsafe extern "C" fn(*mut c_void, *mut c_char, u32) -> i32;
type ExchangeFn =
    unsafe extern "C" fn(*mut c_void, u32, *const f64, *mut f64, *mut u32, *mut u32) -> i32;
type LastErrorFn = unsafe extern "C" fn(*mut c_void) -> *const c_char;
type CloseFn = unsafe extern "C" fn(*mut c_void);

/// A library that is no gateway, or whose card does not open.
#[derive(Debug, Error)]
pub enum PluginError {
    /// The file cannot be loaded.
    #[error("{}: cannot be loaded: {error}; build it with `cc -shared -fPIC` for this computer", path.display())]
    Load {
        /// File.
        path: PathBuf,
        /// What the system says.
        error: String,
    },
    /// A function is missing.
    #[error("{}: has no function {name}; `piezoloop bench header` prints gateway.h with all six", path.display())]
    Function {
        /// File.
        path: PathBuf,
        /// Function.
        name: &'static str,
    },
    /// It was built for another version of `gateway.h`.
    #[error("{}: was built with version {version} of gateway.h, this program speaks version {VERSION}; build it with the header that `piezoloop bench header` prints", path.display())]
    Version {
        /// File.
        path: PathBuf,
        /// The path's version.
        version: u32,
    },
    /// `open` failed.
    #[error("{}: does not open: {text} (code {code})", path.display())]
    Open {
        /// File.
        path: PathBuf,
        /// What the path returned.
        code: i32,
        /// What the code says.
        text: String,
    },
}

/// What a sample is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// The sensors are good.
    pub valid: bool,
    /// The power stage is on.
    pub powered: bool,
}

/// An open card.
#[derive(Debug)]
pub struct Plugin {
    path: PathBuf,
    card: *mut c_void,
    channels: usize,
    /// Positions, and the guard behind them.
    positions: Box<[f64]>,
    describe: DescribeFn,
    exchange: ExchangeFn,
    last_error: LastErrorFn,
    close: CloseFn,
    /// Last, so that the functions outlive their use.
    _library: Library,
}

impl Plugin {
    /// Loads a library and opens its card. `period` in s.
    ///
    /// # Errors
    /// It cannot be loaded, is no gateway of this version, or says no.
    pub fn open(
        path: &Path,
        options: &str,
        channels: usize,
        period: f64,
    ) -> Result<Self, PluginError> {
        let path = path.to_owned();
        let load = |error: String| PluginError::Load { path: path.clone(), error };
        // The system would look for a name without a folder elsewhere.
        let file = path.canonicalize().map_err(|error| load(error.to_string()))?;
        // SAFETY: the user names this library to be run; its initialisers are as trusted as itself.
        let library = unsafe { Library::new(&file) }.map_err(|error| {
            load(error.source().map_or_else(|| error.to_string(), ToString::to_string))
        })?;
        let version: VersionFn = function(&library, &path, "piezoloop_gateway_version")?;
        let open: OpenFn = function(&library, &path, "piezoloop_gateway_open")?;
        let describe = function(&library, &path, "piezoloop_gateway_describe")?;
        let exchange = function(&library, &path, "piezoloop_gateway_exchange")?;
        let last_error: LastErrorFn = function(&library, &path, "piezoloop_gateway_last_error")?;
        let close = function(&library, &path, "piezoloop_gateway_close")?;
        // SAFETY: the function takes nothing and returns a number, in every version of the header.
        let version = unsafe { version() };
        if version != VERSION {
            return Err(PluginError::Version { path, version });
        }
        let mut card = ptr::null_mut();
        let text = CString::new(options.replace('\0', " ")).unwrap_or_default();
        // SAFETY: the signature is that of the version that was just asked for; both pointers live
        // through the call.
        let code = unsafe { open(text.as_ptr(), channels as u32, period, &raw mut card) };
        if code != GOOD {
            let text = message(last_error, ptr::null_mut());
            return Err(PluginError::Open { path, code, text });
        }
        let positions = vec![0.0; channels + GUARD].into();
        Ok(Plugin {
            path,
            card,
            channels,
            positions,
            describe,
            exchange,
            last_error,
            close,
            _library: library,
        })
    }

    /// What the plugin says about its card; none if it says nothing.
    pub fn describe(&mut self) -> Option<String> {
        let mut text = vec![0_u8; TEXT];
        // SAFETY: the card is open, the buffer as long as stated.
        let code = unsafe { (self.describe)(self.card, text.as_mut_ptr().cast(), TEXT as u32) };
        let end = text.iter().position(|byte| *byte == 0).unwrap_or(TEXT);
        let text = String::from_utf8_lossy(&text[..end]).trim().to_owned();
        (code == GOOD && !text.is_empty()).then_some(text)
    }

    /// Commands out, positions in; none: nothing was measured. `commands` and `positions` have the
    /// channels that the card was opened with.
    ///
    /// # Errors
    /// What the library says, or what is wrong with what it wrote.
    pub fn exchange(
        &mut self,
        enable: bool,
        commands: &[f64],
        positions: &mut [f64],
    ) -> Result<Option<Sample>, String> {
        let channels = self.channels;
        if commands.len() != channels || positions.len() != channels {
            return Err(format!("{} commands for {channels} channels", commands.len()));
        }
        self.positions.fill(f64::from_bits(UNWRITTEN));
        let (mut count, mut status) = (0, 0);
        // SAFETY: the card is open; commands has `channels` numbers, the positions have more; all
        // pointers live through the call.
        let code = unsafe {
            (self.exchange)(
                self.card,
                u32::from(enable),
                commands.as_ptr(),
                self.positions.as_mut_ptr(),
                &raw mut count,
                &raw mut status,
            )
        };
        let name = self.path.display();
        let untouched = |value: &f64| value.to_bits() == UNWRITTEN;
        let (own, guard) = self.positions.split_at(channels);
        if !guard.iter().all(untouched) {
            return Err(format!("{name}: wrote more than {channels} positions"));
        }
        match code {
            GOOD => {}
            NO_SAMPLE => return Ok(None),
            code => {
                let text = message(self.last_error, self.card);
                return Err(format!("{name}: {text} (code {code})"));
            }
        }
        if count as usize != channels {
            return Err(format!("{name}: says that it wrote {count} of {channels} positions"));
        }
        if let Some(index) = own.iter().position(untouched) {
            return Err(format!("{name}: did not write position {}", index + 1));
        }
        if status & !(VALID | POWERED) != 0 {
            return Err(format!(
                "{name}: status {status:#x} has bits that gateway.h does not know"
            ));
        }
        positions.copy_from_slice(own);
        Ok(Some(Sample { valid: status & VALID != 0, powered: status & POWERED != 0 }))
    }
}

impl Drop for Plugin {
    fn drop(&mut self) {
        // SAFETY: the card is open, and is not used again.
        unsafe { (self.close)(self.card) }
    }
}

/// A function of a library. `T` must be its type.
fn function<T: Copy>(library: &Library, path: &Path, name: &'static str) -> Result<T, PluginError> {
    // SAFETY: the types are those of gateway.h, which the version that is asked for first vouches for.
    let found = unsafe { library.get::<T>(name.as_bytes()) };
    found.map(|f| *f).map_err(|_| PluginError::Function { path: path.to_owned(), name })
}

/// What the library says about its newest error.
fn message(last_error: LastErrorFn, card: *mut c_void) -> String {
    // SAFETY: the card is the library's own, or NULL after a failed open, as gateway.h says.
    let text = unsafe { last_error(card) };
    let mut bytes = Vec::new();
    while !text.is_null() && bytes.len() < TEXT {
        // SAFETY: gateway.h asks for a text that ends with a zero; nothing behind the zero is read.
        let byte = unsafe { *text.add(bytes.len()) } as u8;
        if byte == 0 {
            break;
        }
        bytes.push(byte);
    }
    match String::from_utf8_lossy(&bytes).trim() {
        "" => "it does not say why".to_owned(),
        text => text.to_owned(),
    }
}
