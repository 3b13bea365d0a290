//! A million packets over a bad line: no wrong sample is used, and everything is counted.
#![allow(clippy::print_stdout)]

use bench::emulate::Link;
use bench::packet::{Header, Kind, MAX_BYTES, Status, encode};
use bench::receive::{Arrival, Receiver};

const PACKETS: u32 = 1_000_000;
const PERIOD_NS: u64 = 100_000;
/// Sequences start below the wrap, so that it is crossed.
const FIRST: u32 = u32::MAX - 300_000;

/// What the sample of a sequence must be.
fn sample(sequence: u32) -> [f64; 4] {
    let x = f64::from(sequence);
    [x, -x, x.sqrt(), 1.0 / (1.0 + x)]
}

#[test]
fn a_million_packets_with_loss_reordering_and_corruption() {
    let seed = 20_260;
    println!("seed {seed}");
    let script = "[[fault]]\nkind = \"loss\"\nprobability = 0.01\n\
                  [[fault]]\nkind = \"reorder\"\nprobability = 0.01\nseconds = 250e-6\n\
                  [[fault]]\nkind = \"corrupt\"\nprobability = 0.001\n";
    let script = bench::emulate::Script::parse(script, "script").unwrap();
    let mut line = Link::new(seed, 0);
    let mut receiver = Receiver::new(Kind::Measurement, 4, 1000);
    let (mut used, mut last_used) = (0u64, None);
    let mut overtaken = 0u64;
    for k in 0..PACKETS + 100 {
        let now = u64::from(k) * PERIOD_NS;
        let sequence = FIRST.wrapping_add(k);
        if k < PACKETS {
            let header = Header {
                kind: Kind::Measurement,
                channels: 4,
                sequence,
                status: Status::POWERED.with(Status::VALID),
                time_ns: now,
                echo_sequence: sequence,
                state: 0,
                reason: 0,
                echo_time_ns: now + 1,
            };
            let mut bytes = [0; MAX_BYTES];
            let length = encode(&header, &sample(sequence), &mut bytes);
            line.send(now, &bytes[..length], &script, 0.0);
        }
        while let Some(bytes) = line.receive(now) {
            match receiver.receive(&bytes, sequence) {
                Arrival::Fresh => {
                    let header = receiver.header().unwrap();
                    assert_eq!(receiver.values(), sample(header.sequence), "a wrong sample");
                    let place = header.sequence.wrapping_sub(FIRST);
                    assert!(last_used.is_none_or(|last| place > last), "an old sample");
                    last_used = Some(place);
                    used += 1;
                }
                Arrival::Reordered => overtaken += 1,
                Arrival::Refused(error) => assert!(error.is_corruption(), "{error}"),
                other => panic!("{other:?}"),
            }
        }
    }
    let (injected, counted) = (*line.injected(), *receiver.counters());
    println!("injected: {injected:?}\ncounted: {counted:?}");
    assert_eq!(counted.used, used);
    assert_eq!(counted.corrupt, injected.corrupted);
    assert_eq!(counted.reordered, overtaken);
    // What did not arrive whole is lost, nothing else is; each packet is in one class.
    assert_eq!(counted.lost, injected.lost + injected.corrupted);
    assert_eq!(u64::from(PACKETS), used + overtaken + counted.lost);
    // A packet that was held back is overtaken, unless its followers were lost or held back too.
    let held = injected.reordered;
    assert!(overtaken <= held && overtaken as f64 > 0.95 * held as f64, "{overtaken} of {held}");
    for (count, rate) in [(injected.lost, 0.01), (held, 0.01), (injected.corrupted, 0.001)] {
        let expected = rate * f64::from(PACKETS);
        assert!((count as f64 - expected).abs() < 6.0 * expected.sqrt(), "{count}");
    }
    assert_eq!((counted.late, counted.duplicate, counted.mismatched, counted.stale), (0, 0, 0, 0));
}
