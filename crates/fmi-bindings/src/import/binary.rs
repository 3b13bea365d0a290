//! A loaded shared library.

use std::path::{Path, PathBuf};

use super::error::Error;

/// A shared library of an FMU, loaded as the standard's functions expect it.
///
/// All symbols are bound at once (`RTLD_NOW`), so that a library with a missing dependence fails
/// here and not in the middle of a run, and stay private (`RTLD_LOCAL`), so that two FMUs do not
/// see each other's functions. The operating system gives the same library, with the same static
/// variables, to everyone who loads the same file: FMUs with global variables need one unpacked
/// folder per instance.
pub struct Binary {
    library: libloading::Library,
    path: PathBuf,
}

impl Binary {
    /// Loads the file at `path`, made absolute first so that no search path takes part.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let failed = |reason: String| Error::Load { path: path.to_path_buf(), reason };
        let absolute = std::path::absolute(path).map_err(|e| failed(e.to_string()))?;
        if !absolute.is_file() {
            return Err(failed("there is no such file".to_owned()));
        }
        let library = open(&absolute).map_err(|e| failed(reason(&e)))?;
        Ok(Binary { library, path: absolute })
    }

    /// The loaded file, absolute.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The function called `name`, if the library has it.
    ///
    /// # Safety
    /// `F` is the C function pointer type of that function, and is not called after `self` is gone.
    pub(crate) unsafe fn function<F: Copy>(&self, name: &str) -> Option<F> {
        // SAFETY: the type is promised by the caller.
        unsafe { self.library.get::<F>(name.as_bytes()) }.ok().map(|symbol| *symbol)
    }
}

/// Looks functions up and notes those that are missing.
pub(super) struct Finder<'a> {
    binary: &'a Binary,
    needed: Vec<&'static str>,
    other: Vec<&'static str>,
}

impl<'a> Finder<'a> {
    pub(super) fn new(binary: &'a Binary) -> Self {
        Finder { binary, needed: Vec::new(), other: Vec::new() }
    }

    /// The missing functions: those that are needed, and the others.
    pub(super) fn missing(self) -> (Vec<&'static str>, Vec<&'static str>) {
        (self.needed, self.other)
    }

    /// # Safety
    /// The contract of [`Binary::function`].
    pub(super) unsafe fn needed<F: Copy>(&mut self, name: &'static str) -> Option<F> {
        // SAFETY: promised by the caller.
        let function = unsafe { self.binary.function(name) };
        if function.is_none() {
            self.needed.push(name);
        }
        function
    }

    /// # Safety
    /// The contract of [`Binary::function`].
    pub(super) unsafe fn other<F: Copy>(&mut self, name: &'static str) -> Option<F> {
        // SAFETY: promised by the caller.
        let function = unsafe { self.binary.function(name) };
        if function.is_none() {
            self.other.push(name);
        }
        function
    }
}

#[cfg(unix)]
fn open(path: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
    // SAFETY: the initialisers of the library run: loading an FMU means to trust it.
    unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map(Into::into)
}

#[cfg(windows)]
fn open(path: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
    // SAFETY: the initialisers of the library run: loading an FMU means to trust it. Libraries
    // that lie beside it are found.
    unsafe { Library::load_with_flags(path, LOAD_WITH_ALTERED_SEARCH_PATH) }.map(Into::into)
}

/// The loader's own words, without the wrapper's.
fn reason(error: &libloading::Error) -> String {
    std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string)
}
