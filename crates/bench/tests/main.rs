//! The tests of the bench that need no process of their own: every file beside this one is a module.
//! One program: it links once, and its tests share the processors to the end.

mod common;

automod::dir!("tests");
