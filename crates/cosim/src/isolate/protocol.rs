//! What master and worker say to each other: frames of a length (32 bits, little endian) and as
//! many bytes.

use std::io::{self, Read, Write};

use fmi_bindings::fmi2::fmi2Status;
use fmi_bindings::import::{Message, Status, StepResult};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::slave::Value;

/// Longest frame; a longer one is none.
const MOST_BYTES: u32 = 1 << 30;

/// What the master asks for. `Set` is not answered; its error comes with the next answer.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Request {
    Open {
        folder: String,
        name: String,
        visible: bool,
        logging_on: bool,
        /// Values of structural parameters.
        structure: Vec<(String, Value)>,
        /// Most memory for data in bytes.
        memory: Option<u64>,
    },
    Setup {
        start: f64,
        stop: Option<f64>,
        tolerance: Option<f64>,
    },
    EnterInitialization,
    ExitInitialization,
    SetStart(String, Value),
    Value(String),
    /// Names a selection; its number is how many there were before.
    Select(Vec<String>),
    Set(u32, Vec<f64>),
    Get(u32),
    Step(f64, f64),
    Terminate,
    Reset,
    Save(Option<usize>),
    Restore(usize),
    Forget(usize),
    Serialize(usize),
    Deserialize(Vec<u8>),
}

/// What the worker answers; messages of the FMU come before the answer.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Answer {
    Message { status: u32, category: String, text: String },
    Done,
    Value(Value),
    Values(Vec<f64>),
    Discarded { reached: Option<f64>, terminated: bool },
    State(usize),
    Bytes(Vec<u8>),
    Failed(String),
}

impl Answer {
    pub(super) fn message(message: &Message) -> Self {
        let status = match message.status {
            Status::Ok => 0,
            Status::Warning => 1,
            Status::Discard => 2,
            Status::Error => 3,
            Status::Fatal => 4,
            Status::Pending => 5,
            Status::Unknown(number) => number,
        };
        let (category, text) = (message.category.clone(), message.text.clone());
        Answer::Message { status, category, text }
    }

    pub(super) fn step(result: StepResult) -> Self {
        match result {
            StepResult::Completed => Answer::Done,
            StepResult::Discarded { reached, terminated } => {
                Answer::Discarded { reached, terminated }
            }
        }
    }
}

/// A message as it was before it was sent.
pub(super) fn received(status: u32, category: String, text: String) -> Message {
    Message { status: Status::from(fmi2Status(status)), category, text }
}

pub(super) fn send(to: &mut impl Write, what: &impl Serialize) -> io::Result<()> {
    let mut frame = vec![0; 4];
    frame = postcard::to_extend(what, frame).map_err(io::Error::other)?;
    let length = u32::try_from(frame.len() - 4).ok().filter(|length| *length <= MOST_BYTES);
    let length = length.ok_or_else(|| io::Error::other("too much for one frame"))?;
    if let Some(head) = frame.first_chunk_mut::<4>() {
        *head = length.to_le_bytes();
    }
    to.write_all(&frame)
}

pub(super) fn receive<T: DeserializeOwned>(from: &mut impl Read) -> io::Result<T> {
    let mut head = [0; 4];
    from.read_exact(&mut head)?;
    let length = u32::from_le_bytes(head);
    if length > MOST_BYTES {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "a frame that is too long"));
    }
    let mut frame = Vec::new();
    from.take(length.into()).read_to_end(&mut frame)?;
    postcard::from_bytes(&frame).map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_carry_every_bit() {
        let values = vec![f64::NAN, -0.0, f64::INFINITY, 1e-310];
        let mut bytes = Vec::new();
        send(&mut bytes, &Request::Set(7, values.clone())).unwrap();
        match receive::<Request>(&mut bytes.as_slice()).unwrap() {
            Request::Set(7, found) => {
                let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&found), bits(&values));
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn broken_frames_are_errors() {
        let mut bytes = Vec::new();
        send(&mut bytes, &Answer::Bytes(vec![1; 100])).unwrap();
        for cut in 0..bytes.len() {
            assert!(receive::<Answer>(&mut &bytes[..cut]).is_err(), "{cut}");
        }
        assert!(receive::<Answer>(&mut [255_u8; 8].as_slice()).is_err());
        assert!(receive::<Answer>(&mut [1_u8, 0, 0, 0, 99].as_slice()).is_err());
    }
}
