//! The tests of the bench that need no process of their own.
//! One program: it links once, and its tests share the processors to the end.

mod common;

mod campaign;
mod gcs;
mod hostile_packets;
mod nv200;
mod plugin;
mod replay;
