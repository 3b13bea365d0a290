//! The FMUs' shared libraries, carried inside the tool.

/// A shared library for this platform.
pub(crate) struct Library {
    /// A ZIP archive with the library as its only entry, as a package takes it.
    pub(crate) bytes: &'static [u8],
}

/// The library of every packed blueprint, plant or controller.
pub(crate) const BLUEPRINT: Library =
    Library { bytes: include_bytes!(concat!(env!("OUT_DIR"), "/piezoloop_fmu_blueprint.zip")) };

/// The repaired FMU's library.
pub(crate) const WRAP: Library =
    Library { bytes: include_bytes!(concat!(env!("OUT_DIR"), "/piezoloop_fmu_wrap.zip")) };

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
