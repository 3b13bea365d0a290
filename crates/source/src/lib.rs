//! FMUs for targets that no shared library of ours is for: [`spec`], the model as bytes; `package`, the files below
//! `sources/`; `component`, the WebAssembly component.

#[cfg(not(target_family = "wasm"))]
mod component;
#[cfg(not(target_family = "wasm"))]
pub mod package;
pub mod spec;

#[cfg(not(target_family = "wasm"))]
pub use component::component;
