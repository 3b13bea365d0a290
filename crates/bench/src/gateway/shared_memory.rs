//! Shared memory of one host, over iceoryx2.
//!
//! Two blackboard services, `piezoloop/NAME/command` and `piezoloop/NAME/measurement`, are rings of
//! the newest 64 packets: packet n (from 1) stands under the key n modulo 64 as its number, its
//! length and its bytes, and the key 64 has the number of the newest. iceoryx2 was chosen because its
//! interface is safe, its data path is free of locks, and it has bindings for C, C++ and Python; a
//! ring of our own over a mapped file would need `unsafe`. Its publish-subscribe services were tried
//! first: each loan of a sample makes a reference-counted block (`ChunkMutSharedState`) from the
//! process' allocator, however the pool of samples is set up. Blackboards copy in place.

use std::time::Duration;

use iceoryx2::node::Node;
use iceoryx2::port::reader::{EntryHandle, Reader};
use iceoryx2::port::writer::{EntryHandleMut, Writer};
use iceoryx2::prelude::{NodeBuilder, ServiceName, ipc};
use iceoryx2::service::builder::blackboard::{BlackboardCreateError, BlackboardOpenError};
use iceoryx2::service::port_factory::blackboard::PortFactory;

use super::{End, Gateway, GatewayError};
use crate::packet::MAX_BYTES;

/// Packets that wait to be received; of more, the oldest are dropped.
const DEPTH: u64 = 64;
/// Number and length before the bytes of a packet.
const HEAD: usize = 8 + 4;

/// One place of the ring.
type Slot = [u8; HEAD + MAX_BYTES];
type Service = ipc::Service;

/// The end of a ring that writes.
struct Sender {
    slots: Vec<EntryHandleMut<Service, u64, Slot>>,
    newest: EntryHandleMut<Service, u64, u64>,
    count: u64,
    _writer: Writer<Service, u64>,
}

/// The end of a ring that reads.
struct Taker {
    slots: Vec<EntryHandle<Service, u64, Slot>>,
    newest: EntryHandle<Service, u64, u64>,
    /// Number of the newest packet that was taken.
    taken: u64,
    _reader: Reader<Service, u64>,
}

/// Writes one ring, reads the other.
pub struct SharedMemoryGateway {
    sender: Sender,
    taker: Taker,
    _node: Node<Service>,
}

impl std::fmt::Debug for SharedMemoryGateway {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let counts = (self.sender.count, self.taker.taken);
        f.debug_tuple("SharedMemoryGateway").field(&counts).finish()
    }
}

/// A place with a packet.
fn slot(number: u64, packet: &[u8]) -> Option<Slot> {
    let mut slot = [0; HEAD + MAX_BYTES];
    slot[..8].copy_from_slice(&number.to_le_bytes());
    slot[8..HEAD].copy_from_slice(&u32::try_from(packet.len()).ok()?.to_le_bytes());
    slot.get_mut(HEAD..HEAD + packet.len())?.copy_from_slice(packet);
    Some(slot)
}

/// The packet of a place, if it is the one of this number.
fn packet_of(slot: &Slot, number: u64) -> Option<&[u8]> {
    let (found, rest) = slot.split_first_chunk::<8>()?;
    let (length, bytes) = rest.split_first_chunk::<4>()?;
    let length = u32::from_le_bytes(*length) as usize;
    (u64::from_le_bytes(*found) == number).then(|| bytes.get(..length))?
}

/// Opens a service, or makes it: whoever comes first.
fn service(node: &Node<Service>, name: &str) -> Result<PortFactory<Service, u64>, String> {
    let name = ServiceName::new(name).map_err(|error| format!("{error:?}"))?;
    let mut trouble = String::new();
    for _ in 0..50 {
        match node.service_builder(&name).blackboard_opener::<u64>().open() {
            Ok(service) => return Ok(service),
            Err(BlackboardOpenError::DoesNotExist) => {}
            Err(error) => trouble = format!("{error:?}"),
        }
        let mut creator = node.service_builder(&name).blackboard_creator::<u64>().max_readers(4);
        for key in 0..DEPTH {
            creator = creator.add::<Slot>(key, [0; HEAD + MAX_BYTES]);
        }
        match creator.add::<u64>(DEPTH, 0).create() {
            Ok(service) => return Ok(service),
            // The other end was faster by a moment.
            Err(
                BlackboardCreateError::AlreadyExists
                | BlackboardCreateError::IsBeingCreatedByAnotherInstance,
            ) => {}
            Err(error) => trouble = format!("{error:?}"),
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    Err(trouble)
}

impl Sender {
    fn new(service: &PortFactory<Service, u64>, newest: u64) -> Result<Self, String> {
        let writer = service.writer_builder().create().map_err(|error| format!("{error:?}"))?;
        let slots = (0..DEPTH).map(|key| writer.entry::<Slot>(&key)).collect::<Result<_, _>>();
        let slots = slots.map_err(|error| format!("{error:?}"))?;
        let entry = writer.entry::<u64>(&DEPTH).map_err(|error| format!("{error:?}"))?;
        Ok(Sender { slots, newest: entry, count: newest, _writer: writer })
    }
}

impl Taker {
    /// It begins behind the packets that are there.
    fn new(service: &PortFactory<Service, u64>) -> Result<Self, String> {
        let reader = service.reader_builder().create().map_err(|error| format!("{error:?}"))?;
        let slots = (0..DEPTH).map(|key| reader.entry::<Slot>(&key)).collect::<Result<_, _>>();
        let slots = slots.map_err(|error| format!("{error:?}"))?;
        let newest = reader.entry::<u64>(&DEPTH).map_err(|error| format!("{error:?}"))?;
        let taken = *newest.get();
        Ok(Taker { slots, newest, taken, _reader: reader })
    }
}

impl SharedMemoryGateway {
    /// Opens one end; whoever comes first makes the memory.
    ///
    /// # Errors
    /// Shared memory cannot be made, or another program has this end.
    pub fn open(name: &str, end: End) -> Result<Self, GatewayError> {
        let failed = |what: &str, error: String| GatewayError::Open {
            address: format!("shm://{name}"),
            what: what.to_owned(),
            error,
            way_out: "choose another name, or end the programs that use this one".to_owned(),
        };
        let node = NodeBuilder::new()
            .create::<Service>()
            .map_err(|error| failed("a node of iceoryx2", format!("{error:?}")))?;
        let ring = |direction: &str| {
            service(&node, &format!("piezoloop/{name}/{direction}"))
                .map_err(|error| failed("the service", error))
        };
        let (command, measurement) = (ring("command")?, ring("measurement")?);
        let (out, into) = match end {
            End::Runner => (command, measurement),
            End::Machine => (measurement, command),
        };
        let reader = |error| failed("reading", error);
        // A writer that follows another one counts on.
        let newest = Taker::new(&out).map_err(reader)?.taken;
        let sender = Sender::new(&out, newest)
            .map_err(|error| failed("another program has this end", error))?;
        let taker = Taker::new(&into).map_err(reader)?;
        Ok(SharedMemoryGateway { sender, taker, _node: node })
    }
}

impl Gateway for SharedMemoryGateway {
    fn send(&mut self, packet: &[u8]) -> bool {
        let number = self.sender.count + 1;
        let Some(slot) = slot(number, packet) else { return false };
        self.sender.slots[(number % DEPTH) as usize].update_with_copy(slot);
        self.sender.newest.update_with_copy(number);
        self.sender.count = number;
        true
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let newest = *self.taker.newest.get();
        self.taker.taken = self.taker.taken.max(newest.saturating_sub(DEPTH));
        while self.taker.taken < newest {
            let number = self.taker.taken + 1;
            self.taker.taken = number;
            let slot = self.taker.slots[(number % DEPTH) as usize].get();
            // One that was overwritten meanwhile is one that was dropped.
            if let Some(packet) = packet_of(&slot, number) {
                let length = packet.len().min(buffer.len());
                buffer[..length].copy_from_slice(&packet[..length]);
                return Some(length);
            }
        }
        None
    }

    fn wait(&mut self, timeout: Duration) {
        // Looks again often; the wait of a peer in shared memory has no event.
        let begin = std::time::Instant::now();
        while begin.elapsed() < timeout {
            if *self.taker.newest.get() > self.taker.taken {
                return;
            }
            std::thread::sleep(Duration::from_micros(20).min(timeout));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_go_both_ways() {
        let name = format!("test-{}", std::process::id());
        let mut runner = SharedMemoryGateway::open(&name, End::Runner).unwrap();
        let mut machine = SharedMemoryGateway::open(&name, End::Machine).unwrap();
        let mut buffer = [0; MAX_BYTES];
        assert_eq!(machine.receive(&mut buffer), None);
        assert!(runner.send(b"one") && runner.send(b"four"));
        machine.wait(Duration::from_secs(5));
        assert_eq!(machine.receive(&mut buffer), Some(3));
        assert_eq!(machine.receive(&mut buffer), Some(4));
        assert_eq!(machine.receive(&mut buffer), None);
        assert!(machine.send(&[7; MAX_BYTES]));
        assert_eq!(runner.receive(&mut buffer), Some(MAX_BYTES));
        assert_eq!(buffer, [7; MAX_BYTES]);
        // Who does not look loses the oldest.
        for k in 0..100u8 {
            assert!(runner.send(&[k]));
        }
        assert_eq!((machine.receive(&mut buffer), buffer[0]), (Some(1), 100 - DEPTH as u8));
    }

    #[test]
    fn one_end_is_opened_once() {
        let name = format!("once-{}", std::process::id());
        let first = SharedMemoryGateway::open(&name, End::Runner).unwrap();
        let message = SharedMemoryGateway::open(&name, End::Runner).unwrap_err().to_string();
        assert!(message.contains("another program"), "{message}");
        drop(first);
    }
}
