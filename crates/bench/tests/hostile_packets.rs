//! Packets that nobody should send: none makes the reader panic, and none is counted twice or not.
//!
//! `PIEZOLOOP_PACKETS=10000000 cargo test --release -p piezoloop-bench --test all hostile_packets::` tries so many.
#![allow(clippy::print_stdout)]

use bench::gateway::{End, Gateway, Key, KeyedGateway, MemoryGateway, pair};
use bench::packet::{
    CHECKSUM, Header, Kind, MAX_BYTES, PacketError, Status, decode, encode, length,
};
use bench::receive::{Arrival, Counters, Receiver};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const CHANNELS: usize = 3;

struct Dice(ChaCha8Rng);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        (self.0.next_u32() as usize) % n.max(1)
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

/// A packet; mostly of our channels and kind, its sequence near the one before.
fn packet(dice: &mut Dice, sequence: &mut u32, bytes: &mut [u8]) -> usize {
    let channels = if dice.one_in(20) { dice.below(129) } else { CHANNELS };
    *sequence = match dice.below(50) {
        0 => dice.0.next_u32(),
        1 => sequence.wrapping_sub(dice.below(2000) as u32),
        _ => sequence.wrapping_add(1),
    };
    let kind = if dice.one_in(20) { Kind::Command } else { Kind::Measurement };
    let header = Header {
        kind,
        channels: channels as u16,
        sequence: *sequence,
        status: Status(dice.0.next_u32()),
        time_ns: dice.0.next_u64(),
        echo_sequence: dice.0.next_u32() % 8,
        state: dice.0.next_u32() as u8,
        reason: dice.0.next_u32() as u8,
        echo_time_ns: dice.0.next_u64() % 3,
    };
    let values: Vec<f64> = (0..channels).map(|_| f64::from_bits(dice.0.next_u64())).collect();
    encode(&header, &values, bytes)
}

/// Damages a packet in place; its new length.
fn damage(dice: &mut Dice, bytes: &mut [u8], length: usize) -> usize {
    let mut length = length;
    for _ in 0..dice.below(4) {
        let place = dice.below(length);
        bytes[place] = dice.0.next_u32() as u8;
    }
    if dice.one_in(8) {
        length = dice.below(bytes.len() + 1);
    }
    // Half of the damaged ones have a checksum that fits the damage.
    if dice.one_in(2) && length >= CHECKSUM {
        let checksum = crc32fast::hash(&bytes[..length - CHECKSUM]);
        bytes[length - CHECKSUM..length].copy_from_slice(&checksum.to_le_bytes());
    }
    length
}

/// What is read is what stands there.
fn is_written_as(header: &Header, values: &[f64], bytes: &[u8]) {
    let mut again = [0; MAX_BYTES];
    let total = encode(header, values, &mut again);
    assert_eq!(total, bytes.len());
    assert_eq!(total, length(usize::from(header.channels)));
    // Bytes 30 and 31 are reserved: whatever a sender puts there is passed over.
    assert_eq!(again[..30], bytes[..30]);
    assert_eq!(again[32..total - CHECKSUM], bytes[32..total - CHECKSUM]);
}

fn total(counters: &Counters) -> u64 {
    counters.used
        + counters.late
        + counters.duplicate
        + counters.reordered
        + counters.corrupt
        + counters.mismatched
        + counters.not_finite
        + counters.invalid
        + counters.stale
}

#[test]
fn no_packet_panics_and_each_is_counted_once() {
    let seed = 20_261;
    let packets: u64 =
        std::env::var("PIEZOLOOP_PACKETS").ok().and_then(|n| n.parse().ok()).unwrap_or(1_000_000);
    let mut dice = Dice(ChaCha8Rng::seed_from_u64(seed));
    let mut receiver = Receiver::new(Kind::Measurement, CHANNELS, 5);
    let mut bytes = [0; 2 * MAX_BYTES];
    let (mut sequence, mut read, mut refused) = (0, 0u64, [0u64; 6]);
    for _ in 0..packets {
        let complete = packet(&mut dice, &mut sequence, &mut bytes);
        let length = match dice.one_in(2) {
            true => damage(&mut dice, &mut bytes, complete),
            false => complete,
        };
        let mut values = [7.0; CHANNELS];
        let found = &bytes[..length];
        match decode(found, Kind::Measurement, &mut values) {
            Ok(header) => {
                read += 1;
                is_written_as(&header, &values, found);
            }
            Err(error) => {
                assert_eq!(values, [7.0; CHANNELS], "a refused packet leaves the values alone");
                refused[match error {
                    PacketError::Length(_) => 0,
                    PacketError::Magic => 1,
                    PacketError::Checksum => 2,
                    PacketError::Version(_) => 3,
                    PacketError::Kind(_) => 4,
                    PacketError::Channels { .. } => 5,
                }] += 1;
            }
        }
        let used = receiver.counters().used;
        let arrival = receiver.receive(found, 6);
        if matches!(arrival, Arrival::Fresh | Arrival::Restarted) {
            assert_eq!(receiver.counters().used, used + 1);
            assert!(receiver.values().iter().all(|value| value.is_finite()));
            assert_eq!(receiver.values(), values);
        }
    }
    println!(
        "seed {seed}: {packets} packets, {read} read, refused for length, first bytes, checksum, \
         version, kind, channels: {refused:?}; {:?}",
        receiver.counters()
    );
    assert_eq!(total(receiver.counters()), packets, "each is counted once");
    let counters = receiver.counters();
    let all = [counters.used, counters.late, counters.duplicate, counters.reordered];
    assert!(refused.iter().chain(&all).all(|count| *count > 0), "everything happened");
}

/// A packet of version 2 that was changed in any bit, made with another key, cut or sent again is never
/// handed up; each that comes whole is, once.
#[test]
fn no_keyed_packet_is_taken_that_was_not_sent() {
    let seed = 20_262;
    let packets: u64 =
        std::env::var("PIEZOLOOP_PACKETS").ok().and_then(|n| n.parse().ok()).unwrap_or(300_000);
    let mut dice = Dice(ChaCha8Rng::seed_from_u64(seed));
    let (near, far) = pair();
    let end = |wire: &MemoryGateway, end, key: &[u8], session| {
        KeyedGateway::new(Box::new(wire.clone()), end, Key::of(key), session)
    };
    let key = b"0123456789abcdef";
    let mut runner = end(&near, End::Runner, key, dice.0.next_u64());
    let mut machine = end(&far, End::Machine, key, dice.0.next_u64());
    let (mut wire, mut tap) = (near.clone(), far.clone());
    let mut bytes = [0; 2 * MAX_BYTES];
    let (mut sequence, mut recorded): (u32, Vec<Vec<u8>>) = (0, Vec::new());
    let (mut complete, mut taken, mut twice) = (0_u64, 0_u64, 0_u64);
    for number in 0..packets {
        let mut command = [0; MAX_BYTES];
        let header = Header {
            kind: Kind::Command,
            channels: CHANNELS as u16,
            sequence,
            status: Status::ENABLE,
            time_ns: number,
            echo_sequence: 0,
            state: 2,
            reason: 0,
            echo_time_ns: 0,
        };
        sequence = sequence.wrapping_add(1);
        let length = encode(&header, &[1.0; CHANNELS], &mut command);
        assert!(runner.send(&command[..length]));
        let length = tap.receive(&mut bytes).expect("what was sent");
        let is_undamaged = dice.one_in(2);
        if is_undamaged {
            wire.send(&bytes[..length]);
            complete += u64::from(number > 0);
        } else {
            let before = bytes[..length].to_vec();
            let cut = damage(&mut dice, &mut bytes, length);
            if bytes[..cut] != before[..] {
                wire.send(&bytes[..cut]);
            }
        }
        if let Some(old) = recorded.get(dice.below(recorded.len() + 8)) {
            wire.send(old);
            twice += 1;
        }
        if is_undamaged {
            let place = dice.below(64);
            recorded.truncate(64);
            recorded.insert(place.min(recorded.len()), bytes[..length].to_vec());
        }
        while let Some(length) = machine.receive(&mut bytes) {
            let mut values = [0.0; CHANNELS];
            assert!(decode(&bytes[..length], Kind::Command, &mut values).is_ok());
            assert_eq!(values, [1.0; CHANNELS]);
            taken += 1;
        }
        // The machine's answers teach the runner its session.
        while runner.receive(&mut bytes).is_some() {}
    }
    let refused = machine.refused().expect("it has a key");
    println!(
        "seed {seed}: {packets} packets, {complete} whole, {taken} taken, {twice} sent again; {refused:?}"
    );
    assert!(taken <= complete && taken + 2 >= complete, "{taken} of {complete}");
    assert!(refused.forged > 0 && refused.replayed > 0);
}
