//! A key that both ends hold: version 2 of the packet, for networks that others are on.
//!
//! It goes around another gateway. What is above it sends and receives packets of version 1; on the
//! way a packet has version 2, and in the place of its checksum
//!
//! | bytes | field | meaning |
//! |---|---|---|
//! | 8 | session | drawn by the sender when it began |
//! | 8 | peer | the newest session that the sender heard of its peer; 0: none |
//! | 8 | counter | counted up with every packet of the session, from 1 |
//! | 16 | tag | the first 16 bytes of HMAC-SHA-256 (RFC 2104, FIPS 198-1) of all bytes before it |
//!
//! HMAC-SHA-256 and no faster function, since every machine has it: the standard libraries of Python,
//! OpenSSL and mbedTLS compute it, microcontrollers have it in hardware.
//!
//! A packet is taken whose tag is right, whose `peer` is the own session, so that it was made in this
//! run, and whose counter is new: not before the newest 64, and not taken already. A packet with a right tag
//! and another `peer` is answered by one without channels, from which its sender learns the session; and
//! its own session is learnt unless the peer of a known one has been heard of in the last
//! [`SILENCE`]. So a run that was recorded cannot be played again, in another run either.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use thiserror::Error;

use super::{End, Gateway};
use crate::packet::{CHECKSUM, HEADER, Kind, MAGIC, MAX_BYTES, VERSION};

/// Version of the packet with a tag.
pub const KEYED_VERSION: u8 = 2;
/// Bytes of the tag.
const TAG: usize = 16;
/// Bytes behind the values.
const TRAILER: usize = 24 + TAG;
/// Longest packet with a tag.
const LONGEST: usize = MAX_BYTES - CHECKSUM + TRAILER;
/// A peer that was silent for so long may have begun anew.
const SILENCE: Duration = Duration::from_millis(100);
/// Fewest bytes of a key, and most.
const KEY: std::ops::RangeInclusive<usize> = 16..=4096;

/// A key that cannot be used.
#[derive(Debug, Error)]
#[error("{}: {rule}; make one with `head -c 32 /dev/urandom > bench.key` and give both ends the same", file.display())]
pub struct KeyError {
    file: PathBuf,
    rule: String,
}

/// The bytes of a key.
#[derive(Clone)]
pub struct Key(Hmac<Sha256>);

impl std::fmt::Debug for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Key(…)")
    }
}

impl Key {
    /// Reads a file whose bytes, all of them, are the key.
    ///
    /// # Errors
    /// It cannot be read, or has fewer than 16 or more than 4096 bytes.
    pub fn read(file: &Path) -> Result<Self, KeyError> {
        let refuse = |rule: String| KeyError { file: file.to_owned(), rule };
        files::note_read(file);
        let most = *KEY.end() as u64 + 1;
        let mut bytes = Vec::new();
        std::fs::File::open(file)
            .and_then(|opened| io::Read::read_to_end(&mut io::Read::take(opened, most), &mut bytes))
            .map_err(|error| refuse(format!("cannot be read: {error}")))?;
        if !KEY.contains(&bytes.len()) {
            return Err(refuse(format!("a key has 16 to 4096 bytes, this file {}", bytes.len())));
        }
        Ok(Key::of(&bytes))
    }

    /// The key of these bytes.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        // Keys of every length are taken.
        Key(Hmac::new_from_slice(bytes).unwrap_or_else(|_| Hmac::new(&Default::default())))
    }

    fn tag(&self, bytes: &[u8]) -> Hmac<Sha256> {
        let mut mac = self.0.clone();
        mac.update(bytes);
        mac
    }
}

/// What was refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Refused {
    /// Packets without a tag, or with a wrong one.
    pub forged: u64,
    /// Packets with a right tag of another run, or that had come.
    pub replayed: u64,
}

/// Sessions of the peer that are over: nothing of them is taken again.
const OVER: usize = 64;

/// The counters of a session that have come.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    newest: u64,
    /// Bit n: `newest - n` has come.
    window: u64,
}

impl Seen {
    /// Whether this counter is new; it is not the next time.
    fn takes(&mut self, counter: u64) -> bool {
        if counter > self.newest {
            let ahead = counter - self.newest;
            self.window = if ahead < 64 { self.window << ahead | 1 } else { 1 };
            self.newest = counter;
            return counter > 0;
        }
        let behind = self.newest - counter;
        let is_new = behind < 64 && counter > 0 && self.window >> behind & 1 == 0;
        if is_new {
            self.window |= 1 << behind;
        }
        is_new
    }
}

/// A gateway with a key.
pub struct KeyedGateway {
    inner: Box<dyn Gateway>,
    key: Key,
    kind: Kind,
    session: u64,
    counter: u64,
    peer: u64,
    seen: Seen,
    /// When the peer's session was last proved to be of this run.
    heard: Option<Instant>,
    /// A ring of sessions that were proved once.
    over: [u64; OVER],
    ended: usize,
    refused: Refused,
    out: [u8; LONGEST],
    buffer: [u8; LONGEST + 1],
}

impl KeyedGateway {
    /// Puts a key around one end of a gateway. `session` is drawn anew for each run: a random number
    /// that nobody can foretell.
    #[must_use]
    pub fn new(inner: Box<dyn Gateway>, end: End, key: Key, session: u64) -> Self {
        let kind = match end {
            End::Runner => Kind::Command,
            End::Machine => Kind::Measurement,
        };
        KeyedGateway {
            inner,
            key,
            kind,
            // 0 stands for none.
            session: session.max(1),
            counter: 0,
            peer: 0,
            seen: Seen::default(),
            heard: None,
            over: [0; OVER],
            ended: 0,
            refused: Refused::default(),
            out: [0; LONGEST],
            buffer: [0; LONGEST + 1],
        }
    }

    /// The time that key and unkey of a packet of this many channels take on this computer, in s.
    #[must_use]
    pub fn cost(key: &Key, channels: usize) -> f64 {
        const TIMES: u32 = 2000;
        let bytes = [0; LONGEST];
        let bytes = &bytes[..(HEADER + 8 * channels + TRAILER - TAG).min(LONGEST)];
        let begin = Instant::now();
        for _ in 0..TIMES {
            std::hint::black_box(key.tag(std::hint::black_box(bytes)).finalize());
        }
        2.0 * begin.elapsed().as_secs_f64() / f64::from(TIMES)
    }

    /// From now on this is the peer's session.
    fn turn_to(&mut self, session: u64) {
        if self.heard.take().is_some() {
            self.over[self.ended % OVER] = self.peer;
            self.ended += 1;
        }
        (self.peer, self.seen) = (session, Seen::default());
    }

    /// Sends what stands in `out` up to `body`, with the trailer behind it.
    fn seal(&mut self, body: usize) -> bool {
        self.counter += 1;
        self.out[4] = KEYED_VERSION;
        let fields = [self.session, self.peer, self.counter];
        for (place, field) in
            self.out[body..body + 24].as_chunks_mut::<8>().0.iter_mut().zip(fields)
        {
            *place = field.to_le_bytes();
        }
        let tag = self.key.tag(&self.out[..body + 24]).finalize().into_bytes();
        self.out[body + 24..body + TRAILER].copy_from_slice(&tag[..TAG]);
        self.inner.send(&self.out[..body + TRAILER])
    }

    /// A packet without channels, from which the peer learns this session.
    fn greet(&mut self) {
        self.out[..HEADER].fill(0);
        self.out[..4].copy_from_slice(&MAGIC);
        self.out[5] = self.kind as u8;
        // One that is lost is asked for again by the next packet.
        self.seal(HEADER);
    }

    /// Takes the packet of this length in `buffer`; the length of what is to be handed up.
    fn open(&mut self, length: usize) -> Option<usize> {
        let complete = &self.buffer[..length];
        let other = match self.kind {
            Kind::Command => Kind::Measurement,
            Kind::Measurement => Kind::Command,
        };
        let fits = (HEADER + TRAILER..=LONGEST).contains(&length)
            && complete[..4] == MAGIC
            && complete[4] == KEYED_VERSION
            && complete[5] == other as u8;
        let (signed, tag) = complete.split_at(length.saturating_sub(TAG));
        // In a time that does not depend on where they differ.
        if !fits || self.key.tag(signed).verify_truncated_left(tag).is_err() {
            self.refused.forged += 1;
            return None;
        }
        let body = length - TRAILER;
        let mut fields = [0; 3];
        for (field, bytes) in fields.iter_mut().zip(signed[body..].as_chunks::<8>().0) {
            *field = u64::from_le_bytes(*bytes);
        }
        let [session, peer, counter] = fields;
        let is_greeting = body == HEADER;
        if peer != self.session {
            // Of another run, or of a peer that does not know this one yet.
            let is_known = self.heard.is_some_and(|heard| heard.elapsed() < SILENCE);
            if !is_known && session != self.peer && !self.over.contains(&session) {
                self.turn_to(session);
            }
            self.refused.replayed += u64::from(peer != 0);
            if !is_greeting {
                self.greet();
            }
            return None;
        }
        let is_over = session != self.peer && self.over.contains(&session);
        if session != self.peer && !is_over {
            self.turn_to(session);
        }
        if is_over || !self.seen.takes(counter) {
            self.refused.replayed += 1;
            return None;
        }
        self.heard = Some(Instant::now());
        if is_greeting {
            return None;
        }
        self.buffer[4] = VERSION;
        let checksum = crc32fast::hash(&self.buffer[..body]).to_le_bytes();
        self.buffer[body..body + CHECKSUM].copy_from_slice(&checksum);
        Some(body + CHECKSUM)
    }
}

impl Gateway for KeyedGateway {
    fn send(&mut self, packet: &[u8]) -> bool {
        let Some(body) = packet.len().checked_sub(CHECKSUM).filter(|n| *n <= LONGEST - TRAILER)
        else {
            return false;
        };
        self.out[..body].copy_from_slice(&packet[..body]);
        // What was damaged above, as the emulator does, arrives damaged.
        if crc32fast::hash(&packet[..body]).to_le_bytes() != packet[body..] {
            self.out[body..body + TRAILER].fill(0);
            return self.inner.send(&self.out[..body + TRAILER]);
        }
        self.seal(body)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        // As many as a network can bring meanwhile; the others wait for the next call.
        for _ in 0..1024 {
            let length = self.inner.receive(&mut self.buffer)?;
            if let Some(length) = self.open(length)
                && let Some(place) = buffer.get_mut(..length)
            {
                place.copy_from_slice(&self.buffer[..length]);
                return Some(length);
            }
        }
        None
    }

    fn wait(&mut self, timeout: Duration) {
        self.inner.wait(timeout);
    }

    fn refused(&self) -> Option<Refused> {
        Some(self.refused)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gateway::{MemoryGateway, pair};
    use crate::packet::{Header, Status, decode, encode};

    fn ends(keys: [&[u8]; 2]) -> (KeyedGateway, KeyedGateway, MemoryGateway, MemoryGateway) {
        let (a, b) = pair();
        let runner = KeyedGateway::new(Box::new(a.clone()), End::Runner, Key::of(keys[0]), 71);
        let machine = KeyedGateway::new(Box::new(b.clone()), End::Machine, Key::of(keys[1]), 72);
        (runner, machine, a, b)
    }

    fn packet(kind: Kind, sequence: u32, value: f64) -> Vec<u8> {
        let header = Header {
            kind,
            channels: 1,
            sequence,
            status: Status::ENABLE,
            time_ns: 5,
            echo_sequence: 0,
            state: 2,
            reason: 0,
            echo_time_ns: 0,
        };
        let mut bytes = [0; MAX_BYTES];
        let length = encode(&header, &[value], &mut bytes);
        bytes[..length].to_vec()
    }

    fn value(gateway: &mut KeyedGateway, kind: Kind) -> Option<f64> {
        let mut buffer = [0; MAX_BYTES];
        let length = gateway.receive(&mut buffer)?;
        let mut value = [0.0];
        decode(&buffer[..length], kind, &mut value).unwrap();
        Some(value[0])
    }

    /// Each learns the other's session from its first packets.
    fn met(runner: &mut KeyedGateway, machine: &mut KeyedGateway) {
        assert!(runner.send(&packet(Kind::Command, 1, 1.0)));
        assert_eq!(value(machine, Kind::Command), None);
        assert_eq!(value(runner, Kind::Measurement), None);
        assert!(runner.send(&packet(Kind::Command, 2, 2.0)));
        assert_eq!(value(machine, Kind::Command), Some(2.0));
        assert!(machine.send(&packet(Kind::Measurement, 1, 3.0)));
        assert_eq!(value(runner, Kind::Measurement), Some(3.0));
    }

    const KEY: &[u8] = b"0123456789abcdef";

    #[test]
    fn who_holds_the_key_is_heard_after_one_packet() {
        let (mut runner, mut machine, ..) = ends([KEY, KEY]);
        met(&mut runner, &mut machine);
        assert_eq!(runner.refused(), Some(Refused::default()));
        assert_eq!(machine.refused(), Some(Refused::default()));
    }

    #[test]
    fn another_key_and_none_are_forged() {
        let (mut runner, mut machine, mut wire, _) = ends([KEY, b"0123456789abcdeF"]);
        for sequence in 1..10 {
            assert!(runner.send(&packet(Kind::Command, sequence, 1.0)));
            wire.send(&packet(Kind::Command, sequence, 9.0));
        }
        assert_eq!(value(&mut machine, Kind::Command), None);
        assert_eq!(machine.refused(), Some(Refused { forged: 18, replayed: 0 }));
    }

    #[test]
    fn no_bit_can_be_changed() {
        let (mut runner, mut machine, mut wire, mut other) = ends([KEY, KEY]);
        met(&mut runner, &mut machine);
        runner.send(&packet(Kind::Command, 3, 4.0));
        let mut bytes = [0; LONGEST];
        let length = other.receive(&mut bytes).unwrap();
        for bit in 0..8 * length {
            let mut forged = bytes[..length].to_vec();
            forged[bit / 8] ^= 1 << (bit % 8);
            wire.send(&forged);
            assert_eq!(value(&mut machine, Kind::Command), None, "bit {bit}");
        }
        wire.send(&bytes[..length]);
        assert_eq!(value(&mut machine, Kind::Command), Some(4.0));
    }

    #[test]
    fn what_was_recorded_cannot_be_played_again() {
        let (mut runner, mut machine, mut wire, mut other) = ends([KEY, KEY]);
        met(&mut runner, &mut machine);
        let mut recorded = Vec::new();
        for sequence in 3..103 {
            runner.send(&packet(Kind::Command, sequence, f64::from(sequence)));
            let mut bytes = [0; LONGEST];
            let length = other.receive(&mut bytes).unwrap();
            recorded.push(bytes[..length].to_vec());
        }
        // In any order within the window, each once.
        for packet in recorded.iter().rev().chain(&recorded) {
            wire.send(packet);
        }
        let taken = std::iter::from_fn(|| value(&mut machine, Kind::Command)).count();
        assert_eq!(taken, 64);
        // In another run of the machine none is taken, and the real runner is.
        let mut machine =
            KeyedGateway::new(Box::new(other.clone()), End::Machine, Key::of(KEY), 73);
        recorded.iter().for_each(|packet| {
            wire.send(packet);
        });
        assert_eq!(value(&mut machine, Kind::Command), None);
        assert_eq!(machine.refused(), Some(Refused { forged: 0, replayed: 100 }));
        std::thread::sleep(SILENCE);
        for sequence in 200..203 {
            runner.send(&packet(Kind::Command, sequence, 5.0));
            let heard = value(&mut machine, Kind::Command);
            while value(&mut runner, Kind::Measurement).is_some() {}
            assert_eq!(heard.is_some(), sequence > 200, "{sequence}");
        }
    }

    #[test]
    fn keys_are_files_of_their_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("bench.key");
        std::fs::write(&file, b"short").unwrap();
        let reported = Key::read(&file).unwrap_err().to_string();
        assert!(reported.contains("16 to 4096") && reported.contains("urandom"), "{reported}");
        std::fs::write(&file, KEY).unwrap();
        assert!(Key::read(&file).is_ok());
        assert!(Key::read(Path::new("/dev/zero")).is_err());
        assert!(KeyedGateway::cost(&Key::of(KEY), 4) > 0.0);
    }
}
