//! An emulated instrument on a TCP port or a pseudo terminal.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::clock::now_ns;
use crate::gateway::line::is_none_yet;
#[cfg(unix)]
use crate::gateway::serial;
use crate::gateway::{GatewayError, Place};
use crate::plant::PlantError;

/// An instrument as its client sees it.
pub trait Instrument: std::fmt::Debug {
    /// Takes bytes of the client; the return value is what is answered.
    fn receive(&mut self, bytes: &[u8]) -> Vec<u8>;

    /// One step of servo and plant.
    ///
    /// # Errors
    /// The plant failed.
    fn step(&mut self) -> Result<(), PlantError>;

    /// Power off and on.
    fn reboot(&mut self);

    /// The client is gone: half a line is none.
    fn hang_up(&mut self);

    /// Commands and questions so far.
    fn commands(&self) -> u64;

    /// Targets and servo states, axis by axis.
    fn targets(&self) -> Vec<(f64, bool)>;
}

/// How long nothing may come before the clock is looked at.
const LOOK: Duration = Duration::from_micros(200);

/// What was served.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct InstrumentServed {
    /// Steps of the plant.
    pub steps: u64,
    /// Clients that connected.
    pub connections: u64,
    /// Commands and questions.
    pub commands: u64,
}

/// Where an instrument is played.
#[derive(Debug)]
enum Port {
    Net {
        listener: TcpListener,
        client: Option<TcpStream>,
    },
    #[cfg(unix)]
    Serial(serial::Terminal),
}

impl Port {
    fn open(place: &Place) -> Result<Self, GatewayError> {
        let failed = |error: String| GatewayError::Open {
            address: place.to_string(),
            what: "the port".to_owned(),
            error,
            way_out: "choose another with --gateway".to_owned(),
        };
        match place {
            Place::Net(address) => {
                let listener = TcpListener::bind(address).map_err(|e| failed(e.to_string()))?;
                listener.set_nonblocking(true).map_err(|e| failed(e.to_string()))?;
                Ok(Port::Net { listener, client: None })
            }
            #[cfg(unix)]
            Place::Serial(name) => Ok(Port::Serial(serial::Terminal::open(name).map_err(failed)?)),
            #[cfg(not(unix))]
            Place::Serial(_) => Err(failed("this build has no serial lines".to_owned())),
        }
    }

    /// Whether a new client has come.
    fn accepts(&mut self) -> bool {
        let Port::Net { listener, client } = self else { return false };
        let Ok((stream, _)) = listener.accept() else { return false };
        let is_set = stream.set_read_timeout(Some(LOOK)).and_then(|()| stream.set_nodelay(true));
        let is_good = is_set.and_then(|()| stream.set_nonblocking(false)).is_ok();
        if is_good {
            *client = Some(stream);
        }
        is_good
    }

    /// What has come; waits a little for it.
    fn read(&mut self, buffer: &mut [u8]) -> usize {
        match self {
            Port::Net { client, .. } => {
                let Some(stream) = client else {
                    std::thread::sleep(LOOK);
                    return 0;
                };
                match stream.read(buffer) {
                    Ok(length) if length > 0 => return length,
                    Err(error) if is_none_yet(&error) => {}
                    _ => *client = None,
                }
                0
            }
            #[cfg(unix)]
            Port::Serial(terminal) => terminal.read(buffer, LOOK),
        }
    }

    fn write(&mut self, answer: &[u8]) {
        match self {
            Port::Net { client, .. } => {
                if client.as_mut().is_some_and(|stream| stream.write_all(answer).is_err()) {
                    *client = None;
                }
            }
            #[cfg(unix)]
            Port::Serial(terminal) => terminal.write(answer),
        }
    }
}

/// Plays an instrument on a port of this computer, or on a pseudo terminal, until it shall end: one client at a time,
/// as the newest connection takes the place of the one before. `ready` is called once it listens.
///
/// # Errors
/// The port is taken; or the plant FMU failed.
pub fn serve(
    instrument: &mut dyn Instrument,
    place: &Place,
    period_ns: u64,
    duration_ns: Option<u64>,
    stop: &AtomicBool,
    ready: impl FnOnce(),
) -> Result<Result<InstrumentServed, PlantError>, GatewayError> {
    let mut port = Port::open(place)?;
    ready();
    let begin = now_ns();
    let mut served = InstrumentServed::default();
    let mut buffer = [0; 4096];
    while !stop.load(Ordering::Relaxed) {
        let passed = now_ns().saturating_sub(begin);
        if duration_ns.is_some_and(|duration| passed >= duration) {
            break;
        }
        while served.steps < passed / period_ns {
            served.steps += 1;
            if let Err(error) = instrument.step() {
                return Ok(Err(error));
            }
        }
        if port.accepts() {
            served.connections += 1;
            instrument.hang_up();
        }
        let length = port.read(&mut buffer);
        if length > 0 {
            let answer = instrument.receive(&buffer[..length]);
            port.write(&answer);
        }
    }
    served.commands = instrument.commands();
    Ok(Ok(served))
}
