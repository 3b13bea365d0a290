//! An emulated instrument on a TCP port.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::clock::now_ns;
use crate::emulate::{Instrument, PlantError};
use crate::gateway::GatewayError;

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

/// Plays an instrument on a port of this computer until it shall end: one client at a time, as the
/// newest connection takes the place of the one before. `ready` is called once it listens.
///
/// # Errors
/// The port is taken; or the plant FMU failed.
pub fn serve(
    instrument: &mut dyn Instrument,
    address: SocketAddr,
    period_ns: u64,
    duration_ns: Option<u64>,
    stop: &AtomicBool,
    ready: impl FnOnce(),
) -> Result<Result<InstrumentServed, PlantError>, GatewayError> {
    let failed = |error: std::io::Error| GatewayError::Open {
        address: format!("{address}"),
        what: "the port".to_owned(),
        error: error.to_string(),
        way_out: "choose another with --gateway".to_owned(),
    };
    let listener = TcpListener::bind(address).map_err(failed)?;
    listener.set_nonblocking(true).map_err(failed)?;
    ready();
    let begin = now_ns();
    let mut served = InstrumentServed::default();
    let mut client: Option<TcpStream> = None;
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
        if let Ok((stream, _)) = listener.accept() {
            let is_set =
                stream.set_read_timeout(Some(LOOK)).and_then(|()| stream.set_nodelay(true));
            if is_set.and_then(|()| stream.set_nonblocking(false)).is_ok() {
                served.connections += 1;
                instrument.hang_up();
                client = Some(stream);
            }
        }
        let Some(stream) = &mut client else {
            std::thread::sleep(LOOK);
            continue;
        };
        let is_gone = match stream.read(&mut buffer) {
            Ok(0) => true,
            Ok(length) => {
                let answer = instrument.receive(&buffer[..length]);
                stream.write_all(&answer).is_err()
            }
            Err(error) => !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
        };
        if is_gone {
            client = None;
        }
    }
    served.commands = instrument.commands();
    Ok(Ok(served))
}
