//! The packet that runner and machine exchange, on every transport.
//!
//! One packet is one datagram: a header of 40 bytes, the channels' values, a checksum. All numbers
//! are little-endian. [`LAYOUT`] is the table of offsets; `docs/gateway.md` prints it and has a
//! peer in C and one in Python.

mod layout;

pub use layout::{Field, LAYOUT, layout_table};

use thiserror::Error;

/// The first four bytes.
pub const MAGIC: [u8; 4] = *b"PZLB";
/// Version of the layout.
pub const VERSION: u8 = 1;
/// Bytes before the values.
pub const HEADER: usize = 40;
/// Bytes of the checksum behind the values.
pub const CHECKSUM: usize = 4;
/// Most channels of one packet.
pub const MAX_CHANNELS: usize = 128;
/// Bytes of the longest packet: it fits one Ethernet frame.
pub const MAX_BYTES: usize = length(MAX_CHANNELS);

/// Bytes of a packet with this many channels.
#[must_use]
pub const fn length(channels: usize) -> usize {
    HEADER + 8 * channels + CHECKSUM
}

/// Who sends it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// From the runner to the machine.
    Command = 1,
    /// From the machine to the runner.
    Measurement = 2,
}

/// Bits of the field `status`.
///
/// In a command: [`ENABLE`](Self::ENABLE). In a measurement: the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status(pub u32);

impl Status {
    /// The runner drives the machine; without it the machine goes to, or stays in, its safe state.
    pub const ENABLE: Status = Status(1);
    /// The machine's power stage is on.
    pub const POWERED: Status = Status(1 << 8);
    /// The machine's sensors say that the values are valid.
    pub const VALID: Status = Status(1 << 9);
    /// The machine stopped itself and stays stopped until a command without ENABLE came.
    pub const SAFE: Status = Status(1 << 10);

    /// Whether all these bits are set.
    #[must_use]
    pub const fn has(self, bits: Status) -> bool {
        self.0 & bits.0 == bits.0
    }

    /// These bits too.
    #[must_use]
    pub const fn with(self, bits: Status) -> Status {
        Status(self.0 | bits.0)
    }
}

/// What stands before the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Who sends it.
    pub kind: Kind,
    /// Number of values.
    pub channels: u16,
    /// Number of the packet, counted up by its sender, modulo 2³².
    pub sequence: u32,
    /// Status bits.
    pub status: Status,
    /// The sender's monotonic time in ns when it sampled or sent.
    pub time_ns: u64,
    /// Sequence of the newest packet that the sender had from its peer; 0 before the first.
    pub echo_sequence: u32,
    /// State of the runner, see `safety::State`; a machine sends 0.
    pub state: u8,
    /// Reason of the state, see `safety::Reason`; a machine sends 0.
    pub reason: u8,
    /// The time that stood in the packet `echo_sequence`; 0 before the first.
    pub echo_time_ns: u64,
}

/// Why some bytes are no packet for us.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PacketError {
    /// Too short, or not as long as its number of channels says.
    #[error("a packet of {0} bytes is not as long as its number of channels says")]
    Length(usize),
    /// Other first bytes.
    #[error("the packet does not begin with PZLB")]
    Magic,
    /// The checksum does not fit the bytes.
    #[error("the packet's checksum is wrong")]
    Checksum,
    /// A good checksum, but another version of the layout.
    #[error("the packet has version {0}; this program speaks version 1, and 2 with --key FILE")]
    Version(u8),
    /// A good checksum, but not of the kind that is waited for.
    #[error("the packet is of kind {0}; runner and machine must not be swapped")]
    Kind(u8),
    /// A good checksum, but another number of channels.
    #[error("the packet has {has} channels; {wanted} are configured")]
    Channels {
        /// Channels of the packet.
        has: u16,
        /// Channels as configured.
        wanted: u16,
    },
}

impl PacketError {
    /// Whether the bytes were damaged on their way, as opposed to sent wrongly.
    #[must_use]
    pub fn is_corruption(self) -> bool {
        matches!(self, Self::Length(_) | Self::Magic | Self::Checksum)
    }
}

/// Writes a packet; the return value is its length.
///
/// `header.channels` must be the number of values; more than [`MAX_CHANNELS`] values, or a buffer
/// that is too short, give 0 and write nothing.
pub fn encode(header: &Header, values: &[f64], bytes: &mut [u8]) -> usize {
    let total = length(values.len());
    if values.len() > MAX_CHANNELS || bytes.len() < total {
        return 0;
    }
    let mut put = |offset: usize, field: &[u8]| {
        bytes[offset..offset + field.len()].copy_from_slice(field);
    };
    put(0, &MAGIC);
    put(4, &[VERSION, header.kind as u8]);
    put(6, &header.channels.to_le_bytes());
    put(8, &header.sequence.to_le_bytes());
    put(12, &header.status.0.to_le_bytes());
    put(16, &header.time_ns.to_le_bytes());
    put(24, &header.echo_sequence.to_le_bytes());
    put(28, &[header.state, header.reason, 0, 0]);
    put(32, &header.echo_time_ns.to_le_bytes());
    for (index, value) in values.iter().enumerate() {
        put(HEADER + 8 * index, &value.to_le_bytes());
    }
    let end = total - CHECKSUM;
    let checksum = crc32fast::hash(&bytes[..end]);
    bytes[end..total].copy_from_slice(&checksum.to_le_bytes());
    total
}

/// Reads a packet of this kind with `values.len()` channels.
///
/// # Errors
/// What is wrong with the bytes; `values` is then as it was.
pub fn decode(bytes: &[u8], kind: Kind, values: &mut [f64]) -> Result<Header, PacketError> {
    let wrong_length = PacketError::Length(bytes.len());
    if bytes.len() < length(0) || bytes.len() > MAX_BYTES {
        return Err(wrong_length);
    }
    if bytes[..4] != MAGIC {
        return Err(PacketError::Magic);
    }
    let (body, checksum) = bytes.split_at(bytes.len() - CHECKSUM);
    if crc32fast::hash(body).to_le_bytes() != checksum {
        return Err(PacketError::Checksum);
    }
    if body[4] != VERSION {
        return Err(PacketError::Version(body[4]));
    }
    if body[5] != kind as u8 {
        return Err(PacketError::Kind(body[5]));
    }
    let channels = u16::from_le_bytes(at(body, 6));
    if bytes.len() != length(channels.into()) {
        return Err(wrong_length);
    }
    if usize::from(channels) != values.len() {
        let wanted = values.len() as u16;
        return Err(PacketError::Channels { has: channels, wanted });
    }
    for (index, value) in values.iter_mut().enumerate() {
        *value = f64::from_le_bytes(at(body, HEADER + 8 * index));
    }
    Ok(Header {
        kind,
        channels,
        sequence: u32::from_le_bytes(at(body, 8)),
        status: Status(u32::from_le_bytes(at(body, 12))),
        time_ns: u64::from_le_bytes(at(body, 16)),
        echo_sequence: u32::from_le_bytes(at(body, 24)),
        state: body[28],
        reason: body[29],
        echo_time_ns: u64::from_le_bytes(at(body, 32)),
    })
}

/// `N` bytes from an offset that the caller has checked.
fn at<const N: usize>(bytes: &[u8], offset: usize) -> [u8; N] {
    let mut field = [0; N];
    field.copy_from_slice(&bytes[offset..offset + N]);
    field
}

#[cfg(test)]
mod tests;
