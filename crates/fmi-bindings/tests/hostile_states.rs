//! Serialised FMU states that were tampered with: refused with a message, or, where the checksum was made
//! right again, taken as a state of numbers that the instance then computes with; nothing panics, and a
//! reset leads back to a new instance.
//!
//! `PIEZOLOOP_STATES=10000000 cargo test --release -p piezoloop-fmi-bindings --test hostile_states` tries
//! so many.
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each block calls the edge as an importer does, by the standard's contract"
)]
#![allow(clippy::print_stdout)]

mod support;

use std::ptr::null_mut;

use counting::Counting;
use fmi_bindings::export::v2;
use fmi_bindings::fmi2::*;
use support::{Fmu, Random, plant};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const NUMBERS: [u64; 8] = [
    0,
    1,
    0x7ff0_0000_0000_0000,
    0x7ff8_0000_0000_0001,
    u64::MAX,
    1 << 63,
    0x7fef_ffff_ffff_ffff,
    5,
];

/// Damages some bytes; often the checksum fits the damage.
fn damaged(good: &[u8], random: &mut Random) -> Vec<u8> {
    let mut below = |n: usize| (random.unit() * n as f64) as usize;
    let mut bytes = good.to_vec();
    for _ in 0..=below(3) {
        let at = below(bytes.len());
        match below(4) {
            0 => bytes[at] = below(256) as u8,
            1 => bytes[at] ^= 1 << below(8),
            2 => {
                let number = NUMBERS[below(NUMBERS.len())].to_le_bytes();
                // The numbers stand behind head and progress, at whole words from there.
                let at = (52 + 2 + 8 * below(bytes.len() / 8)).min(bytes.len() - 8);
                bytes[at..at + 8].copy_from_slice(&number);
            }
            _ => {
                let length = below(bytes.len() + 16);
                bytes.resize(length.max(8), 0xa5);
            }
        }
    }
    if below(3) > 0 {
        if below(2) > 0 && bytes.len() >= 20 {
            let length = (bytes.len() as u64).to_le_bytes();
            bytes[12..20].copy_from_slice(&length);
        }
        let end = bytes.len() - 8;
        let sum = model::fnv_64(bytes[..end].iter().copied()).to_le_bytes();
        bytes[end..].copy_from_slice(&sum);
    }
    bytes
}

#[test]
fn no_state_panics_or_takes_memory() {
    let all: u64 =
        std::env::var("PIEZOLOOP_STATES").ok().and_then(|n| n.parse().ok()).unwrap_or(100_000);
    // A state may switch on the component that panics on purpose; its backtraces would take memory.
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !info.to_string().contains("on 100% purpose") {
            usual(info);
        }
    }));
    let fmu = Fmu::ready(plant);
    fmu.set_real("command[1]", 30.0);
    assert_eq!(fmu.step(0.0, 5e-3), fmi2OK);
    let good = fmu.bytes(fmu.save());
    let wanted = {
        let fresh = Fmu::ready(plant);
        fresh.set_real("command[1]", 30.0);
        assert_eq!(fresh.step(0.0, 5e-3), fmi2OK);
        fresh.real("position[1]").to_bits()
    };
    let mut random = Random(20_261);
    let (mut taken, mut stepped, mut refused, mut most) = (0_u64, 0_u64, 0_u64, 0);
    for k in 0..all {
        let bytes = damaged(&good, &mut random);
        let before = counting::reset_peak();
        let mut state = null_mut();
        if fmu.deserialize(&bytes, &mut state) == fmi2OK {
            taken += 1;
            if fmu.restore(state) == fmi2OK {
                let mut time = 0.0;
                let asked =
                    unsafe { v2::fmi2GetRealStatus(fmu.c, fmi2LastSuccessfulTime, &mut time) };
                if asked == fmi2OK {
                    // A step of a few hits, from wherever the state says that it is.
                    stepped += u64::from(fmu.step(time, 3e-3) == fmi2OK);
                }
            }
            unsafe { v2::fmi2FreeFMUstate(fmu.c, &mut state) };
        } else {
            refused += 1;
            assert!(state.is_null());
        }
        most = most.max(counting::peak().saturating_sub(before));
        assert!(most < 1 << 20, "state {k} takes {most} bytes");
        assert_eq!(fmu.reset(), fmi2OK);
        fmu.recorder.0.lock().unwrap().clear();
        if k % 1000 == 0 {
            fmu.start(0.0);
            fmu.set_real("command[1]", 30.0);
            assert_eq!(fmu.step(0.0, 5e-3), fmi2OK);
            assert_eq!(fmu.real("position[1]").to_bits(), wanted, "state {k}: not as new");
        }
    }
    println!(
        "{all} states: {refused} refused, {taken} taken, {stepped} steps from them; at most {most} bytes"
    );
    assert!(taken > 0 && refused > 0);
}
