//! The FMUs' shared libraries, carried inside the tool.

/// A shared library for this platform.
pub(crate) struct Library {
    /// Bytes of the file.
    pub(crate) bytes: &'static [u8],
}

/// The library of every packed blueprint, plant or controller.
pub(crate) const BLUEPRINT: Library =
    Library { bytes: include_bytes!(env!("PIEZOLOOP_BLUEPRINT_LIBRARY")) };

/// The repaired FMU's library.
pub(crate) const WRAP: Library = Library { bytes: include_bytes!(env!("PIEZOLOOP_WRAP_LIBRARY")) };

/// The FMI 2.0 folder of the platform that the tool was built for.
pub(crate) const PLATFORM: &str = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    "linux64"
} else if cfg!(all(target_os = "windows", target_arch = "x86_64")) {
    "win64"
} else if cfg!(target_os = "macos") {
    "darwin64"
} else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    "aarch64-linux"
} else if cfg!(all(target_os = "linux", target_arch = "arm")) {
    "aarch32-linux"
} else {
    "unknown"
};
