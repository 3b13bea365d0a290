//! The line to an instrument, and what can be wrong with an answer.

use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use thiserror::Error;

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

/// Longest part of a wait. A time in which this computer stood still counts as one part: what answers may have stood
/// still with it.
const PART: Duration = Duration::from_millis(50);

/// Waits in parts, up to `timeout`, until there is something; none: nothing came in time.
pub(super) fn in_parts<T, E>(
    timeout: Duration,
    mut wait: impl FnMut(Duration) -> Result<Option<T>, E>,
) -> Result<Option<T>, E> {
    let mut left = timeout;
    while !left.is_zero() {
        let part = left.min(PART);
        if let Some(something) = wait(part)? {
            return Ok(Some(something));
        }
        left -= part;
    }
    Ok(None)
}

/// Time that is left for something, of which no standstill of this computer takes more than ten parts: between two looks
/// there may be a whole exchange.
#[derive(Debug)]
pub(super) struct Patience {
    left: Duration,
    looked: Instant,
}

impl Patience {
    pub(super) fn new(seconds: f64) -> Self {
        Patience { left: Duration::from_secs_f64(seconds), looked: Instant::now() }
    }

    /// Whether the time is over; to be asked often.
    pub(super) fn is_over(&mut self) -> bool {
        let now = Instant::now();
        self.left = self.left.saturating_sub((now - self.looked).min(10 * PART));
        self.looked = now;
        self.left.is_zero()
    }
}

/// Why there is no good answer.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Broken {
    /// It did not come in time, or the line is gone.
    #[error("no answer in time")]
    Late,
    /// It is no answer to what was asked.
    #[error("an answer with {0}")]
    Garbage(String),
    /// The instrument says no.
    #[error("{0}")]
    Refused(String),
}

/// One exchange. After one whose answer did not come in time the late answer is awaited first (`settle`), so that it is not
/// taken for that of the next question.
pub(super) fn in_turn<S, T>(
    is_late: &mut bool,
    speaker: &mut S,
    settle: impl FnOnce(&mut S) -> Result<(), Broken>,
    exchange: impl FnOnce(&mut S) -> Result<T, Broken>,
) -> Result<T, Broken> {
    let settled = if *is_late { settle(speaker) } else { Ok(()) };
    let answer = settled.and_then(|()| exchange(speaker));
    *is_late = matches!(answer, Err(Broken::Late | Broken::Garbage(_)));
    answer
}

/// What the address may say behind `?`.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Axes, in the order of the channels; empty: the first that the instrument names.
    pub axes: Vec<String>,
    /// Commands are voltages (`SVA`, servo off), not targets (`MOV`, servo on).
    pub open_loop: bool,
    /// Longest wait for the answers of one exchange.
    pub timeout: Duration,
    /// Input signals that hold the positions, in the order of the channels; empty: those of the axes.
    pub analog: Vec<String>,
    /// Speed of a serial line, bit/s.
    pub baud: u32,
}

/// Speed of a serial line where none is given.
pub const BAUD: u32 = 115_200;

impl Options {
    /// Reads `axes=1,2&mode=open&timeout=0.05&analog=4,5&baud=9600`; the timeout in s is by default two cycles, at least
    /// 20 ms.
    ///
    /// # Errors
    /// A word that is none of these.
    pub fn parse(text: &str, period: f64) -> Result<Self, String> {
        let seconds = (2.0 * period).max(0.02);
        let mut options = Options {
            axes: Vec::new(),
            open_loop: false,
            timeout: Duration::from_secs_f64(seconds),
            analog: Vec::new(),
            baud: BAUD,
        };
        for word in text.split('&').filter(|word| !word.is_empty()) {
            let wrong = || {
                format!(
                    "`{word}` is none of axes=1,2 mode=closed mode=open timeout=SECONDS analog=4,5 baud=115200"
                )
            };
            let names = |list: &str| list.split(',').map(str::to_owned).collect::<Vec<_>>();
            match word.split_once('=').ok_or_else(wrong)? {
                ("axes", list) => options.axes = names(list),
                ("analog", list) => options.analog = names(list),
                ("baud", text) => {
                    let baud = text.parse().ok().filter(|baud| (300..=12_000_000).contains(baud));
                    options.baud = baud.ok_or_else(wrong)?;
                }
                ("mode", "closed") => options.open_loop = false,
                ("mode", "open") => options.open_loop = true,
                ("timeout", text) => {
                    let seconds = text.parse::<f64>().ok().filter(|s| (1e-3..=10.0).contains(s));
                    options.timeout = Duration::from_secs_f64(seconds.ok_or_else(wrong)?);
                }
                _ => return Err(wrong()),
            }
        }
        let is_bad = |name: &String| name.is_empty() || name.contains([' ', '\n', '=']);
        if options.axes.iter().chain(&options.analog).any(is_bad) {
            return Err(format!(
                "`{text}`: an axis or input signal has no name, or one with a blank"
            ));
        }
        Ok(options)
    }
}

/// Whether a reader with a timeout may go on: nothing came yet, or a signal, such as that after a standstill, ended its wait.
pub(super) fn is_none_yet(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
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
        let read = in_parts(timeout, |part| {
            stream.set_read_timeout(Some(part))?;
            match stream.read(bytes) {
                Err(error) if is_none_yet(&error) => Ok(None),
                done => done.map(Some),
            }
        });
        read.map(Option::unwrap_or_default).map_err(|error| error.to_string())
    }

    fn close(&mut self) {
        if let Some(stream) = self.stream.take() {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}

/// A line that this system has not.
#[cfg(not(unix))]
#[derive(Debug)]
pub(super) struct NoLine;

#[cfg(not(unix))]
impl Line for NoLine {
    fn open(&mut self, _: Duration) -> Result<(), String> {
        Err("this build has no serial lines; use the instrument's network port".to_owned())
    }

    fn write(&mut self, _: &[u8]) -> Result<(), String> {
        Err("the line is closed".to_owned())
    }

    fn read(&mut self, _: &mut [u8], _: Duration) -> Result<usize, String> {
        Err("the line is closed".to_owned())
    }

    fn close(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standstill_takes_one_part_of_a_wait() {
        let mut waits = 0;
        let came = in_parts(3 * PART, |_| {
            waits += 1;
            // Longer than the whole wait.
            std::thread::sleep(4 * PART);
            Ok::<_, String>((waits == 3).then_some(waits))
        });
        assert_eq!((came, waits), (Ok(Some(3)), 3));
        assert_eq!(in_parts(3 * PART, |_| Ok::<Option<()>, String>(None)), Ok(None));

        let mut patience = Patience::new(12.0 * PART.as_secs_f64());
        std::thread::sleep(15 * PART);
        assert!(!patience.is_over());
        std::thread::sleep(5 * PART);
        assert!(patience.is_over());
    }
}

#[cfg(test)]
pub(super) mod slow {
    use super::*;
    use std::collections::VecDeque;

    /// An instrument whose answers to some questions come only when more has been asked.
    #[derive(Debug)]
    pub(in crate::gateway) struct Slow {
        answers: VecDeque<(usize, String)>,
        late: usize,
        says: fn(&str) -> Option<String>,
        is_slow: fn(&str) -> bool,
    }

    impl Slow {
        /// It `says` what answers a question, and answers slow ones after so many reads in vain.
        pub(in crate::gateway) fn new(
            late: usize,
            says: fn(&str) -> Option<String>,
            is_slow: fn(&str) -> bool,
        ) -> Box<Self> {
            Box::new(Self { answers: VecDeque::new(), late, says, is_slow })
        }
    }

    impl Line for Slow {
        fn open(&mut self, _: Duration) -> Result<(), String> {
            Ok(())
        }

        fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
            let question = std::str::from_utf8(bytes).unwrap().trim();
            let waits = if (self.is_slow)(question) { self.late } else { 0 };
            self.answers.extend((self.says)(question).map(|answer| (waits, answer)));
            Ok(())
        }

        fn read(&mut self, bytes: &mut [u8], _: Duration) -> Result<usize, String> {
            let Some((waits, _)) = self.answers.front_mut() else { return Ok(0) };
            if *waits > 0 {
                *waits -= 1;
                return Ok(0);
            }
            let (_, answer) = self.answers.pop_front().unwrap_or_default();
            bytes[..answer.len()].copy_from_slice(answer.as_bytes());
            Ok(answer.len())
        }

        fn close(&mut self) {}
    }
}
