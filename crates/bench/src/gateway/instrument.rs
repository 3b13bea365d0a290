//! Instruments that are spoken to by lines of text, over TCP or a serial port.

use super::protocol::Protocol;
use super::{Address, Gateway, GatewayError, PROTOCOLS, Place, Site, line, station};

/// Addresses of all instruments, for messages.
pub(super) fn examples() -> String {
    let each = PROTOCOLS.iter().map(|protocol| format!("{}://IP", protocol.scheme));
    format!("{} (or as in gcs:///dev/ttyUSB0)", each.collect::<Vec<_>>().join(", "))
}

/// Opens the runner's end of an instrument.
pub(super) fn open(
    address: &Address,
    protocol: &'static Protocol,
    at: &Place,
    options: &str,
    site: &Site<'_>,
) -> Result<Box<dyn Gateway>, GatewayError> {
    let options =
        line::Options::parse(options, site.period).map_err(|error| GatewayError::Open {
            address: address.to_string(),
            what: "its options".to_owned(),
            error,
            way_out: format!("give them as in {}", protocol.example),
        })?;
    let safe = site.safe.clone();
    let at = at.clone();
    super::open_device(address, WAY_OUT, site, move || {
        (protocol.device)(line_to(&at, options.baud, protocol.end), options, &safe)
    })
}

/// What to do where an instrument does not open.
const WAY_OUT: &str = "check power, cable, address and that no other program is connected";

/// The line to an instrument; `end` ends a command there.
#[cfg(unix)]
fn line_to(at: &Place, baud: u32, end: &'static [u8]) -> Box<dyn line::Line> {
    match at {
        Place::Net(at) => Box::new(line::TcpLine::new(*at)),
        Place::Serial(device) => Box::new(super::serial::SerialLine::new(device, baud, end)),
    }
}

#[cfg(not(unix))]
fn line_to(at: &Place, _: u32, _: &'static [u8]) -> Box<dyn line::Line> {
    match at {
        Place::Net(at) => Box::new(line::TcpLine::new(*at)),
        Place::Serial(_) => Box::new(line::NoLine),
    }
}

/// Opens an instrument to work with its own wave generator and data recorder.
///
/// # Errors
/// It does not answer, has not such an axis, or the address is none of an instrument.
pub fn open_station(address: &Address) -> Result<Box<dyn station::Station>, GatewayError> {
    let failed = |what: &str, error: String, way_out: &str| GatewayError::Open {
        address: address.to_string(),
        what: what.to_owned(),
        error,
        way_out: way_out.to_owned(),
    };
    let none = || {
        let error = "it has no wave generator and no data recorder".to_owned();
        let with = PROTOCOLS.iter().filter(|protocol| protocol.station.is_some());
        let with: Vec<String> = with.map(|known| format!("{}://IP", known.scheme)).collect();
        failed("the instrument", error, &format!("give {}", with.join(" or ")))
    };
    let Address::Instrument { protocol, at, options } = address else { return Err(none()) };
    let open = protocol.station.ok_or_else(none)?;
    let options = line::Options::parse(options, station::PERIOD).map_err(|error| {
        failed("its options", error, &format!("give them as in {}", protocol.example))
    })?;
    let line = line_to(at, options.baud, protocol.end);
    open(line, options).map_err(|error| failed("the instrument", error, WAY_OUT))
}
