//! Which of the project's shared libraries a file is. The library says it itself, in bytes that it carries.

/// A shared library of an FMU of this project.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Library {
    /// Steps the blueprint in the FMU's resources, plant or controller.
    Blueprint,
    /// Steps another FMU, with effects around it: a repaired FMU.
    Wrap,
}

impl Library {
    const ALL: [Self; 2] = [Self::Blueprint, Self::Wrap];

    /// Its file's name is this, after the platform's prefix and before its extension.
    pub fn stem(self) -> &'static str {
        match self {
            Self::Blueprint => "piezoloop_fmu_blueprint",
            Self::Wrap => "piezoloop_fmu_wrap",
        }
    }

    const fn mark(self) -> &'static [u8] {
        match self {
            Self::Blueprint => b"piezoloop's FMU library, of a blueprint",
            Self::Wrap => b"piezoloop's FMU library, of a repair",
        }
    }

    /// Keeps the mark in the library that calls this; the linker drops what nothing uses.
    pub(super) fn carry(self) {
        std::hint::black_box(self.mark());
    }

    /// What the file with these bytes is; `None` if it is no library of this project.
    pub fn of(file: &[u8]) -> Option<Self> {
        let holds = |mark: &[u8]| file.windows(mark.len()).any(|part| part == mark);
        Self::ALL.into_iter().find(|library| holds(library.mark()))
    }
}
