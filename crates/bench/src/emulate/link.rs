//! A way that packets take, with what goes wrong on it.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::fault::{Active, OnPackets, Script};

/// What was injected; every packet that went in is counted in `packets`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Injected {
    /// Packets that went in.
    pub packets: u64,
    /// Packets that vanished.
    pub lost: u64,
    /// Packets that were held back.
    pub reordered: u64,
    /// Packets that came out twice.
    pub duplicated: u64,
    /// Packets that came out damaged.
    pub corrupted: u64,
}

/// A way that packets take.
#[derive(Debug)]
pub struct Link {
    random: ChaCha8Rng,
    /// When it comes out, its place in order, its bytes.
    waiting: Vec<(u64, u64, Vec<u8>)>,
    order: u64,
    /// When the last packet that was not held back comes out.
    last_ns: u64,
    injected: Injected,
}

impl Link {
    /// A way; `stream` tells the ways of one seed apart.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        let injected = Injected::default();
        Link { random, waiting: Vec::new(), order: 0, last_ns: 0, injected }
    }

    /// What was injected so far.
    #[must_use]
    pub fn injected(&self) -> &Injected {
        &self.injected
    }

    /// When the next packet comes out.
    #[must_use]
    pub fn next_ns(&self) -> Option<u64> {
        self.waiting.iter().map(|(due, _, _)| *due).min()
    }

    /// A packet goes in, with what a script does to measurements at this time in s.
    pub fn send(&mut self, now_ns: u64, packet: &[u8], script: &Script, time: f64) {
        let mut active = Active::default();
        script.activate(time, &mut active);
        self.push(now_ns, packet, &active.measurements);
    }

    /// The next packet that has come out by now.
    pub fn receive(&mut self, now_ns: u64) -> Option<Vec<u8>> {
        self.pop(now_ns)
    }

    /// A packet goes in.
    pub(crate) fn push(&mut self, now_ns: u64, packet: &[u8], faults: &OnPackets) {
        // As many draws for each packet, whatever happens to it: a script that changes one fault
        // leaves the others' dice as they were.
        let mut draw = || self.random.next_u64() as f64 / (u64::MAX as f64 + 1.0);
        let [jitter, lost, held, twice, damaged] = std::array::from_fn(|_| draw());
        self.injected.packets += 1;
        if lost < faults.loss {
            self.injected.lost += 1;
            return;
        }
        let mut bytes = packet.to_vec();
        if damaged < faults.corrupt {
            self.injected.corrupted += 1;
            self.damage(&mut bytes);
        }
        let delay = faults.delay + jitter * faults.jitter;
        let due = (now_ns + (delay * 1e9) as u64).max(self.last_ns);
        if twice < faults.duplicate {
            self.injected.duplicated += 1;
            self.wait(due, bytes.clone());
        }
        if held < faults.reorder.0 {
            self.injected.reordered += 1;
            self.wait(due + (faults.reorder.1 * 1e9) as u64, bytes);
        } else {
            self.last_ns = due;
            self.wait(due, bytes);
        }
    }

    fn wait(&mut self, due: u64, bytes: Vec<u8>) {
        self.order += 1;
        self.waiting.push((due, self.order, bytes));
    }

    /// Changes one to four bytes next to each other.
    fn damage(&mut self, bytes: &mut [u8]) {
        let word = self.random.next_u64();
        let length = (1 + word % 4) as usize;
        let start = ((word >> 8) as usize) % bytes.len().max(1);
        for (index, byte) in bytes.iter_mut().skip(start).take(length).enumerate() {
            let bits = (word >> (24 + 8 * index)) as u8;
            *byte ^= bits.max(1);
        }
    }

    /// The next packet that has come out by now.
    pub(crate) fn pop(&mut self, now_ns: u64) -> Option<Vec<u8>> {
        let due = self.waiting.iter().enumerate().filter(|(_, (due, _, _))| *due <= now_ns);
        let (index, _) = due.min_by_key(|(_, (due, order, _))| (*due, *order))?;
        Some(self.waiting.remove(index).2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn through(faults: &OnPackets, packets: u32, seed: u64) -> (Vec<u32>, Injected) {
        let mut link = Link::new(seed, 0);
        let mut out = Vec::new();
        for k in 0..packets + 50 {
            let now = u64::from(k) * 1_000_000;
            if k < packets {
                link.push(now, &k.to_le_bytes(), faults);
            }
            while let Some(bytes) = link.pop(now) {
                out.push(u32::from_le_bytes(bytes.try_into().unwrap()));
            }
        }
        (out, *link.injected())
    }

    #[test]
    fn without_faults_nothing_happens() {
        let (out, injected) = through(&OnPackets::default(), 100, 1);
        assert_eq!(out, (0..100).collect::<Vec<_>>());
        assert_eq!(injected, Injected { packets: 100, ..Injected::default() });
    }

    #[test]
    fn the_same_seed_gives_the_same_faults() {
        let faults = OnPackets { loss: 0.1, duplicate: 0.1, ..OnPackets::default() };
        let (one, counts) = through(&faults, 1000, 5);
        assert_eq!((one.clone(), counts), through(&faults, 1000, 5));
        assert_ne!(one, through(&faults, 1000, 6).0);
        assert_eq!(one.len() as u64, 1000 - counts.lost + counts.duplicated);
    }

    #[test]
    fn jitter_keeps_the_order_and_reordering_does_not() {
        let jitter = OnPackets { jitter: 5e-3, ..OnPackets::default() };
        assert!(through(&jitter, 500, 2).0.is_sorted());
        let reorder = OnPackets { reorder: (0.1, 2.5e-3), ..OnPackets::default() };
        let (out, injected) = through(&reorder, 500, 2);
        assert!(injected.reordered > 20 && !out.is_sorted());
        assert_eq!(out.len(), 500);
    }

    #[test]
    fn damage_is_damage() {
        let faults = OnPackets { corrupt: 1.0, ..OnPackets::default() };
        let (out, injected) = through(&faults, 300, 9);
        assert_eq!(injected.corrupted, 300);
        assert!(out.iter().zip(0..).all(|(found, k)| *found != k));
    }
}
