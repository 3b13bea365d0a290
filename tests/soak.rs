//! A plant and its controller in a closed loop for very many steps: no drift in time or state.
//!
//! `PIEZOLOOP_SOAK=1000000000 cargo test --release --test soak -- --nocapture` takes so many.
#![cfg(target_os = "linux")]
#![allow(clippy::print_stdout)]

mod common;

use common::packed::{Host, PLANT, Packed, with};

/// A controller that is slow enough for the plant.
const SLOW: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/slow.toml");

#[test]
fn a_period_after_very_many_steps_is_the_first_one() {
    let steps = std::env::var("PIEZOLOOP_SOAK").unwrap_or_else(|_| "5000000".to_owned());
    let (plant, controller) = (Packed::new(PLANT, "2"), Packed::new(SLOW, "2"));
    let mut both = plant.arguments();
    both.extend(controller.arguments());
    let arguments = with(both, &[&controller.reference("enable"), &steps]);
    print!("{}", Host::new("soak.c").run(&arguments));
}
