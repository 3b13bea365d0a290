//! Addresses of gateways.

use std::fmt;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::str::FromStr;

use super::protocol::Protocol;
use super::{End, GatewayError, PROTOCOLS};

/// Where the machine is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// `udp://IP:PORT`: the machine listens there.
    Udp(SocketAddr),
    /// `shm://NAME`: the machine opened shared memory of this name.
    SharedMemory(String),
    /// `ethercat://INTERFACE`: SubDevices at this network interface.
    Ethercat(String),
    /// `SCHEME://IP:PORT?OPTIONS`, `SCHEME:///dev/ttyUSB0?OPTIONS`: an instrument of [`PROTOCOLS`].
    Instrument {
        /// What it speaks.
        protocol: &'static Protocol,
        /// Where it is.
        at: Place,
        /// See `line::Options`.
        options: String,
    },
    /// `plugin://FILE?OPTIONS`: a driver in C behind the functions of `gateway.h`.
    Plugin {
        /// The shared library.
        library: PathBuf,
        /// What it gets, as it stands.
        options: String,
    },
}

impl Address {
    /// How the addresses of an end are written, one for each transport.
    #[must_use]
    pub fn forms(end: End) -> Vec<String> {
        let mut all = vec!["udp://IP:PORT".to_owned(), "shm://NAME".to_owned()];
        if end == End::Runner {
            all.push("ethercat://INTERFACE".to_owned());
            all.extend(PROTOCOLS.iter().map(|known| format!("{}://IP:PORT", known.scheme)));
            all.push("plugin://FILE?OPTIONS".to_owned());
        }
        all
    }
}

/// Where an instrument is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// It listens there.
    Net(SocketAddr),
    /// At this serial port.
    Serial(PathBuf),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Net(at) => write!(f, "{at}"),
            Place::Serial(device) => write!(f, "{}", device.display()),
        }
    }
}

impl FromStr for Address {
    type Err = GatewayError;

    fn from_str(text: &str) -> Result<Self, GatewayError> {
        let error = |rule: String| GatewayError::Address { text: text.to_owned(), rule };
        if let Some(rest) = text.strip_prefix("udp://") {
            let address: SocketAddr = rest.parse().map_err(|_| {
                error("is no IP address with a port (names are not looked up)".into())
            })?;
            if address.port() == 0 || address.port() == u16::MAX {
                return Err(error("the port must be 1 to 65534".into()));
            }
            return Ok(Address::Udp(address));
        }
        if let Some(name) = text.strip_prefix("shm://") {
            let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            if name.is_empty() || name.len() > 64 || !name.chars().all(good) {
                let rule = "the name must be 1 to 64 letters, digits, - or _";
                return Err(error(rule.into()));
            }
            return Ok(Address::SharedMemory(name.to_owned()));
        }
        if let Some(name) = text.strip_prefix("ethercat://") {
            // Names of interfaces are at most 15 bytes long.
            let good = |c: char| c.is_ascii_graphic() && c != '/';
            if name.is_empty() || name.len() > 15 || !name.chars().all(good) {
                return Err(error("has no name of an interface, as in ethercat://eth1".into()));
            }
            return Ok(Address::Ethercat(name.to_owned()));
        }
        if let Some((scheme, rest)) = text.split_once("://")
            && let Some(&protocol) = PROTOCOLS.iter().find(|known| known.scheme == scheme)
        {
            let (at, options) =
                instrument(rest, protocol.port).ok_or_else(|| error(NO_IP.into()))?;
            return Ok(Address::Instrument { protocol, at, options });
        }
        if let Some(rest) = text.strip_prefix("plugin://") {
            let (library, options) = rest.split_once('?').unwrap_or((rest, ""));
            if library.is_empty() || options.contains('\0') {
                let rule = "has no shared library, as in plugin://./libcard.so?options";
                return Err(error(rule.into()));
            }
            return Ok(Address::Plugin { library: library.into(), options: options.to_owned() });
        }
        Err(error("has no known scheme".into()))
    }
}

const NO_IP: &str = "is no IP address with or without a port (names are not looked up), nor a serial port as in gcs:///dev/ttyUSB0";

/// Address, with this port where none is given, and options of an instrument.
fn instrument(text: &str, port: u16) -> Option<(Place, String)> {
    let (host, options) = text.split_once('?').unwrap_or((text, ""));
    if host.starts_with('/') && !host.contains('\0') {
        return Some((Place::Serial(host.into()), options.to_owned()));
    }
    let only_ip = || host.trim_matches(['[', ']']).parse::<IpAddr>().map(|ip| (ip, port).into());
    let at = host.parse::<SocketAddr>().or_else(|_| only_ip()).ok()?;
    Some((Place::Net(at), options.to_owned()))
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Address::Udp(address) => write!(f, "udp://{address}"),
            Address::SharedMemory(name) => write!(f, "shm://{name}"),
            Address::Ethercat(name) => write!(f, "ethercat://{name}"),
            Address::Instrument { protocol, at, options } => {
                let mark = if options.is_empty() { "" } else { "?" };
                write!(f, "{}://{at}{mark}{options}", protocol.scheme)
            }
            Address::Plugin { library, options } => {
                let mark = if options.is_empty() { "" } else { "?" };
                write!(f, "plugin://{}{mark}{options}", library.display())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_and_written() {
        let forms = Address::forms(End::Runner);
        for form in &forms {
            let text = form.replace("IP:PORT", "10.0.0.2:9000");
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
        }
        for text in [
            "udp://10.0.0.2:9000",
            "udp://[::1]:9000",
            "shm://stage-1",
            "ethercat://eth1",
            "gcs://192.168.0.5:50000",
            "gcs://[::1]:50001?axes=1,2&mode=open",
            "nv200://192.168.0.6:23?mode=open",
            "gcs:///dev/ttyUSB0?baud=9600",
            "nv200:///dev/ttyACM1",
            "plugin://./libcard.so",
            "plugin:///opt/card.so?ao=Dev1/ao0:1 range=10?x",
        ] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
            let scheme = text.split_inclusive("://").next().unwrap();
            assert!(forms.iter().any(|form| form.starts_with(scheme)), "{text}");
        }
        for (text, word) in [
            ("udp://stage:9000", "looked up"),
            ("udp://127.0.0.1", "port"),
            ("udp://127.0.0.1:65535", "65534"),
            ("shm://a b", "letters"),
            ("ethercat://", "interface"),
            ("gcs://stage", "looked up"),
            ("plugin://?x", "library"),
            ("tcp://127.0.0.1:1", "scheme"),
        ] {
            let message = text.parse::<Address>().unwrap_err().to_string();
            assert!(message.contains(word) && message.contains(text), "{message}");
        }
    }
}
