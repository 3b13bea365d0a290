//! Shared memory of one host, over iceoryx2.
//!
//! Two publish-subscribe services, `piezoloop/NAME/command` and `piezoloop/NAME/measurement`, whose
//! payload is the packet's bytes. iceoryx2 was chosen because its interface is safe, its data path
//! is free of locks, and it has bindings for C, C++ and Python; a ring of our own over a mapped file
//! would need `unsafe`. Measured: loaning a sample takes one small block from the allocator of the
//! process and gives it back, so a cycle over shared memory is not free of allocations, as one over
//! UDP is.

use std::time::Duration;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{NodeBuilder, ServiceName, ipc};

use super::{End, Gateway, GatewayError};
use crate::packet::MAX_BYTES;

/// Packets that wait to be received; of more, the oldest are dropped.
const DEPTH: usize = 64;

/// Publisher of one service, subscriber of the other.
#[derive(Debug)]
pub struct SharedMemoryGateway {
    publisher: Publisher<ipc::Service, [u8], ()>,
    subscriber: Subscriber<ipc::Service, [u8], ()>,
}

impl SharedMemoryGateway {
    /// Opens one end; whoever comes first makes the memory.
    ///
    /// # Errors
    /// Shared memory cannot be made, or an older layout of the same name is there.
    pub fn open(name: &str, end: End) -> Result<Self, GatewayError> {
        let failed = |what: &str, error: &dyn std::fmt::Debug| GatewayError::Open {
            address: format!("shm://{name}"),
            what: what.to_owned(),
            error: format!("{error:?}"),
            way_out: "choose another name, or end the programs that use this one".to_owned(),
        };
        let node = NodeBuilder::new()
            .create::<ipc::Service>()
            .map_err(|error| failed("a node of iceoryx2", &error))?;
        let service = |direction: &str| {
            let name = ServiceName::new(&format!("piezoloop/{name}/{direction}"))
                .map_err(|error| failed("the name of the service", &error))?;
            node.service_builder(&name)
                .publish_subscribe::<[u8]>()
                .max_publishers(1)
                .max_subscribers(2)
                .subscriber_max_buffer_size(DEPTH)
                .enable_safe_overflow(true)
                .open_or_create()
                .map_err(|error| failed("the service", &error))
        };
        let (command, measurement) = (service("command")?, service("measurement")?);
        let (out, into) = match end {
            End::Runner => (command, measurement),
            End::Machine => (measurement, command),
        };
        let publisher = out
            .publisher_builder()
            .initial_max_slice_len(MAX_BYTES)
            .create()
            .map_err(|error| failed("another program has this end", &error))?;
        let subscriber =
            into.subscriber_builder().create().map_err(|error| failed("the subscriber", &error))?;
        Ok(SharedMemoryGateway { publisher, subscriber })
    }
}

impl Gateway for SharedMemoryGateway {
    fn send(&mut self, packet: &[u8]) -> bool {
        let Ok(sample) = self.publisher.loan_slice_uninit(packet.len()) else { return false };
        sample.write_from_slice(packet).send().is_ok()
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let sample = self.subscriber.receive().ok().flatten()?;
        let length = sample.payload().len().min(buffer.len());
        buffer[..length].copy_from_slice(&sample.payload()[..length]);
        Some(length)
    }

    fn wait(&mut self, timeout: Duration) {
        // Looks again often; the wait of a peer in shared memory has no event.
        let begin = std::time::Instant::now();
        while begin.elapsed() < timeout {
            if self.subscriber.has_samples().unwrap_or(true) {
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
