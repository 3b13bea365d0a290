//! FMUs as C sources, for targets that no shared library of ours is for: [`spec`], the model as bytes, and
//! `package`, the files below `sources/`.

#[cfg(not(target_family = "wasm"))]
pub mod package;
pub mod spec;
