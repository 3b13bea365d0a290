//! Packets within one thread: for tests, and for fault campaigns in virtual time.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Duration;

use super::Gateway;

type Queue = Rc<RefCell<VecDeque<Vec<u8>>>>;

/// One end of a pair of queues. It allocates for each packet: nothing for real time.
#[derive(Clone, Debug, Default)]
pub struct MemoryGateway {
    outgoing: Queue,
    incoming: Queue,
}

/// Two ends: what one sends the other receives.
#[must_use]
pub fn pair() -> (MemoryGateway, MemoryGateway) {
    let one = MemoryGateway::default();
    let other = MemoryGateway { outgoing: one.incoming.clone(), incoming: one.outgoing.clone() };
    (one, other)
}

impl Gateway for MemoryGateway {
    fn send(&mut self, packet: &[u8]) -> bool {
        self.outgoing.borrow_mut().push_back(packet.to_vec());
        true
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let packet = self.incoming.borrow_mut().pop_front()?;
        let length = packet.len().min(buffer.len());
        buffer[..length].copy_from_slice(&packet[..length]);
        Some(length)
    }

    fn wait(&mut self, _: Duration) {}
}
