//! A machine that is called instead of spoken to: a card, an instrument, a segment of SubDevices.
//!
//! To add one, implement [`Device`] in a file of its own. A thread ([`DeviceGateway`]) plays the machine
//! of `docs/gateway.md` around it: it takes the runner's packets from a pair of sockets, calls the device
//! once per command, and answers with its positions. So the cycle sees a peer as over UDP, waits for
//! nobody, allocates nothing and takes no lock, whatever the device does in its thread. The rules of the
//! machine (rest without ENABLE, heartbeat, SAFE) are those of [`Bridge`], which has no clock of its own.

use crate::packet::{self, Header, Kind, Status};
use crate::receive::{Arrival, Receiver};

#[cfg(unix)]
pub use thread::DeviceGateway;

/// What came of one exchange.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Exchanged {
    /// Positions were measured.
    Sample {
        /// The sensors are good.
        valid: bool,
        /// The power stage is on.
        powered: bool,
    },
    /// Nothing came back in time: a sample that is lost.
    Nothing,
    /// The device says what is wrong; the positions are not valid.
    Failed(String),
}

/// A machine that is called.
pub trait Device {
    /// Commands out, positions in. Without `enabled` the runner does not drive, and the commands are
    /// those of the safe state.
    fn exchange(&mut self, enabled: bool, commands: &[f64], positions: &mut [f64]) -> Exchanged;

    /// A sentence on what was opened.
    fn describe(&mut self) -> Option<String> {
        None
    }

    /// Nothing is exchanged after this; the exchange before it was one without `enabled`.
    fn close(&mut self) {}
}

/// The machine's side of the packets, around a device.
pub struct Bridge {
    device: Box<dyn Device>,
    receiver: Receiver,
    /// Commands without ENABLE: those of the plan, then the newest that came.
    safe: Vec<f64>,
    heartbeat_ns: u64,
    heard: bool,
    stopped: bool,
    powered: bool,
    last_command_ns: u64,
    sequence: u32,
    positions: Vec<f64>,
    failure: Option<String>,
    buffer: [u8; packet::MAX_BYTES],
}

impl Bridge {
    /// A machine at rest. `safe`: its commands before the first; after `heartbeat_ns` without a command
    /// it goes back to safe ones.
    #[must_use]
    pub fn new(device: Box<dyn Device>, safe: &[f64], heartbeat_ns: u64, now_ns: u64) -> Self {
        Bridge {
            device,
            // It plays what it is told, however old: only the runner judges age.
            receiver: Receiver::new(Kind::Command, safe.len(), u32::MAX),
            safe: safe.to_vec(),
            heartbeat_ns,
            heard: false,
            stopped: false,
            powered: true,
            last_command_ns: now_ns,
            sequence: 0,
            positions: vec![0.0; safe.len()],
            failure: None,
            buffer: [0; packet::MAX_BYTES],
        }
    }

    /// Takes a packet of the runner.
    pub fn take(&mut self, packet: &[u8], now_ns: u64) {
        let arrival = self.receiver.receive(packet, 0);
        if !matches!(arrival, Arrival::Fresh | Arrival::Restarted) {
            return;
        }
        self.heard = true;
        self.last_command_ns = now_ns;
        if !self.is_enabled() {
            self.stopped = false;
            self.safe.copy_from_slice(self.receiver.values());
        }
    }

    /// Exchanges with the device where a command has come, or none for too long; the packet that
    /// answers, if there is one.
    pub fn turn(&mut self, now_ns: u64, clock: impl FnOnce() -> u64) -> Option<&[u8]> {
        let silent = now_ns.saturating_sub(self.last_command_ns) > self.heartbeat_ns;
        self.stopped |= silent && self.is_enabled();
        if !std::mem::take(&mut self.heard) && !silent {
            return None;
        }
        let valid = self.exchange()?;
        Some(self.answer(valid, clock()))
    }

    /// The last exchange: safe commands, and the device is closed.
    pub fn end(&mut self) {
        self.stopped = true;
        self.exchange();
        self.device.close();
    }

    /// What the device said when it first failed.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    fn is_enabled(&self) -> bool {
        self.receiver.header().is_some_and(|header| header.status.has(Status::ENABLE))
    }

    /// Whether the positions are valid; none: there are none.
    fn exchange(&mut self) -> Option<bool> {
        let follows = self.is_enabled() && !self.stopped;
        let commands = if follows { self.receiver.values() } else { &self.safe[..] };
        self.sequence = self.sequence.wrapping_add(1);
        match self.device.exchange(follows, commands, &mut self.positions) {
            Exchanged::Sample { valid, powered } => {
                self.powered = powered;
                Some(valid)
            }
            Exchanged::Nothing => None,
            Exchanged::Failed(text) => {
                self.failure.get_or_insert(text);
                Some(false)
            }
        }
    }

    fn answer(&mut self, valid: bool, now_ns: u64) -> &[u8] {
        let mut status = Status::default();
        for (bit, is_set) in
            [(Status::POWERED, self.powered), (Status::VALID, valid), (Status::SAFE, self.stopped)]
        {
            status = if is_set { status.with(bit) } else { status };
        }
        let newest = self.receiver.header();
        let header = Header {
            kind: Kind::Measurement,
            channels: self.positions.len() as u16,
            sequence: self.sequence,
            status,
            time_ns: now_ns,
            echo_sequence: newest.map_or(0, |header| header.sequence),
            state: 0,
            reason: 0,
            echo_time_ns: newest.map_or(0, |header| header.time_ns),
        };
        let length = packet::encode(&header, &self.positions, &mut self.buffer);
        &self.buffer[..length]
    }
}

impl std::fmt::Debug for Bridge {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bridge").field("stopped", &self.stopped).finish_non_exhaustive()
    }
}

/// The bridge in its thread.
#[cfg(unix)]
mod thread {
    use std::io;
    use std::os::unix::net::UnixDatagram;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Arc, OnceLock, mpsc};
    use std::time::Duration;

    use rustix::event::{PollFd, PollFlags, Timespec, poll};

    use super::{Bridge, Device};
    use crate::clock::{become_realtime, now_ns};
    use crate::gateway::{Gateway, GatewayError};
    use crate::packet::MAX_BYTES;

    /// Longest wait for a device to open.
    const OPENS: Duration = Duration::from_secs(90);
    /// Longest wait for a device to end; one that hangs is left to itself.
    const ENDS: Duration = Duration::from_secs(2);
    /// Longest wait without a look at `stop`.
    const LOOK: Duration = Duration::from_millis(20);

    /// The runner's end of the bridge to a device.
    #[derive(Debug)]
    pub struct DeviceGateway {
        socket: UnixDatagram,
        stop: Arc<AtomicBool>,
        /// Is disconnected when the thread ends.
        ended: mpsc::Receiver<()>,
        failure: Arc<OnceLock<String>>,
        description: Option<String>,
    }

    impl DeviceGateway {
        /// Opens a device in a thread of its own. `address` is what messages call it, `way_out` what to
        /// do where it does not open; `safe` are the commands before the first.
        ///
        /// # Errors
        /// What `make` says; or the system gives no thread or sockets.
        pub fn open(
            address: &str,
            way_out: &str,
            safe: &[f64],
            heartbeat: Duration,
            make: impl FnOnce() -> Result<Box<dyn Device>, String> + Send + 'static,
        ) -> Result<Self, GatewayError> {
            let failed = |what: &str, error: String, way_out: &str| GatewayError::Open {
                address: address.to_owned(),
                what: what.to_owned(),
                error,
                way_out: way_out.to_owned(),
            };
            let trouble = |error: io::Error| {
                let error = numerics::threads::refused(error);
                failed("the bridge", error.to_string(), "try again")
            };
            let (socket, machine) = UnixDatagram::pair().map_err(trouble)?;
            socket.set_nonblocking(true).map_err(trouble)?;
            machine.set_nonblocking(true).map_err(trouble)?;
            let stop = Arc::new(AtomicBool::new(false));
            let failure = Arc::new(OnceLock::new());
            let (flag, first, safe) = (Arc::clone(&stop), Arc::clone(&failure), safe.to_vec());
            let (sender, receiver) = mpsc::channel();
            let (alive, ended) = mpsc::channel();
            let work = move || {
                let _alive: mpsc::Sender<()> = alive;
                match make() {
                    Ok(mut device) => {
                        let _ = sender.send(Ok(device.describe()));
                        let _ = become_realtime();
                        let ns = heartbeat.as_nanos() as u64;
                        let bridge = Bridge::new(device, &safe, ns, now_ns());
                        serve(bridge, &machine, heartbeat, &flag, &first);
                    }
                    Err(error) => {
                        let _ = sender.send(Err(error));
                    }
                }
            };
            std::thread::Builder::new().name("device".to_owned()).spawn(work).map_err(trouble)?;
            let answer = receiver.recv_timeout(OPENS).unwrap_or_else(|error| {
                Err(match error {
                    mpsc::RecvTimeoutError::Timeout => "it does not answer".to_owned(),
                    mpsc::RecvTimeoutError::Disconnected => "its thread ended".to_owned(),
                })
            });
            let description = answer.map_err(|error| failed("the device", error, way_out))?;
            Ok(DeviceGateway { socket, stop, ended, failure, description })
        }
    }

    fn serve(
        mut bridge: Bridge,
        socket: &UnixDatagram,
        heartbeat: Duration,
        stop: &AtomicBool,
        failure: &OnceLock<String>,
    ) {
        let mut buffer = [0; MAX_BYTES];
        while !stop.load(Ordering::Relaxed) {
            readable(socket, heartbeat.min(LOOK));
            while let Ok(length) = socket.recv(&mut buffer) {
                bridge.take(&buffer[..length], now_ns());
            }
            if let Some(packet) = bridge.turn(now_ns(), now_ns) {
                // A runner that does not look is told by its own deadlines.
                let _ = socket.send(packet);
            }
            if let (Some(text), None) = (bridge.failure(), failure.get()) {
                let _ = failure.set(text.to_owned());
            }
        }
        bridge.end();
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

    impl Drop for DeviceGateway {
        fn drop(&mut self) {
            self.stop.store(true, Ordering::Relaxed);
            let _ = self.ended.recv_timeout(ENDS);
        }
    }

    impl Gateway for DeviceGateway {
        fn send(&mut self, packet: &[u8]) -> bool {
            self.socket.send(packet).is_ok()
        }

        fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
            self.socket.recv(buffer).ok()
        }

        fn wait(&mut self, timeout: Duration) {
            readable(&self.socket, timeout);
        }

        fn describe(&self) -> Option<String> {
            self.description.clone()
        }

        fn failure(&self) -> Option<String> {
            self.failure.get().cloned()
        }
    }
}
