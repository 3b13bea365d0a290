//! Pseudo-random binary sequence.

use crate::parameter::{HIGH, LOW, Parameter, SAMPLE_TIME};
use crate::rules::LOW_BELOW_HIGH;
use crate::signal_type::{ChannelType, Settings, SignalType};

/// Taps of shift registers with the longest cycle, from length 2 on: bit i − 1 of the mask is set
/// for tap i (Xilinx application note XAPP052, table 3).
const TAPS: [u32; 19] = [
    0x3, 0x6, 0xc, 0x14, 0x30, 0x60, 0xb8, 0x110, 0x240, 0x500, 0x829, 0x100d, 0x2015, 0x6000,
    0xd008, 0x1_2000, 0x2_0400, 0x4_0023, 0x9_0000,
];

const REGISTER: Parameter = Parameter::integer(
    "register",
    "Length m of the shift register; the sequence repeats after 2^m − 1 bits.",
    [10, 2, 20],
);
const SAMPLES_PER_BIT: Parameter = Parameter::integer(
    "samples_per_bit",
    "Samples that each bit is held; the spectrum has its first zero at 1/(samples_per_bit·T).",
    [1, 1, 1_000_000],
);
const PERIODS: Parameter =
    Parameter::integer("periods", "Number of equal periods.", [2, 1, 100_000]);
const SEED: Parameter = Parameter::integer(
    "seed",
    "Start of the sequence: the register holds 1 + seed mod (2^m − 1) at t = 0.",
    [0, 0, 1 << 53],
);

/// Pseudo-random binary sequence.
pub(crate) static BINARY: &[SignalType] = &[SignalType {
    name: "pseudo-random-binary",
    summary: "Maximum-length binary sequence: white over its lines, two levels only",
    source: "general; taps from Xilinx XAPP052, table 3",
    equation: "b = output of an m-bit linear feedback shift register; u = high where b = 1, else low",
    parameters: &[LOW, HIGH, REGISTER, SAMPLES_PER_BIT, PERIODS, SEED, SAMPLE_TIME],
    channels: &[ChannelType::new("u", "V", 0.0, 100.0)],
    rules: &[LOW_BELOW_HIGH],
    samples: |s| longest_cycle(s) as f64 * s.get(&SAMPLES_PER_BIT) * s.get(&PERIODS),
    law: |s| vec![binary(s)],
}];

fn longest_cycle(s: &Settings) -> usize {
    (1 << s.count(&REGISTER)) - 1
}

fn binary(s: &Settings) -> Vec<f64> {
    let (low, high) = (s.get(&LOW), s.get(&HIGH));
    let cycle = longest_cycle(s);
    let mut state = 1 + (s.get(&SEED) as u64 % cycle as u64) as u32;
    let mut period = Vec::with_capacity(cycle * s.count(&SAMPLES_PER_BIT));
    for _ in 0..cycle {
        let level = if state & 1 == 1 { high } else { low };
        period.extend(std::iter::repeat_n(level, s.count(&SAMPLES_PER_BIT)));
        state = next(state, s.count(&REGISTER));
    }
    period.repeat(s.count(&PERIODS))
}

/// The register after one shift: the parity of the tapped bits enters at bit 0.
fn next(state: u32, length: usize) -> u32 {
    let taps = TAPS.get(length - 2).copied().unwrap_or(0);
    let parity = (state & taps).count_ones() & 1;
    (state << 1 | parity) & ((1 << length) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_register_runs_through_all_states() {
        for length in 2..=20 {
            let (mut state, mut steps) = (next(1, length), 1);
            while state != 1 && steps < 1 << length {
                state = next(state, length);
                steps += 1;
            }
            assert_eq!(steps, (1 << length) - 1, "register of {length} bits");
        }
    }

    #[test]
    fn the_autocorrelation_has_two_values() {
        let signal = BINARY[0]
            .generate(&[("register", 7.0), ("periods", 1.0), ("low", -1.0), ("high", 1.0)])
            .expect("a sequence");
        let bits = &signal.channels[0].values;
        let at = |lag: usize| -> f64 {
            bits.iter().zip(bits.iter().cycle().skip(lag)).map(|(a, b)| a * b).sum()
        };
        assert_eq!((bits.len(), at(0)), (127, 127.0));
        assert!((1..127).all(|lag| at(lag) == -1.0));
    }

    #[test]
    fn bits_are_held_and_periods_repeat() {
        let settings = [("register", 3.0), ("samples_per_bit", 4.0), ("periods", 2.0)];
        let signal = BINARY[0].generate(&settings).expect("a sequence");
        let values = &signal.channels[0].values;
        assert_eq!(values.len(), 7 * 4 * 2);
        assert!(values.chunks(4).all(|bit| bit.iter().all(|v| *v == bit[0])));
        assert_eq!(values[..28], values[28..]);
    }
}
