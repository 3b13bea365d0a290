//! Small MDF 4 files.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

/// Blocks one after the other.
pub(crate) struct File {
    pub(crate) bytes: Vec<u8>,
}

/// A channel: name, what it is, and the places of blocks that belong to it.
#[derive(Clone, Default)]
pub(crate) struct Channel {
    pub(crate) name: &'static str,
    /// 0: values, 1: texts, 2: master.
    pub(crate) kind: u8,
    pub(crate) data_type: u8,
    pub(crate) byte: u32,
    pub(crate) bits: u32,
    pub(crate) shift: u8,
    pub(crate) unit: &'static str,
    pub(crate) conversion: u64,
    pub(crate) composition: u64,
}

/// The time, in the first 8 bytes.
pub(crate) fn time() -> Channel {
    Channel { name: "t", kind: 2, data_type: 4, bits: 64, unit: "s", ..Channel::default() }
}

impl File {
    pub(crate) fn new() -> Self {
        let mut bytes = b"MDF     4.10    a test  ".to_vec();
        bytes.resize(28, 0);
        bytes.extend(410_u16.to_le_bytes());
        bytes.resize(64, 0);
        let mut file = Self { bytes };
        file.block(b"HD", &[0; 6], &[0; 32]);
        file
    }

    pub(crate) fn block(&mut self, id: &[u8; 2], links: &[u64], data: &[u8]) -> u64 {
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        let place = self.bytes.len() as u64;
        self.bytes.extend([b'#', b'#', id[0], id[1], 0, 0, 0, 0]);
        self.bytes.extend((24 + 8 * links.len() as u64 + data.len() as u64).to_le_bytes());
        self.bytes.extend((links.len() as u64).to_le_bytes());
        links.iter().for_each(|link| self.bytes.extend(link.to_le_bytes()));
        self.bytes.extend(data);
        place
    }

    pub(crate) fn link(&mut self, place: u64, index: usize, to: u64) {
        let at = place as usize + 24 + 8 * index;
        self.bytes[at..at + 8].copy_from_slice(&to.to_le_bytes());
    }

    pub(crate) fn text(&mut self, text: &str) -> u64 {
        match text {
            "" => 0,
            text => self.block(b"TX", &[], &[text.as_bytes(), &[0]].concat()),
        }
    }

    pub(crate) fn conversion(&mut self, kind: u8, refs: &[u64], values: &[f64]) -> u64 {
        let mut data = vec![kind, 0, 0, 0];
        data.extend((refs.len() as u16).to_le_bytes());
        data.extend((values.len() as u16).to_le_bytes());
        data.extend([0; 16]);
        data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self.block(b"CC", &[&[0; 4], refs].concat(), &data)
    }

    /// An array of `lengths` elements, `step` bytes apart.
    pub(crate) fn array(&mut self, lengths: &[u64], step: u32) -> u64 {
        let mut data = vec![0, 0];
        data.extend((lengths.len() as u16).to_le_bytes());
        data.extend([0_u32, step, 0].map(u32::to_le_bytes).concat());
        data.extend(lengths.iter().flat_map(|length| length.to_le_bytes()));
        self.block(b"CA", &[0], &data)
    }

    pub(crate) fn channels(&mut self, channels: &[Channel]) -> u64 {
        let mut first = 0;
        for channel in channels.iter().rev() {
            let (name, unit) = (self.text(channel.name), self.text(channel.unit));
            let sync = u8::from(channel.kind == 2);
            let mut data = vec![channel.kind, sync, channel.data_type, channel.shift];
            data.extend([channel.byte, channel.bits].map(u32::to_le_bytes).concat());
            data.resize(72, 0);
            let links = [first, channel.composition, name, 0, channel.conversion, 0, unit, 0];
            first = self.block(b"CN", &links, &data);
        }
        first
    }

    /// A group of records, before those that there are; `data` is its block.
    pub(crate) fn group(
        &mut self,
        name: &str,
        channels: &[Channel],
        size: u32,
        rows: u64,
        data: u64,
    ) {
        let (name, channels) = (self.text(name), self.channels(channels));
        let mut about = [0, rows, 0].map(u64::to_le_bytes).concat();
        about.extend([size, 0].map(u32::to_le_bytes).concat());
        let group = self.block(b"CG", &[0, channels, name, 0, 0, 0], &about);
        let next = u64::from_le_bytes(self.bytes[88..96].try_into().unwrap());
        let place = self.block(b"DG", &[next, group, data, 0], &[0; 8]);
        self.link(64, 0, place);
    }

    /// A packed block; transposed where records have a size.
    pub(crate) fn packed(&mut self, data: &[u8], size: usize) -> u64 {
        let rows = data.len().checked_div(size).unwrap_or(0);
        let mut turned: Vec<u8> = (0..size)
            .flat_map(|column| (0..rows).map(move |row| data[row * size + column]))
            .collect();
        turned.extend(&data[rows * size..]);
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(&turned).unwrap();
        let packed = packed.finish().unwrap();
        let mut head = vec![b'D', b'T', u8::from(size > 0), 0];
        head.extend((size as u32).to_le_bytes());
        head.extend([data.len() as u64, packed.len() as u64].map(u64::to_le_bytes).concat());
        self.block(b"DZ", &[], &[head, packed].concat())
    }
}
