//! The gateway: how packets come and go.
//!
//! | address | transport |
//! |---|---|
//! | `udp://10.0.0.2:9000` | UDP datagrams to and from that one peer |
//! | `shm://stage` | shared memory of this host, over iceoryx2 (feature `shared-memory`) |
//! | `ethercat://eth1` | SubDevices at that interface, over ethercrab (feature `ethercat`) |
//! | `gcs://10.0.0.5:50000?axes=1,2` | an instrument of PI, General Command Set 2.0 over TCP |
//! | `gcs:///dev/ttyUSB0?baud=115200` | the same over a serial line |
//! | `nv200://10.0.0.6`, `nv200:///dev/ttyUSB0` | a piezosystem jena NV200, over its telnet port or a serial line |
//! | `plugin://./libcard.so?options` | a driver in C with the functions of `gateway.h` |

mod address;
pub mod csp;
pub mod device;
#[cfg(all(feature = "ethercat", target_os = "linux"))]
pub mod ethercat;
pub mod gcs;
mod instrument;
mod keyed;
pub mod line;
mod memory;
pub mod nv200;
mod plugin;
mod process_data;
mod protocol;
#[cfg(unix)]
pub mod serial;
mod serve;
#[cfg(feature = "shared-memory")]
mod shared_memory;
pub mod station;
mod udp;

use std::time::Duration;

use thiserror::Error;

pub use address::{Address, Place};
pub use instrument::open_station;
pub use keyed::{KEYED_VERSION, Key, KeyError, KeyedGateway, Refused};
pub use memory::{MemoryGateway, pair};
pub use plugin::PluginDevice;
pub use process_data::{Bit, ChannelData, DeviceData, Entry, NumberType, ProcessData};
pub use protocol::{OpenStation, OpenedDevice, Protocol};
pub use serve::{Instrument, InstrumentServed, serve};
#[cfg(feature = "shared-memory")]
pub use shared_memory::SharedMemoryGateway;
pub use udp::UdpGateway;

/// The instruments that are spoken to by lines of text; each declares itself in its own file.
pub static PROTOCOLS: &[&Protocol] = &[&gcs::PROTOCOL, &nv200::PROTOCOL];

/// Carries packets between runner and machine. Calls never block but [`wait`](Self::wait); a gateway
/// for real time allocates nothing and takes no lock once it is open.
pub trait Gateway {
    /// Sends a packet; false when it did not leave.
    fn send(&mut self, packet: &[u8]) -> bool;

    /// Takes the next packet that has arrived; the return value is its length.
    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize>;

    /// Returns when a packet has arrived, or after this time.
    fn wait(&mut self, timeout: Duration);

    /// What was refused for its tag; none: there is no key.
    fn refused(&self) -> Option<Refused> {
        None
    }

    /// A sentence on the machine, where it has one.
    fn describe(&self) -> Option<String> {
        None
    }

    /// What the machine's driver said when it first failed.
    fn failure(&self) -> Option<String> {
        None
    }
}

/// Which end of a gateway is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The end of the runner.
    Runner,
    /// The end of the machine.
    Machine,
}

/// A gateway that cannot be opened.
#[derive(Debug, Error)]
pub enum GatewayError {
    /// The text is no address.
    #[error(
        "gateway `{text}`: {rule}; write udp://IP:PORT as in udp://127.0.0.1:9000, shm://NAME, ethercat://INTERFACE, {instruments}, or plugin://FILE", instruments = instrument::examples()
    )]
    Address {
        /// As it was given.
        text: String,
        /// What is wrong.
        rule: String,
    },
    /// The operating system does not open it.
    #[error("gateway {address}: {what}: {error}; {way_out}")]
    Open {
        /// The gateway.
        address: String,
        /// What failed.
        what: String,
        /// What the system says.
        error: String,
        /// What to do.
        way_out: String,
    },
}

/// `gateway.h`: what a library behind `plugin://FILE` must have.
pub const C_HEADER: &str = ::plugin::HEADER;

/// What a gateway may need to know of the run.
#[derive(Clone, Debug, Default)]
pub struct Site<'a> {
    /// Commands of the safe state, one for each channel.
    pub safe: Vec<f64>,
    /// Length of a cycle in s.
    pub period: f64,
    /// Where the channels stand, for EtherCAT.
    pub ethercat: Option<&'a ProcessData>,
}

/// Seconds without a command after which a device that is called goes to its safe commands, and at
/// least so many cycles.
#[cfg(unix)]
const HEARTBEAT: f64 = 0.1;
#[cfg(unix)]
const HEARTBEAT_CYCLES: f64 = 5.0;

/// Opens one end of a gateway. `other`: for UDP, the own address at the runner's end (default: the
/// loopback address with the port after the gateway's), the runner's address at the machine's end.
///
/// # Errors
/// The address is taken, not one of this machine, or of a transport that this build has not.
pub fn open(
    address: &Address,
    end: End,
    other: Option<std::net::SocketAddr>,
    site: &Site<'_>,
) -> Result<Box<dyn Gateway>, GatewayError> {
    let failed = |what: &str, error: &str, way_out: &str| {
        Err(GatewayError::Open {
            address: address.to_string(),
            what: what.to_owned(),
            error: error.to_owned(),
            way_out: way_out.to_owned(),
        })
    };
    match address {
        Address::Udp(machine) => Ok(Box::new(UdpGateway::open(*machine, end, other)?)),
        #[cfg(feature = "shared-memory")]
        Address::SharedMemory(name) => Ok(Box::new(SharedMemoryGateway::open(name, end)?)),
        #[cfg(not(feature = "shared-memory"))]
        Address::SharedMemory(_) => {
            failed("shared memory", "this build has none", "build with the feature `shared-memory`")
        }
        Address::Ethercat(_) | Address::Plugin { .. } | Address::Instrument { .. }
            if end == End::Machine =>
        {
            failed(
                "the machine's end",
                "what is there is a machine itself",
                "play a machine over udp://IP:PORT or shm://NAME, an instrument with --protocol gcs",
            )
        }
        Address::Plugin { library, options } => {
            let (library, options) = (library.clone(), options.clone());
            let (channels, period) = (site.safe.len(), site.period);
            let way_out =
                "`piezoloop bench header` prints gateway.h, examples/05_bench/card.c is one";
            open_device(address, way_out, site, move || {
                Ok(Box::new(plugin::PluginDevice::open(&library, &options, channels, period)?))
            })
        }
        Address::Instrument { protocol, at, options } => {
            instrument::open(address, protocol, at, options, site)
        }
        Address::Ethercat(interface) => match site.ethercat {
            None => failed(
                "the process data",
                "the plan has no section [ethercat]",
                "state there the place of commands and positions (docs/gateway.md)",
            ),
            Some(data) => open_ethercat(interface, data, &site.safe),
        },
    }
}

#[cfg(all(feature = "ethercat", target_os = "linux"))]
fn open_ethercat(
    interface: &str,
    data: &ProcessData,
    safe: &[f64],
) -> Result<Box<dyn Gateway>, GatewayError> {
    Ok(Box::new(ethercat::EthercatGateway::open(interface, data, safe)?))
}

#[cfg(not(all(feature = "ethercat", target_os = "linux")))]
fn open_ethercat(
    interface: &str,
    _: &ProcessData,
    _: &[f64],
) -> Result<Box<dyn Gateway>, GatewayError> {
    Err(GatewayError::Open {
        address: format!("ethercat://{interface}"),
        what: "EtherCAT".to_owned(),
        error: "this build has none".to_owned(),
        way_out: "build it on Linux with `cargo install --path . --features ethercat`".to_owned(),
    })
}

#[cfg(unix)]
fn open_device(
    address: &Address,
    way_out: &str,
    site: &Site<'_>,
    make: impl FnOnce() -> Result<Box<dyn device::Device>, String> + Send + 'static,
) -> Result<Box<dyn Gateway>, GatewayError> {
    let heartbeat = Duration::from_secs_f64(HEARTBEAT.max(HEARTBEAT_CYCLES * site.period));
    let address = address.to_string();
    let gateway = device::DeviceGateway::open(&address, way_out, &site.safe, heartbeat, make)?;
    Ok(Box::new(gateway))
}

#[cfg(not(unix))]
fn open_device(
    address: &Address,
    _: &str,
    _: &Site<'_>,
    _: impl FnOnce() -> Result<Box<dyn device::Device>, String>,
) -> Result<Box<dyn Gateway>, GatewayError> {
    Err(GatewayError::Open {
        address: address.to_string(),
        what: "the bridge".to_owned(),
        error: "this build has none".to_owned(),
        way_out: "run the bench on Linux or macOS".to_owned(),
    })
}
