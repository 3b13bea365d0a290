//! The files of a repaired FMU.

use std::ffi::{CStr, CString};
use std::path::{Path, PathBuf};

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_encode};
use surround::{Repair, Surround};

use crate::export::Library;
use crate::export::notice::Notice;
use crate::export::resources::{self, Location};

/// What stays as it is in a file URI.
const PLAIN: &AsciiSet =
    &NON_ALPHANUMERIC.remove(b'/').remove(b'-').remove(b'_').remove(b'.').remove(b'~');

/// The repair, and the folder of the original.
pub(super) struct Files {
    pub(super) surround: Surround,
    folder: PathBuf,
}

impl Files {
    /// Finds and reads the repair, and holds it against what the host gives.
    pub(super) fn read(
        location: Location<'_>,
        version: &str,
        token: Option<&CStr>,
    ) -> Result<Self, Notice> {
        Library::Wrap.carry();
        let resources = resources::find(location, surround::FILE).map_err(Notice::error)?;
        let resources = std::path::absolute(&resources).unwrap_or(resources);
        let repair = Repair::read(&resources).map_err(|e| Notice::error(e.to_string()))?;
        if repair.original.fmi != version {
            return Err(Notice::error(format!(
                "the original is of FMI {}, but it was instantiated with the functions of {version}",
                repair.original.fmi
            )));
        }
        if token.map(CStr::to_bytes) != Some(repair.token.as_bytes()) {
            let given = token.map_or("null".into(), CStr::to_string_lossy);
            return Err(Notice::error(format!(
                "the token of the model description is \"{given}\", the one of {} is \"{}\": they \
                 belong to different FMUs; repair the model again",
                resources.join(surround::FILE).display(),
                repair.token
            )));
        }
        let surround = Surround::new(repair).map_err(|e| Notice::error(e.to_string()))?;
        Ok(Self { surround, folder: resources.join("inner") })
    }

    /// The original's library.
    pub(super) fn library(&self, platform: &str) -> PathBuf {
        let identifier = &self.surround.repair().original.identifier;
        let file = format!("{identifier}.{EXTENSION}");
        self.folder.join("binaries").join(platform).join(file)
    }

    /// The original's token.
    pub(super) fn token(&self) -> Result<CString, Notice> {
        text(self.surround.repair().original.token.as_bytes())
    }

    /// The original's resources as a URI.
    pub(super) fn resources_uri(&self) -> Result<CString, Notice> {
        let path = bytes_of(&self.folder.join("resources"));
        let slash = if path.starts_with(b"/") { "" } else { "/" };
        text(format!("file://{slash}{}", percent_encode(&path, PLAIN)).as_bytes())
    }

    /// The original's resources as a path that ends with a separator.
    pub(super) fn resources_path(&self) -> Result<CString, Notice> {
        let mut path = self.folder.join("resources").into_os_string().into_encoded_bytes();
        path.push(std::path::MAIN_SEPARATOR as u8);
        text(&path)
    }
}

fn text(bytes: &[u8]) -> Result<CString, Notice> {
    CString::new(bytes).map_err(|_| Notice::error("a text of the repair holds a zero byte"))
}

/// A path as in URIs.
fn bytes_of(path: &Path) -> Vec<u8> {
    let bytes = path.as_os_str().to_os_string().into_encoded_bytes();
    bytes.into_iter().map(|b| if cfg!(windows) && b == b'\\' { b'/' } else { b }).collect()
}

/// Ending of shared libraries here.
const EXTENSION: &str = if cfg!(windows) {
    "dll"
} else if cfg!(target_os = "macos") {
    "dylib"
} else {
    "so"
};

/// The folder of this platform's library in FMI 2.0; one library serves both processors of macOS.
pub(super) const PLATFORM_V2: &str = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    "linux64"
} else if cfg!(all(target_os = "linux", target_arch = "x86")) {
    "linux32"
} else if cfg!(all(windows, target_arch = "x86_64")) {
    "win64"
} else if cfg!(all(windows, target_arch = "x86")) {
    "win32"
} else if cfg!(target_os = "macos") {
    "darwin64"
} else {
    PLATFORM_V3
};

/// The folder of this platform's library in FMI 3.0.
pub(super) const PLATFORM_V3: &str = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    "x86_64-linux"
} else if cfg!(all(target_os = "linux", target_arch = "x86")) {
    "x86-linux"
} else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    "aarch64-linux"
} else if cfg!(all(target_os = "linux", target_arch = "arm")) {
    "aarch32-linux"
} else if cfg!(all(windows, target_arch = "x86_64")) {
    "x86_64-windows"
} else if cfg!(all(windows, target_arch = "x86")) {
    "x86-windows"
} else if cfg!(all(windows, target_arch = "aarch64")) {
    "aarch64-windows"
} else if cfg!(all(target_os = "macos", target_arch = "x86_64")) {
    "x86_64-darwin"
} else if cfg!(all(target_os = "macos", target_arch = "aarch64")) {
    "aarch64-darwin"
} else {
    "unknown"
};
