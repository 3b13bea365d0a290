//! Prints the reference of all signals: `cargo run -p piezoloop-signals --example
//! signals_reference > crates/signals/SIGNALS.md`.
#![allow(clippy::print_stdout)]

fn main() {
    print!("{}", signals::document());
}
