//! Small TDMS files.

/// A property.
pub(crate) enum Property {
    Text(&'static str),
    Double(f64),
    Count(u32),
    /// Whole seconds since 1904.
    Instant(i64),
}

/// A channel of a segment: its path, the index of its values, its properties.
pub(crate) struct Channel {
    pub(crate) path: &'static str,
    pub(crate) index: Vec<u8>,
    pub(crate) properties: Vec<(&'static str, Property)>,
}

/// Values of a type, `count` in each chunk.
pub(crate) fn plain(kind: u32, count: u64) -> Vec<u8> {
    let mut index = [20, kind, 1].map(u32::to_le_bytes).concat();
    index.extend(count.to_le_bytes());
    index
}

/// Values of DAQmx in one buffer: type, offset and scale of each; bytes of a sample.
pub(crate) fn daqmx(count: u64, scalers: &[[u32; 3]], width: u32) -> Vec<u8> {
    let mut index = [0x1269, u32::MAX, 1].map(u32::to_le_bytes).concat();
    index.extend(count.to_le_bytes());
    index.extend((scalers.len() as u32).to_le_bytes());
    for [kind, offset, scale] in scalers {
        index.extend([*kind, 0, *offset, 0, *scale].map(u32::to_le_bytes).concat());
    }
    index.extend([1, width].map(u32::to_le_bytes).concat());
    index
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

/// A segment; `bits` beside those of a list and of values: 0x20 interleaved, 0x80 DAQmx.
pub(crate) fn segment(bits: u32, channels: &[Channel], values: &[u8]) -> Vec<u8> {
    let mut list = (channels.len() as u32).to_le_bytes().to_vec();
    for channel in channels {
        list.extend(text(channel.path));
        list.extend(&channel.index);
        list.extend((channel.properties.len() as u32).to_le_bytes());
        for (name, property) in &channel.properties {
            list.extend(text(name));
            let (kind, value) = match property {
                Property::Text(value) => (0x20_u32, text(value)),
                Property::Double(value) => (10, value.to_le_bytes().to_vec()),
                Property::Count(value) => (7, value.to_le_bytes().to_vec()),
                Property::Instant(seconds) => {
                    (0x44, [0_i64, *seconds].map(i64::to_le_bytes).concat())
                }
            };
            list.extend(kind.to_le_bytes());
            list.extend(value);
        }
    }
    let mut all = b"TDSm".to_vec();
    all.extend([0xe | bits, 4713].map(u32::to_le_bytes).concat());
    all.extend((list.len() as u64 + values.len() as u64).to_le_bytes());
    all.extend((list.len() as u64).to_le_bytes());
    all.extend(list);
    all.extend(values);
    all
}
