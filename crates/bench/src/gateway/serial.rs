//! A serial line, and a pseudo terminal that stands for one in emulators and tests.
//!
//! A serial line knows no connection. To open it anew is to end a half command with `end`, and to wait until nothing
//! comes any more: no late answer is taken for one to what is asked next.

use std::io::ErrorKind;
use std::os::fd::OwnedFd;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::termios::{self, ControlModes, OptionalActions, QueueSelector};

use super::line::{Line, in_parts};

/// The line is quiet when nothing came for so long.
const QUIET: Duration = Duration::from_millis(30);
/// Longest wait for it to become quiet.
const MOST: Duration = Duration::from_secs(1);

/// A line over a serial port: 8 data bits, no parity, 1 stop bit, no flow control.
#[derive(Debug)]
pub struct SerialLine {
    device: PathBuf,
    baud: u32,
    end: &'static [u8],
    port: Option<OwnedFd>,
}

impl SerialLine {
    /// A line that is not open yet. `end`: what ends a command.
    #[must_use]
    pub fn new(device: &Path, baud: u32, end: &'static [u8]) -> Self {
        SerialLine { device: device.to_owned(), baud, end, port: None }
    }

    fn port(&self) -> Result<&OwnedFd, String> {
        self.port.as_ref().ok_or_else(|| "the line is closed".to_owned())
    }

    fn opened(&self) -> Result<OwnedFd, Errno> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let port = rustix::fs::open(&self.device, flags, Mode::empty())?;
        set_raw(&port, Some(self.baud))?;
        termios::tcflush(&port, QueueSelector::IOFlush)?;
        Ok(port)
    }
}

/// No echo, no line editing, no signals, and this speed.
fn set_raw(port: &OwnedFd, baud: Option<u32>) -> Result<(), Errno> {
    let mut settings = termios::tcgetattr(port)?;
    settings.make_raw();
    settings.control_modes |= ControlModes::CREAD | ControlModes::CLOCAL | ControlModes::CS8;
    settings.control_modes -= ControlModes::PARENB | ControlModes::CSTOPB | ControlModes::CRTSCTS;
    if let Some(baud) = baud {
        settings.set_speed(baud)?;
    }
    termios::tcsetattr(port, OptionalActions::Now, &settings)
}

/// Whether the port is ready within this time.
fn ready(port: &OwnedFd, what: PollFlags, timeout: Duration) -> bool {
    let mut ports = [PollFd::new(port, what)];
    let ready = in_parts(timeout, |part| {
        // A part has no whole seconds.
        let part = Timespec { tv_sec: 0, tv_nsec: part.subsec_nanos().into() };
        match poll(&mut ports, Some(&part)) {
            Err(Errno::INTR) => Ok(None),
            done => done.map(|count| (count > 0).then_some(())),
        }
    });
    matches!(ready, Ok(Some(())))
}

/// Writes all, unless nothing is taken for a second.
fn write_all(port: &OwnedFd, mut bytes: &[u8]) -> Result<(), String> {
    while !bytes.is_empty() {
        if !ready(port, PollFlags::OUT, MOST) {
            return Err("the line takes nothing".to_owned());
        }
        match rustix::io::write(port, bytes) {
            Ok(count) => bytes = &bytes[count..],
            Err(Errno::AGAIN | Errno::INTR) => {}
            Err(error) => return Err(error.to_string()),
        }
    }
    Ok(())
}

/// What has come within this time; 0: nothing.
fn read(port: &OwnedFd, bytes: &mut [u8], timeout: Duration) -> Result<usize, Errno> {
    if !ready(port, PollFlags::IN, timeout) {
        return Ok(0);
    }
    match rustix::io::read(port, bytes) {
        Err(Errno::AGAIN | Errno::INTR) => Ok(0),
        done => done,
    }
}

impl Line for SerialLine {
    fn open(&mut self, _: Duration) -> Result<(), String> {
        self.close();
        let port = self.opened().map_err(|error| match error {
            Errno::ACCESS => format!("{error}; you may need to be in the group dialout"),
            Errno::INVAL | Errno::NOTTY => {
                format!("{error}: it is no serial port, or has not {} baud", self.baud)
            }
            error => error.to_string(),
        })?;
        write_all(&port, self.end)?;
        let until = Instant::now() + MOST;
        let mut bytes = [0; 1024];
        while read(&port, &mut bytes, QUIET).map_err(|error| error.to_string())? > 0 {
            if Instant::now() > until {
                return Err(
                    "it does not become quiet: somebody sends without being asked".to_owned()
                );
            }
        }
        self.port = Some(port);
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        write_all(self.port()?, bytes)
    }

    fn read(&mut self, bytes: &mut [u8], timeout: Duration) -> Result<usize, String> {
        read(self.port()?, bytes, timeout).map_err(|error| error.to_string())
    }

    fn close(&mut self) {
        self.port = None;
    }
}

/// A pseudo terminal under a name of its own: what opens that name has a serial line to this program.
#[derive(Debug)]
pub struct Terminal {
    name: PathBuf,
    port: OwnedFd,
    /// Open, so that reading waits while no client is there.
    _other: OwnedFd,
}

impl Terminal {
    /// Makes one; `name` becomes a link to it. A link that an earlier one left is replaced.
    ///
    /// # Errors
    /// Something else has that name, or the system gives no terminal.
    pub fn open(name: &Path) -> Result<Self, String> {
        use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
        let port = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).map_err(|e| e.to_string())?;
        grantpt(&port).and_then(|()| unlockpt(&port)).map_err(|e| e.to_string())?;
        let other = ptsname(&port, Vec::new()).map_err(|e| e.to_string())?;
        let other = PathBuf::from(other.to_string_lossy().into_owned());
        if std::fs::read_link(name).is_ok_and(|old| old.parent() == other.parent()) {
            std::fs::remove_file(name).map_err(|e| e.to_string())?;
        }
        symlink(&other, name).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => "the file exists, and is no emulated line".to_owned(),
            _ => error.to_string(),
        })?;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let other = rustix::fs::open(&other, flags, Mode::empty()).map_err(|e| e.to_string())?;
        set_raw(&other, None).map_err(|e| e.to_string())?;
        Ok(Terminal { name: name.to_owned(), port, _other: other })
    }

    /// What has come within this time; 0: nothing.
    pub(super) fn read(&self, bytes: &mut [u8], timeout: Duration) -> usize {
        read(&self.port, bytes, timeout).unwrap_or(0)
    }

    /// Sends all of this; what nobody takes is lost.
    pub(super) fn write(&self, bytes: &[u8]) {
        let _ = write_all(&self.port, bytes);
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.name);
    }
}
