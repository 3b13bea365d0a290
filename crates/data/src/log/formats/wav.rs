//! Audio files, WAV: what sound cards, field recorders and vibration analysers with audio inputs record.
//!
//! Layout after Microsoft's and IBM's Multimedia Programming Interface (1991), the extensible format of Windows, and RF64
//! (EBU Tech 3306) for more than 4 GB. Integers are parts of the full scale, x/2^(bits−1), as in MATLAB's `audioread`.

use std::path::Path;

use super::broken;
use super::budget::Budget;
use crate::log::group::{Found, Group, Raw, Refusal};

const PCM: u16 = 1;
const FLOAT: u16 = 3;
/// The format stands in the first bytes of its identifier.
const EXTENSIBLE: u16 = 0xfffe;
/// A size that is not known, or stands in `ds64`.
const UNKNOWN: u32 = u32::MAX;

/// Whether a file that begins like this is one.
pub(super) fn is_begin(start: &[u8]) -> bool {
    let is_riff = start.starts_with(b"RIFF") || start.starts_with(b"RF64");
    is_riff && start.get(8..12) == Some(b"WAVE")
}

/// The channels of a file.
pub(super) fn read(path: &Path, budget: &mut Budget, _: bool) -> Result<Found, Refusal> {
    let broken = |why: &str| broken("WAV", why);
    let bytes = std::fs::read(path).map_err(|error| super::broken("WAV", error))?;
    let (mut format, mut long) = (None, None);
    let mut rest = bytes.get(12..).unwrap_or_default();
    while let Some((name, size, content)) = chunk(rest) {
        match name {
            b"ds64" => {
                long = content.get(8..16).and_then(|x| Some(u64::from_le_bytes(x.try_into().ok()?)))
            }
            b"fmt " => {
                format = Some(Format::read(content.get(..size as usize).unwrap_or(content))?)
            }
            b"data" => {
                let format = format.ok_or_else(|| broken("its values come before their format"))?;
                // What is recorded without an end says no size, or none yet.
                let stated = match size {
                    0 | UNKNOWN => long.filter(|_| size == UNKNOWN),
                    size => Some(u64::from(size)),
                };
                return format.values(content, stated, budget);
            }
            _ => {}
        }
        // Chunks begin at even places.
        let next = u64::from(size) + u64::from(size % 2);
        rest = usize::try_from(next).ok().and_then(|next| content.get(next..)).unwrap_or_default();
    }
    Err(broken("it has no values"))
}

/// Name and size of the chunk that begins here, and everything behind its head.
fn chunk(rest: &[u8]) -> Option<(&[u8; 4], u32, &[u8])> {
    let (name, rest) = rest.split_first_chunk::<4>()?;
    let (size, content) = rest.split_first_chunk::<4>()?;
    Some((name, u32::from_le_bytes(*size), content))
}

/// How values are stored.
#[derive(Clone, Copy)]
struct Format {
    is_float: bool,
    channels: usize,
    rate: u32,
    /// Bytes of a value.
    width: usize,
}

impl Format {
    fn read(content: &[u8]) -> Result<Self, Refusal> {
        let short = |at: usize| {
            let bytes = content.get(at..at + 2).and_then(|bytes| bytes.try_into().ok());
            bytes.map(u16::from_le_bytes).ok_or_else(|| broken("WAV", "its format is cut off"))
        };
        let tag = match short(0)? {
            EXTENSIBLE => short(24)?,
            tag => tag,
        };
        let (channels, block, bits) = (short(2)?, short(12)?, short(14)?);
        let rate = u32::from(short(4)?) | u32::from(short(6)?) << 16;
        let is_float = tag == FLOAT;
        let is_read = match tag {
            PCM => matches!(bits, 8 | 16 | 24 | 32),
            FLOAT => matches!(bits, 32 | 64),
            _ => false,
        };
        if !is_read {
            let rule = format!("is a WAV file of coding {tag} with {bits} bits");
            let way_out = "save it as PCM of 8, 16, 24 or 32 bits, or as float of 32 or 64 bits";
            return Err((rule, way_out.to_owned()));
        }
        let width = usize::from(bits / 8);
        if channels == 0 || rate == 0 || usize::from(block) != usize::from(channels) * width {
            let why = format!(
                "{channels} channels of {bits} bits at {rate} Hz, {block} bytes per frame, do not fit together"
            );
            return Err(broken("WAV", why));
        }
        Ok(Self { is_float, channels: channels.into(), rate, width })
    }

    /// The columns of these bytes; `stated`: how many there are according to the file.
    fn values(
        self,
        content: &[u8],
        stated: Option<u64>,
        budget: &mut Budget,
    ) -> Result<Found, Refusal> {
        let there = content.len() as u64;
        let bytes = stated.map_or(there, |stated| stated.min(there)) as usize;
        let frame = self.channels * self.width;
        let rows = bytes / frame;
        let mut found = Found::default();
        if let Some(stated) = stated.filter(|stated| *stated > there) {
            found.notes.push(format!(
                "the file is cut off: {rows} of {} frames are there and read",
                stated / frame as u64
            ));
        }
        if !self.is_float {
            found.notes.push("integers are parts of the full scale, -1 to 1".to_owned());
        }
        let rate = f64::from(self.rate);
        budget.column(rows as u64)?;
        let mut columns =
            vec![Raw::new("time", Some("s".into()), (0..rows).map(|k| k as f64 / rate).collect())];
        for channel in 0..self.channels {
            budget.column(rows as u64)?;
            let frames = content[..rows * frame].chunks_exact(frame);
            let at = channel * self.width;
            let values = frames.map(|frame| self.value(&frame[at..at + self.width])).collect();
            columns.push(Raw::new(format!("channel[{}]", channel + 1), None, values));
        }
        found.groups.push(Group::new("data", columns));
        Ok(found)
    }

    fn value(self, bytes: &[u8]) -> f64 {
        match (self.is_float, bytes) {
            (false, &[a]) => (f64::from(a) - 128.0) / 128.0,
            (false, &[a, b]) => f64::from(i16::from_le_bytes([a, b])) / f64::from(1_u32 << 15),
            (false, &[a, b, c]) => {
                f64::from(i32::from_le_bytes([0, a, b, c])) / f64::from(1_u32 << 31)
            }
            (false, &[a, b, c, d]) => {
                f64::from(i32::from_le_bytes([a, b, c, d])) / f64::from(1_u32 << 31)
            }
            (true, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            (true, &[a, b, c, d, e, f, g, h]) => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
            _ => f64::NAN,
        }
    }
}
