//! The line to an instrument.

use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::time::Duration;

/// Carries bytes to an instrument and back.
pub trait Line: std::fmt::Debug {
    /// Opens it, anew where it was open.
    ///
    /// # Errors
    /// Why it does not.
    fn open(&mut self, timeout: Duration) -> Result<(), String>;

    /// Sends all of this.
    ///
    /// # Errors
    /// The line is gone.
    fn write(&mut self, bytes: &[u8]) -> Result<(), String>;

    /// Takes what has come, waiting for the first byte; 0: nothing came in time, or the line is gone.
    ///
    /// # Errors
    /// The line is gone.
    fn read(&mut self, bytes: &mut [u8], timeout: Duration) -> Result<usize, String>;

    /// Closes it.
    fn close(&mut self);
}

/// A line over TCP.
#[derive(Debug)]
pub struct TcpLine {
    address: SocketAddr,
    stream: Option<TcpStream>,
}

impl TcpLine {
    /// A line that is not open yet.
    #[must_use]
    pub fn new(address: SocketAddr) -> Self {
        TcpLine { address, stream: None }
    }

    fn stream(&mut self) -> Result<&mut TcpStream, String> {
        self.stream.as_mut().ok_or_else(|| "the line is closed".to_owned())
    }
}

impl Line for TcpLine {
    fn open(&mut self, timeout: Duration) -> Result<(), String> {
        self.close();
        let say = |error: std::io::Error| error.to_string();
        let stream = TcpStream::connect_timeout(&self.address, timeout).map_err(say)?;
        stream.set_nodelay(true).map_err(say)?;
        stream.set_write_timeout(Some(timeout)).map_err(say)?;
        self.stream = Some(stream);
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.stream()?.write_all(bytes).map_err(|error| error.to_string())
    }

    fn read(&mut self, bytes: &mut [u8], timeout: Duration) -> Result<usize, String> {
        let stream = self.stream()?;
        stream.set_read_timeout(Some(timeout)).map_err(|error| error.to_string())?;
        stream.read(bytes).map_err(|error| error.to_string())
    }

    fn close(&mut self) {
        if let Some(stream) = self.stream.take() {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}
