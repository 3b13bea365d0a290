//! The tests of logs and blueprints.
//! One program: it links once, and its tests share the processors to the end. Each file of this folder is
//! a module of it.

mod common;

automod::dir!("tests");
