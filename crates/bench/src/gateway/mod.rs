//! The gateway: how packets come and go.
//!
//! | address | transport |
//! |---|---|
//! | `udp://10.0.0.2:9000` | UDP datagrams to and from that one peer |
//! | `shm://stage` | shared memory of this host, over iceoryx2 (feature `shared-memory`) |
//! | `ethercat://eth1` | SubDevices at that interface, over ethercrab (feature `ethercat`) |

mod address;
#[cfg(all(feature = "ethercat", target_os = "linux"))]
pub mod ethercat;
mod keyed;
mod memory;
mod process_data;
#[cfg(feature = "shared-memory")]
mod shared_memory;
mod udp;

use std::time::Duration;

use thiserror::Error;

pub use address::Address;
pub use keyed::{KEYED_VERSION, Key, KeyError, KeyedGateway, Refused};
pub use memory::{MemoryGateway, pair};
pub use process_data::{Bit, ChannelData, DeviceData, Entry, NumberType, ProcessData};
#[cfg(feature = "shared-memory")]
pub use shared_memory::SharedMemoryGateway;
pub use udp::UdpGateway;

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
}

/// Which end of a gateway is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// That of the runner.
    Runner,
    /// That of the machine.
    Machine,
}

/// A gateway that cannot be opened.
#[derive(Debug, Error)]
pub enum GatewayError {
    /// The text is no address.
    #[error(
        "gateway `{text}`: {rule}; write udp://IP:PORT as in udp://127.0.0.1:9000, shm://NAME, or ethercat://INTERFACE"
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

/// Opens one end of a gateway. `other`: for UDP, the own address at the runner's end (default: the
/// loopback address with the port after the gateway's), the runner's address at the machine's end.
/// `data`: for EtherCAT, where the channels stand.
///
/// # Errors
/// The address is taken, not one of this machine, or of a transport that this build has not.
pub fn open(
    address: &Address,
    end: End,
    other: Option<std::net::SocketAddr>,
    data: Option<&ProcessData>,
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
        Address::Ethercat(_) if end == End::Machine => failed(
            "the machine's end",
            "SubDevices are machines themselves",
            "play a machine over udp://IP:PORT or shm://NAME",
        ),
        Address::Ethercat(interface) => match data {
            None => failed(
                "the process data",
                "the plan has no section [ethercat]",
                "say there where commands and positions stand (docs/gateway.md)",
            ),
            Some(data) => open_ethercat(interface, data),
        },
    }
}

#[cfg(all(feature = "ethercat", target_os = "linux"))]
fn open_ethercat(interface: &str, data: &ProcessData) -> Result<Box<dyn Gateway>, GatewayError> {
    Ok(Box::new(ethercat::EthercatGateway::open(interface, data)?))
}

#[cfg(not(all(feature = "ethercat", target_os = "linux")))]
fn open_ethercat(interface: &str, _: &ProcessData) -> Result<Box<dyn Gateway>, GatewayError> {
    Err(GatewayError::Open {
        address: format!("ethercat://{interface}"),
        what: "EtherCAT".to_owned(),
        error: "this build has none".to_owned(),
        way_out: "build it on Linux with `cargo install --path . --features ethercat`".to_owned(),
    })
}
