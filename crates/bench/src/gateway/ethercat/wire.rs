//! What carries Ethernet frames.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::{AsRawFd, OwnedFd};
use std::time::Duration;

use nix::ifaddrs::getifaddrs;
use nix::sys::socket::{AddressFamily, LinkAddr, SockFlag, SockProtocol, SockType, bind, socket};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::super::GatewayError;

/// Longest Ethernet frame without its checksum, with a VLAN tag.
pub(super) const MAX_FRAME: usize = 1518;

/// Carries Ethernet frames to a segment and back.
pub trait Wire: Send {
    /// Sends a frame.
    ///
    /// # Errors
    /// It did not leave.
    fn send(&mut self, frame: &[u8]) -> io::Result<()>;

    /// Takes the next frame that arrives within this time; the return value is its length.
    ///
    /// # Errors
    /// What the operating system says.
    fn receive(&mut self, frame: &mut [u8], timeout: Duration) -> io::Result<Option<usize>>;
}

/// A network interface of this computer.
#[derive(Debug)]
pub struct RawSocket {
    socket: File,
}

impl RawSocket {
    /// Opens an interface as in `eth1`.
    ///
    /// # Errors
    /// There is no such interface, or raw sockets are not permitted.
    pub fn open(interface: &str) -> Result<Self, GatewayError> {
        let failed =
            |what: &str, error: &dyn std::fmt::Display, way_out: String| GatewayError::Open {
                address: format!("ethercat://{interface}"),
                what: what.to_owned(),
                error: error.to_string(),
                way_out,
            };
        let mut links: Vec<(String, LinkAddr)> = getifaddrs()
            .map_err(|e| failed("the interfaces", &e, "check the network".to_owned()))?
            .filter_map(|one| Some((one.interface_name, *one.address?.as_link_addr()?)))
            .collect();
        links.sort_by(|one, other| one.0.cmp(&other.0));
        let Some((_, link)) = links.iter().find(|(name, _)| name == interface) else {
            let names: Vec<&str> = links.iter().map(|(name, _)| name.as_str()).collect();
            let way_out = format!("choose one of {}", names.join(", "));
            return Err(failed("opening it", &"there is no such interface", way_out));
        };
        let not_permitted = |error: nix::Error| {
            let way_out = "raw sockets need CAP_NET_RAW: setcap cap_net_raw,cap_sys_nice,cap_ipc_lock=ep on the program, or run it as root";
            failed("opening a raw socket", &error, way_out.to_owned())
        };
        let (family, kind) = (AddressFamily::Packet, SockType::Raw);
        let flags = SockFlag::SOCK_NONBLOCK | SockFlag::SOCK_CLOEXEC;
        let socket: OwnedFd =
            socket(family, kind, flags, SockProtocol::EthAll).map_err(not_permitted)?;
        bind(socket.as_raw_fd(), link).map_err(not_permitted)?;
        Ok(RawSocket { socket: File::from(socket) })
    }
}

impl Wire for RawSocket {
    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        self.socket.write_all(frame)
    }

    fn receive(&mut self, frame: &mut [u8], timeout: Duration) -> io::Result<Option<usize>> {
        let mut sockets = [PollFd::new(&self.socket, PollFlags::IN)];
        let timeout = Timespec {
            tv_sec: timeout.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: timeout.subsec_nanos().into(),
        };
        // A wait that a signal ends early is as good.
        let _ = poll(&mut sockets, Some(&timeout));
        match self.socket.read(frame) {
            Ok(length) => Ok(Some(length)),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(error),
        }
    }
}
