//! UDP: one socket that knows one peer.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::{End, Gateway, GatewayError};

/// A connected socket: the kernel passes on packets of the configured peer only.
#[derive(Debug)]
pub struct UdpGateway {
    socket: UdpSocket,
}

impl UdpGateway {
    /// Opens one end, see [`open`](super::open).
    ///
    /// # Errors
    /// The own address is taken or not one of this machine, or cannot reach the peer.
    pub fn open(
        machine: SocketAddr,
        end: End,
        other: Option<SocketAddr>,
    ) -> Result<Self, GatewayError> {
        let runner = other.unwrap_or_else(|| loopback(machine));
        let (own, peer) = match end {
            End::Runner => (runner, machine),
            End::Machine => (machine, runner),
        };
        let failed = |what: String, error: io::Error, way_out: &str| GatewayError::Open {
            address: format!("udp://{machine}"),
            what,
            error: error.to_string(),
            way_out: way_out.to_owned(),
        };
        if own.ip().is_loopback() != peer.ip().is_loopback() {
            let what = format!("{own} and {peer}");
            let error = io::Error::other("one address is loopback, the other is not");
            let way_out = "give the address of the network card: --bind IP:PORT at the runner, \
                           --peer IP:PORT at the machine";
            return Err(failed(what, error, way_out));
        }
        let socket = UdpSocket::bind(own).map_err(|error| {
            let way_out = "end the program that has the port, or choose another; the address must \
                           be one of this computer";
            failed(format!("binding to {own}"), error, way_out)
        })?;
        let way_out = "check the address of the peer and the route to it";
        socket
            .connect(peer)
            .and_then(|()| socket.set_nonblocking(true))
            .map_err(|error| failed(format!("connecting to {peer}"), error, way_out))?;
        Ok(UdpGateway { socket })
    }

    /// The own address.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }
}

/// The runner's address if none is given: loopback, and the port after the machine's.
fn loopback(machine: SocketAddr) -> SocketAddr {
    let ip = match machine {
        SocketAddr::V4(_) => IpAddr::V4(Ipv4Addr::LOCALHOST),
        SocketAddr::V6(_) => IpAddr::V6(Ipv6Addr::LOCALHOST),
    };
    SocketAddr::new(ip, machine.port().saturating_add(1))
}

impl Gateway for UdpGateway {
    #[inline]
    fn send(&mut self, packet: &[u8]) -> bool {
        // A peer that is not there answers with ICMP, which the next call reports once: try again.
        (0..2).any(|_| self.socket.send(packet).is_ok())
    }

    #[inline]
    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        (0..2).find_map(|_| self.socket.recv(buffer).ok())
    }

    fn wait(&mut self, timeout: Duration) {
        let mut sockets = [PollFd::new(&self.socket, PollFlags::IN)];
        let timeout = Timespec {
            tv_sec: timeout.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: timeout.subsec_nanos().into(),
        };
        // A wait that a signal ends early is as good.
        let _ = poll(&mut sockets, Some(&timeout));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free_port() -> u16 {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.local_addr().unwrap().port().min(u16::MAX - 2)
    }

    fn ends() -> (UdpGateway, UdpGateway, SocketAddr) {
        loop {
            let machine: SocketAddr = format!("127.0.0.1:{}", free_port()).parse().unwrap();
            let runner = UdpGateway::open(machine, End::Runner, None);
            if let (Ok(runner), Ok(emulator)) =
                (runner, UdpGateway::open(machine, End::Machine, None))
            {
                return (runner, emulator, machine);
            }
        }
    }

    #[test]
    fn packets_go_both_ways() {
        let (mut runner, mut machine, _) = ends();
        let mut buffer = [0; 64];
        assert_eq!(runner.receive(&mut buffer), None);
        assert!(runner.send(b"command"));
        machine.wait(Duration::from_secs(5));
        assert_eq!(machine.receive(&mut buffer), Some(7));
        assert!(machine.send(b"sample"));
        runner.wait(Duration::from_secs(5));
        assert_eq!(
            runner.receive(&mut buffer).map(|n| buffer[..n].to_vec()),
            Some(b"sample".into())
        );
    }

    #[test]
    fn nobody_but_the_peer_is_listened_to() {
        let (mut runner, mut machine, _) = ends();
        let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
        stranger.send_to(b"stranger", runner.local_address().unwrap()).unwrap();
        assert!(machine.send(b"machine"));
        runner.wait(Duration::from_secs(5));
        let mut buffer = [0; 64];
        assert_eq!(runner.receive(&mut buffer), Some(7), "the machine's packet");
        runner.wait(Duration::from_millis(50));
        assert_eq!(runner.receive(&mut buffer), None);
    }

    #[test]
    fn a_peer_that_is_not_there_does_no_harm() {
        let machine: SocketAddr = format!("127.0.0.1:{}", free_port()).parse().unwrap();
        let Ok(mut runner) = UdpGateway::open(machine, End::Runner, None) else { return };
        for _ in 0..3 {
            runner.send(b"command");
            runner.wait(Duration::from_millis(5));
            assert_eq!(runner.receive(&mut [0; 64]), None);
        }
        let mut late = UdpGateway::open(machine, End::Machine, None).unwrap();
        assert!(runner.send(b"command"));
        late.wait(Duration::from_secs(5));
        assert_eq!(late.receive(&mut [0; 64]), Some(7));
    }

    #[test]
    fn loopback_unless_given() {
        let (runner, _, machine) = ends();
        let own = runner.local_address().unwrap();
        assert!(own.ip().is_loopback());
        assert_eq!(own.port(), machine.port() + 1);
        let far = "10.0.0.2:9000".parse().unwrap();
        let message = UdpGateway::open(far, End::Runner, None).unwrap_err().to_string();
        assert!(message.contains("--bind"), "{message}");
    }
}
