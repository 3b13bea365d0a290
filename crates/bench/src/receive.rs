//! What arrives: which packet holds the newest good sample, and what happened to the others.

use crate::packet::{self, Header, Kind, PacketError, Status};

/// Sequences that are remembered, to tell a duplicate from a packet that comes late.
const WINDOW: u32 = 1024;
/// A sequence that is further ahead of the newest is not awaited.
const JUMP: u32 = 1 << 16;
/// So many packets in a row that are not awaited, in order: the peer counts anew.
const RESTART: u32 = 3;

/// What happened to the packets of one direction. Every packet is counted once, or never arrived.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counters {
    /// Samples that were used.
    pub used: u64,
    /// Sequences that never came with a good checksum (a corrupt packet's sequence is one).
    pub lost: u64,
    /// In order, but older than allowed when it came; not used.
    pub late: u64,
    /// A sequence that had come already; not used.
    pub duplicate: u64,
    /// Came after a newer one; not used.
    pub reordered: u64,
    /// Damaged on the way (length, first bytes, checksum); not used.
    pub corrupt: u64,
    /// Undamaged, but of another version, kind or number of channels; not used.
    pub mismatched: u64,
    /// A value was not finite; not used.
    pub not_finite: u64,
    /// The machine's sensors said that the values are not valid; not used.
    pub invalid: u64,
    /// From before the first packet, or too far from the newest to be awaited; not used.
    pub stale: u64,
    /// The peer began to count anew.
    pub restarts: u64,
}

/// What one packet was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// The newest sample; it is used.
    Fresh,
    /// See [`Counters::late`].
    Late,
    /// See [`Counters::duplicate`].
    Duplicate,
    /// See [`Counters::reordered`].
    Reordered,
    /// See [`Counters::corrupt`] and [`Counters::mismatched`].
    Refused(PacketError),
    /// See [`Counters::not_finite`].
    NotFinite,
    /// See [`Counters::invalid`].
    Invalid,
    /// See [`Counters::stale`].
    Stale,
    /// The peer counts anew; this is its sample, and it is used.
    Restarted,
}

/// Takes the packets of one direction, and keeps the newest good sample.
#[derive(Clone, Debug)]
pub struct Receiver {
    kind: Kind,
    /// Greatest age, in cycles of the receiver, at which a sample is used.
    max_age: u32,
    counters: Counters,
    newest: Option<u32>,
    /// Bit i: the sequence i below the newest has come.
    seen: [u64; (WINDOW / 64) as usize],
    /// So many sequences below the newest were awaited, at most the window.
    awaited: u32,
    /// Newest packet of a possible restart, and how many there were.
    restart: (u32, u32),
    header: Option<Header>,
    values: Box<[f64]>,
    incoming: Box<[f64]>,
}

impl Receiver {
    /// A receiver of packets of this kind. `max_age`: a sample whose echo is more cycles behind is
    /// late.
    #[must_use]
    pub fn new(kind: Kind, channels: usize, max_age: u32) -> Self {
        Receiver {
            kind,
            max_age,
            counters: Counters::default(),
            newest: None,
            seen: [0; (WINDOW / 64) as usize],
            awaited: 0,
            restart: (0, 0),
            header: None,
            values: vec![0.0; channels].into(),
            incoming: vec![0.0; channels].into(),
        }
    }

    /// What was counted so far.
    #[must_use]
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Header of the newest packet in order, whatever its values are; `None` before the first.
    #[must_use]
    pub fn header(&self) -> Option<&Header> {
        self.header.as_ref()
    }

    /// Values of the newest good sample; zeros before the first.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Looks at one packet. `sent`: sequence of the newest packet that went the other way.
    ///
    /// The age of a sample is `sent` minus the sequence that its sender had received when it
    /// sampled; before the sender has received anything its samples have no age.
    pub fn receive(&mut self, bytes: &[u8], sent: u32) -> Arrival {
        let header = match packet::decode(bytes, self.kind, &mut self.incoming) {
            Ok(header) => header,
            Err(error) => {
                let corrupt = error.is_corruption();
                self.counters.corrupt += u64::from(corrupt);
                self.counters.mismatched += u64::from(!corrupt);
                return Arrival::Refused(error);
            }
        };
        let arrival = self.order(header.sequence);
        if !matches!(arrival, Arrival::Fresh | Arrival::Restarted) {
            return arrival;
        }
        self.header = Some(header);
        self.judge(&header, sent, arrival)
    }

    /// Whether the newest packet's sample may be used.
    fn judge(&mut self, header: &Header, sent: u32, arrival: Arrival) -> Arrival {
        let age = sent.wrapping_sub(header.echo_sequence);
        let has_age = header.echo_time_ns != 0;
        let is_measurement = self.kind == Kind::Measurement;
        if self.incoming.iter().any(|value| !value.is_finite()) {
            self.counters.not_finite += 1;
            return Arrival::NotFinite;
        }
        if is_measurement && !header.status.has(Status::VALID) {
            self.counters.invalid += 1;
            return Arrival::Invalid;
        }
        // An echo ahead of what was sent wraps to a great age: it is from an earlier session.
        if has_age && age > self.max_age {
            self.counters.late += 1;
            return Arrival::Late;
        }
        self.counters.used += 1;
        std::mem::swap(&mut self.values, &mut self.incoming);
        arrival
    }

    /// Where a sequence stands among those that came.
    fn order(&mut self, sequence: u32) -> Arrival {
        let Some(newest) = self.newest else {
            self.begin(sequence);
            return Arrival::Fresh;
        };
        let ahead = sequence.wrapping_sub(newest);
        if ahead != 0 && ahead < JUMP {
            self.counters.lost += u64::from(ahead - 1);
            self.shift(ahead);
            self.newest = Some(sequence);
            self.restart = (0, 0);
            return Arrival::Fresh;
        }
        let behind = newest.wrapping_sub(sequence);
        if behind > self.awaited {
            return self.not_awaited(sequence);
        }
        let (word, bit) = ((behind / 64) as usize, behind % 64);
        if self.seen[word] >> bit & 1 == 1 {
            self.counters.duplicate += 1;
            return Arrival::Duplicate;
        }
        self.seen[word] |= 1 << bit;
        self.counters.reordered += 1;
        self.counters.lost = self.counters.lost.saturating_sub(1);
        Arrival::Reordered
    }

    fn begin(&mut self, sequence: u32) {
        self.newest = Some(sequence);
        self.seen = [0; (WINDOW / 64) as usize];
        self.seen[0] = 1;
        self.awaited = 0;
        self.restart = (0, 0);
    }

    fn not_awaited(&mut self, sequence: u32) -> Arrival {
        let (last, count) = self.restart;
        let follows = count > 0 && sequence.wrapping_sub(last) == 1;
        self.restart = (sequence, if follows { count + 1 } else { 1 });
        if self.restart.1 >= RESTART {
            self.begin(sequence);
            self.counters.restarts += 1;
            return Arrival::Restarted;
        }
        self.counters.stale += 1;
        Arrival::Stale
    }

    /// Moves the remembered sequences up; the newest one has come.
    fn shift(&mut self, by: u32) {
        let (words, bits) = ((by / 64) as usize, by % 64);
        let old = self.seen;
        for (index, word) in self.seen.iter_mut().enumerate() {
            let from = |back: usize| index.checked_sub(back).map_or(0, |place| old[place]);
            let low = from(words);
            *word = if bits == 0 { low } else { low << bits | from(words + 1) >> (64 - bits) };
        }
        self.seen[0] |= 1;
        self.awaited = self.awaited.saturating_add(by).min(WINDOW - 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packet(sequence: u32, echo: u32, value: f64, status: Status) -> Vec<u8> {
        let header = Header {
            kind: Kind::Measurement,
            channels: 1,
            sequence,
            status,
            time_ns: 1,
            echo_sequence: echo,
            state: 0,
            reason: 0,
            echo_time_ns: u64::from(echo != 0),
        };
        let mut bytes = [0; packet::MAX_BYTES];
        let length = packet::encode(&header, &[value], &mut bytes);
        bytes[..length].to_vec()
    }

    const GOOD: Status = Status(Status::POWERED.0 | Status::VALID.0);

    fn receiver() -> Receiver {
        Receiver::new(Kind::Measurement, 1, 2)
    }

    fn take(receiver: &mut Receiver, sequence: u32) -> Arrival {
        receiver.receive(&packet(sequence, 0, f64::from(sequence), GOOD), 0)
    }

    #[test]
    fn each_packet_is_counted_once() {
        let mut receiver = receiver();
        let order = [5, 6, 8, 8, 7, 7, 11, 9, 5];
        let found: Vec<Arrival> = order.iter().map(|s| take(&mut receiver, *s)).collect();
        use Arrival::{Duplicate, Fresh, Reordered};
        let expected =
            [Fresh, Fresh, Fresh, Duplicate, Reordered, Duplicate, Fresh, Reordered, Duplicate];
        assert_eq!(found, expected);
        let counters = receiver.counters();
        assert_eq!((counters.used, counters.lost), (4, 1), "only 10 is lost");
        assert_eq!((counters.duplicate, counters.reordered), (3, 2));
        assert_eq!(receiver.values(), [11.0]);
    }

    #[test]
    fn sequences_wrap() {
        let mut receiver = receiver();
        for sequence in [u32::MAX - 1, u32::MAX, 0, 2, 1] {
            take(&mut receiver, sequence);
        }
        assert_eq!(receiver.counters().lost, 0);
        assert_eq!(receiver.counters().reordered, 1);
        assert_eq!(receiver.values(), [2.0]);
    }

    #[test]
    fn a_gap_wider_than_the_window_forgets_nothing_wrongly() {
        let mut receiver = receiver();
        for sequence in [0, 5000, 4999, 4999, 3977, 3976, 70_537] {
            take(&mut receiver, sequence);
        }
        let counters = receiver.counters();
        assert_eq!((counters.reordered, counters.duplicate, counters.stale), (2, 1, 2));
        assert_eq!(counters.lost, 4999 - 2);
    }

    #[test]
    fn what_was_sent_before_the_first_packet_is_not_counted_as_lost() {
        let mut receiver = receiver();
        let found: Vec<Arrival> = [5, 4, 6].iter().map(|s| take(&mut receiver, *s)).collect();
        assert_eq!(found, [Arrival::Fresh, Arrival::Stale, Arrival::Fresh]);
        assert_eq!(receiver.counters().lost, 0);
    }

    #[test]
    fn old_samples_are_late_and_not_used() {
        let mut receiver = receiver();
        assert_eq!(receiver.receive(&packet(1, 10, 1.0, GOOD), 12), Arrival::Fresh);
        assert_eq!(receiver.receive(&packet(2, 10, 2.0, GOOD), 13), Arrival::Late);
        // An echo of a session that is over.
        assert_eq!(receiver.receive(&packet(3, 9000, 3.0, GOOD), 14), Arrival::Late);
        assert_eq!(receiver.values(), [1.0]);
        assert_eq!(receiver.counters().late, 2);
    }

    #[test]
    fn values_that_no_controller_may_see_are_not_used() {
        let mut receiver = receiver();
        take(&mut receiver, 1);
        let arrival = |r: &mut Receiver, bytes: &[u8]| r.receive(bytes, 0);
        let nan = packet(2, 0, f64::NAN, GOOD);
        assert_eq!(arrival(&mut receiver, &nan), Arrival::NotFinite);
        assert_eq!(arrival(&mut receiver, &packet(3, 0, 9.0, Status::POWERED)), Arrival::Invalid);
        let mut damaged = packet(4, 0, 9.0, GOOD);
        damaged[41] ^= 4;
        let refused = Arrival::Refused(PacketError::Checksum);
        assert_eq!(arrival(&mut receiver, &damaged), refused);
        assert_eq!(receiver.values(), [1.0]);
        take(&mut receiver, 5);
        assert_eq!(receiver.counters().lost, 1, "the damaged one");
    }

    #[test]
    fn a_peer_that_counts_anew_is_found_out() {
        let mut receiver = receiver();
        take(&mut receiver, 100_000);
        let found: Vec<Arrival> = (0..4).map(|s| take(&mut receiver, s)).collect();
        use Arrival::{Fresh, Restarted, Stale};
        assert_eq!(found, [Stale, Stale, Restarted, Fresh]);
        assert_eq!(receiver.counters().restarts, 1);
    }
}
