//! A recorded exchange of frames, played back.

use std::collections::VecDeque;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bench::gateway::ethercat::Wire;

use crate::segment::deliver;

/// Frames of a capture (pcapng) in order.
pub fn frames_of(path: &Path) -> Vec<Vec<u8>> {
    let bytes = std::fs::read(path).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let mut frames = Vec::new();
    let mut at = 0;
    while at + 12 <= bytes.len() {
        let (kind, length) = (word(at), word(at + 4));
        // Enhanced packet block: interface, time (2), captured, original length, bytes.
        if kind == 6 {
            let captured = word(at + 20);
            frames.push(bytes[at + 28..at + 28 + captured].to_vec());
        }
        at += length;
    }
    frames
}

/// The part of a frame by which an answer belongs to a question: command and index of each datagram.
fn key(frame: &[u8]) -> [u8; 2] {
    [frame[16], frame[17]]
}

/// Sent and returned frames of a capture, in the order in which they were sent.
pub fn exchanges(frames: Vec<Vec<u8>>) -> Vec<(Vec<u8>, Vec<u8>)> {
    let mut open: Vec<Vec<u8>> = Vec::new();
    let mut done = Vec::new();
    for frame in frames {
        assert_eq!(frame[12..14], [0x88, 0xa4], "a frame of EtherCAT");
        if frame[6] & 2 == 0 {
            open.push(frame);
        } else if let Some(place) = open.iter().position(|sent| key(sent) == key(&frame)) {
            done.push((open.remove(place), frame));
        }
    }
    done
}

/// What became of a replay.
#[derive(Debug, Default)]
pub struct Progress {
    /// Frames that were sent as recorded.
    pub matched: usize,
    /// The first that was not.
    pub different: Option<String>,
}

/// Plays a recording: a frame must be, by the bit, the next of its kind (first datagram's command,
/// index and address) that was recorded, and gets the answer of then.
pub struct Replay {
    recorded: Vec<Option<(Vec<u8>, Vec<u8>)>>,
    returned: VecDeque<Vec<u8>>,
    pub progress: Arc<Mutex<Progress>>,
}

impl Replay {
    pub fn new(recorded: Vec<(Vec<u8>, Vec<u8>)>) -> Self {
        let recorded = recorded.into_iter().map(Some).collect();
        Replay { recorded, returned: VecDeque::new(), progress: Arc::default() }
    }
}

/// Without the padding behind the datagrams.
fn trimmed(frame: &[u8]) -> &[u8] {
    let length = usize::from(u16::from_le_bytes([frame[14], frame[15]])) & 0x7ff;
    &frame[..(16 + length).min(frame.len())]
}

impl Wire for Replay {
    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let mut progress = self.progress.lock().unwrap();
        let alike = |(sent, _): &(Vec<u8>, Vec<u8>)| key(sent) == key(frame);
        let next = self.recorded.iter_mut().find(|one| one.as_ref().is_some_and(alike));
        let Some((sent, back)) = next.and_then(Option::take) else {
            return Err(io::Error::other("the recording has no such frame"));
        };
        if trimmed(&sent) != trimmed(frame) {
            let text = format!("frame {}:\n{frame:02x?}\nnot\n{sent:02x?}", progress.matched);
            progress.different.get_or_insert(text);
        }
        progress.matched += 1;
        self.returned.push_back(back);
        Ok(())
    }

    fn receive(&mut self, frame: &mut [u8], timeout: Duration) -> io::Result<Option<usize>> {
        Ok(deliver(&mut self.returned, frame, timeout))
    }
}
