//! EtherCAT: a segment of SubDevices as the machine, over [ethercrab](https://docs.rs/ethercrab).
//!
//! A thread of its own plays the machine of `docs/gateway.md`: it takes the runner's packets from a
//! pair of sockets, writes the commands into the process data, exchanges one frame with the segment,
//! and answers with the positions of that frame. So the cycle sees a peer as over UDP, waits for
//! nobody, allocates nothing and takes no lock, whatever ethercrab does in its thread.

mod segment;
mod wire;

use std::io;
use std::os::unix::net::UnixDatagram;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

pub use wire::{RawSocket, Wire};

use self::segment::Segment;
use super::process_data::{DeviceData, ProcessData};
use super::{Gateway, GatewayError};
use crate::clock::{become_realtime, now_ns};
use crate::packet::{self, Header, Kind, Status};
use crate::receive::{Arrival, Receiver};

/// The runner's end of the bridge to a segment.
#[derive(Debug)]
pub struct EthercatGateway {
    socket: UnixDatagram,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    devices: Vec<DeviceData>,
}

impl EthercatGateway {
    /// Brings the segment at an interface into the state OP.
    ///
    /// # Errors
    /// The interface cannot be opened, the SubDevices do not come up, or do not have what the
    /// process data say.
    pub fn open(interface: &str, data: &ProcessData) -> Result<Self, GatewayError> {
        Self::over(Box::new(RawSocket::open(interface)?), interface, data)
    }

    /// The same over any wire; `name` is what messages call it.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn over(wire: Box<dyn Wire>, name: &str, data: &ProcessData) -> Result<Self, GatewayError> {
        let failed = |what: &str, error: String, way_out: &str| GatewayError::Open {
            address: format!("ethercat://{name}"),
            what: what.to_owned(),
            error,
            way_out: way_out.to_owned(),
        };
        let trouble = |error: io::Error| failed("the bridge", error.to_string(), "try again");
        let (socket, machine) = UnixDatagram::pair().map_err(trouble)?;
        socket.set_nonblocking(true).map_err(trouble)?;
        let stop = Arc::new(AtomicBool::new(false));
        let (flag, data) = (Arc::clone(&stop), data.clone());
        let (tell, told) = mpsc::channel();
        let thread = std::thread::Builder::new()
            .name("ethercat".to_owned())
            .spawn(move || match Bridge::open(wire, machine, data) {
                Ok(bridge) => {
                    let _ = tell.send(Ok(bridge.segment.devices().to_vec()));
                    let _ = become_realtime();
                    bridge.serve(&flag);
                }
                Err(error) => {
                    let _ = tell.send(Err(error));
                }
            })
            .map_err(trouble)?;
        let devices = told.recv().unwrap_or_else(|_| Err("its thread ended".to_owned())).map_err(
            |error| {
                let way_out = "check cable, power and [ethercat] in the plan";
                failed("the segment", error, way_out)
            },
        )?;
        Ok(EthercatGateway { socket, stop, thread: Some(thread), devices })
    }

    /// The SubDevices, in the order of the segment.
    #[must_use]
    pub fn devices(&self) -> &[DeviceData] {
        &self.devices
    }
}

impl Drop for EthercatGateway {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Gateway for EthercatGateway {
    fn send(&mut self, packet: &[u8]) -> bool {
        self.socket.send(packet).is_ok()
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.socket.recv(buffer).ok()
    }

    fn wait(&mut self, timeout: Duration) {
        readable(&self.socket, timeout);
    }
}

fn readable(socket: &UnixDatagram, timeout: Duration) {
    let mut sockets = [PollFd::new(socket, PollFlags::IN)];
    let timeout = Timespec {
        tv_sec: timeout.as_secs().try_into().unwrap_or(i64::MAX),
        tv_nsec: timeout.subsec_nanos().into(),
    };
    // A wait that a signal ends early is as good.
    let _ = poll(&mut sockets, Some(&timeout));
}

/// The machine's end: the packet on one side, process data on the other.
struct Bridge {
    segment: Segment,
    socket: UnixDatagram,
    data: ProcessData,
    receiver: Receiver,
    /// Newest commands without ENABLE.
    safe: Vec<f64>,
    stopped: bool,
    last_command_ns: u64,
    sequence: u32,
    positions: Vec<f64>,
    buffer: [u8; packet::MAX_BYTES],
}

impl Bridge {
    fn open(wire: Box<dyn Wire>, socket: UnixDatagram, data: ProcessData) -> Result<Self, String> {
        let trouble = |error: io::Error| error.to_string();
        socket.set_nonblocking(true).map_err(trouble)?;
        let segment = Segment::open(wire)?;
        let missing = data.missing(segment.devices());
        if !missing.is_empty() {
            segment.close();
            return Err(missing.join("; "));
        }
        let channels = data.channels.len();
        Ok(Bridge {
            segment,
            socket,
            receiver: Receiver::new(Kind::Command, channels, u32::MAX),
            safe: vec![0.0; channels],
            stopped: false,
            last_command_ns: now_ns(),
            sequence: 0,
            positions: vec![0.0; channels],
            buffer: [0; packet::MAX_BYTES],
            data,
        })
    }

    fn serve(mut self, stop: &AtomicBool) {
        let heartbeat = self.heartbeat();
        while !stop.load(Ordering::Relaxed) {
            readable(&self.socket, heartbeat.min(Duration::from_millis(20)));
            let heard = self.take();
            let silent = now_ns() - self.last_command_ns > heartbeat.as_nanos() as u64;
            self.stopped |= silent && self.is_enabled();
            if heard || silent {
                self.exchange();
            }
        }
        self.stopped = true;
        self.exchange();
        self.segment.close();
    }

    fn heartbeat(&self) -> Duration {
        Duration::from_secs_f64(self.data.heartbeat.unwrap_or(0.1))
    }

    fn is_enabled(&self) -> bool {
        self.receiver.header().is_some_and(|header| header.status.has(Status::ENABLE))
    }

    /// Takes all commands that have arrived; whether there was one.
    fn take(&mut self) -> bool {
        let mut heard = false;
        while let Ok(length) = self.socket.recv(&mut self.buffer) {
            let arrival = self.receiver.receive(&self.buffer[..length], 0);
            if !matches!(arrival, Arrival::Fresh | Arrival::Restarted) {
                continue;
            }
            heard = true;
            self.last_command_ns = now_ns();
            if !self.is_enabled() {
                self.stopped = false;
                self.safe.copy_from_slice(self.receiver.values());
            }
        }
        heard
    }

    /// One frame out, one in, one packet back.
    fn exchange(&mut self) {
        let follows = self.is_enabled() && !self.stopped;
        let commands = if follows { self.receiver.values() } else { &self.safe[..] };
        for (channel, command) in self.data.channels.iter().zip(commands) {
            let output = &channel.output;
            self.segment.outputs(output.device, |bytes| output.write(*command, bytes));
        }
        if let Some(enable) = &self.data.enable {
            self.segment.outputs(enable.device, |bytes| enable.write(follows, bytes));
        }
        self.sequence = self.sequence.wrapping_add(1);
        // A frame that does not come back is a sample that is lost; the next one must not wait long.
        let limit = self.heartbeat() / 4;
        let Ok(exchanged) = self.segment.exchange(limit) else { return };
        let mut valid = exchanged.complete;
        for (channel, position) in self.data.channels.iter().zip(&mut self.positions) {
            let input = &channel.input;
            let found = self.segment.inputs(input.device, |bytes| input.read(bytes)).flatten();
            valid &= found.is_some();
            *position = found.unwrap_or(*position);
        }
        let powered = self.data.powered.is_none_or(|bit| {
            self.segment.inputs(bit.device, |bytes| bit.read(bytes)).unwrap_or(false)
        });
        self.answer(valid, powered && exchanged.operational);
    }

    fn answer(&mut self, valid: bool, powered: bool) {
        let mut status = Status::default();
        for (bit, is_set) in
            [(Status::POWERED, powered), (Status::VALID, valid), (Status::SAFE, self.stopped)]
        {
            status = if is_set { status.with(bit) } else { status };
        }
        let newest = self.receiver.header();
        let header = Header {
            kind: Kind::Measurement,
            channels: self.positions.len() as u16,
            sequence: self.sequence,
            status,
            time_ns: now_ns(),
            echo_sequence: newest.map_or(0, |header| header.sequence),
            state: 0,
            reason: 0,
            echo_time_ns: newest.map_or(0, |header| header.time_ns),
        };
        let length = packet::encode(&header, &self.positions, &mut self.buffer);
        // A runner that does not look is told by its own deadlines.
        let _ = self.socket.send(&self.buffer[..length]);
    }
}
