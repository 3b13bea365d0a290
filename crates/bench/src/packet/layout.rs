//! The table of offsets.

use std::fmt::Write;

/// One field of the packet.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// First byte.
    pub offset: &'static str,
    /// Number of bytes.
    pub size: &'static str,
    /// Type; numbers are little-endian.
    pub data_type: &'static str,
    /// Name.
    pub name: &'static str,
    /// One sentence.
    pub meaning: &'static str,
}

const fn field(
    offset: &'static str,
    size: &'static str,
    data_type: &'static str,
    name: &'static str,
    meaning: &'static str,
) -> Field {
    Field { offset, size, data_type, name, meaning }
}

/// All fields, in order.
pub const LAYOUT: &[Field] = &[
    field("0", "4", "bytes", "magic", "`PZLB`"),
    field("4", "1", "u8", "version", "1"),
    field(
        "5",
        "1",
        "u8",
        "kind",
        "1 command (runner to machine), 2 measurement (machine to runner)",
    ),
    field("6", "2", "u16", "channels", "number n of values, 1 to 128"),
    field("8", "4", "u32", "sequence", "counted up by the sender, modulo 2^32; also its heartbeat"),
    field(
        "12",
        "4",
        "u32",
        "status",
        "bit 0 ENABLE (command); bits 8 POWERED, 9 VALID, 10 SAFE (measurement); others 0",
    ),
    field("16", "8", "u64", "time", "the sender's monotonic time in ns"),
    field(
        "24",
        "4",
        "u32",
        "echo sequence",
        "sequence of the newest good packet from the peer; 0 before the first",
    ),
    field("28", "1", "u8", "state", "state of the runner (command); 0 (measurement)"),
    field("29", "1", "u8", "reason", "reason of the state (command); 0 (measurement)"),
    field("30", "2", "u16", "reserved", "0"),
    field(
        "32",
        "8",
        "u64",
        "echo time",
        "`time` of the packet `echo sequence`; 0 before the first",
    ),
    field("40", "8 n", "f64", "values", "one per channel, in the unit of the FMU's variable"),
    field(
        "40 + 8 n",
        "4",
        "u32",
        "checksum",
        "CRC-32 (IEEE 802.3, as zlib.crc32) of all bytes before it",
    ),
];

/// The table in Markdown, as `docs/gateway.md` has it.
#[must_use]
pub fn layout_table() -> String {
    let mut text =
        String::from("| offset | size | type | field | meaning |\n|---|---|---|---|---|\n");
    for Field { offset, size, data_type, name, meaning } in LAYOUT {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {offset} | {size} | {data_type} | {name} | {meaning} |");
    }
    text
}
