//! Platforms and the folders of `binaries/`.

use crate::description::FmiVersion;

/// A platform that FMUs carry shared libraries for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Platform {
    /// Name in FMI 3.0: architecture and operating system.
    pub tuple: &'static str,
    /// Name in FMI 2.0, if the standard gives one; other platforms use the tuple.
    pub fmi2: Option<&'static str>,
    /// Extension of shared libraries.
    pub extension: &'static str,
}

const fn platform(
    tuple: &'static str,
    fmi2: Option<&'static str>,
    extension: &'static str,
) -> Platform {
    Platform { tuple, fmi2, extension }
}

/// The platforms known here, by the tuples of FMI 3.0 (§2.5.1.4): `x86` and `aarch32` are its names of 32-bit processors.
pub const PLATFORMS: [Platform; 10] = [
    platform("x86_64-linux", Some("linux64"), "so"),
    platform("x86_64-windows", Some("win64"), "dll"),
    platform("x86_64-darwin", Some("darwin64"), "dylib"),
    platform("aarch64-linux", None, "so"),
    platform("aarch64-darwin", None, "dylib"),
    platform("aarch64-windows", None, "dll"),
    platform("aarch32-linux", None, "so"),
    platform("x86-linux", Some("linux32"), "so"),
    platform("x86-windows", Some("win32"), "dll"),
    platform("x86-darwin", Some("darwin32"), "dylib"),
];

/// The folder of WebAssembly components, by the draft of FMI-LS-WASM.
pub const WASM: &str = "wasm32-wasip2";
/// The manifest that the draft wants beside them.
pub const WASM_MANIFEST: &str = "extra/org.modelica.fmi-ls-wasm/manifest.xml";

impl Platform {
    /// The platform of this name, FMI 2.0 or FMI 3.0.
    pub fn from_name(name: &str) -> Option<Self> {
        PLATFORMS.into_iter().find(|p| p.tuple == name || p.fmi2 == Some(name))
    }

    /// The platform this program runs on, if FMUs can have binaries for it.
    pub fn host() -> Option<Self> {
        let architecture = match std::env::consts::ARCH {
            "arm" => "aarch32",
            other => other,
        };
        let system = match std::env::consts::OS {
            "macos" => "darwin",
            other => other,
        };
        Platform::from_name(&format!("{architecture}-{system}"))
    }

    /// Name of the folder below `binaries/` in this version of the standard.
    pub fn folder(self, version: FmiVersion) -> &'static str {
        match (version, self.fmi2) {
            (FmiVersion::V2, Some(name)) => name,
            _ => self.tuple,
        }
    }

    /// The folders a library may lie in, the right one first: FMUs of 2.0 with tuples are common.
    pub(crate) fn folders(self, version: FmiVersion) -> Vec<&'static str> {
        let mut folders = vec![self.folder(version), self.tuple];
        folders.extend(self.fmi2);
        // A universal library serves both architectures.
        if self.tuple == "aarch64-darwin" {
            folders.extend(["darwin64", "x86_64-darwin"]);
        }
        let mut seen = Vec::new();
        folders.retain(|folder| {
            !seen.contains(folder) && {
                seen.push(*folder);
                true
            }
        });
        folders
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_both_versions() {
        let linux = Platform::from_name("linux64").unwrap();
        assert_eq!(Platform::from_name("x86_64-linux"), Some(linux));
        assert_eq!(linux.folder(FmiVersion::V2), "linux64");
        assert_eq!(linux.folder(FmiVersion::V3), "x86_64-linux");
        assert_eq!(linux.folders(FmiVersion::V2), ["linux64", "x86_64-linux"]);
        assert_eq!(linux.folders(FmiVersion::V3), ["x86_64-linux", "linux64"]);
        let arm = Platform::from_name("aarch64-linux").unwrap();
        assert_eq!(arm.folder(FmiVersion::V2), "aarch64-linux");
        let windows = Platform::from_name("win32").unwrap();
        assert_eq!(windows.folder(FmiVersion::V3), "x86-windows");
        assert_eq!(Platform::from_name("vax-vms"), None);
    }
}
