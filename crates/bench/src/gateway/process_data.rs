//! Where the channels of the bench stand in the process data of an EtherCAT segment.

use serde::Deserialize;

use super::csp::CspData;

/// The section `[ethercat]` of a plan:
///
/// ```toml
/// [ethercat]
/// heartbeat = 0.1                                  # s
/// powered = { device = 2, byte = 4, bit = 0 }      # input
///
/// [[ethercat.channel]]                             # one for each axis
/// output = { device = 1, byte = 0, type = "i16", scale = 0.00457763671875 }
/// input = { device = 2, byte = 0, type = "i32", scale = 1e-3, bias = -2.0 }
///
/// [[ethercat.channel]]                             # a drive in cyclic synchronous position mode
/// output = { device = 3, byte = 2, type = "i32", scale = 1e-3 }
/// input = { device = 3, byte = 2, type = "i32", scale = 1e-3 }
/// csp = { controlword = 0, mode = 6, statusword = 0, mode_display = 6 }
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProcessData {
    /// Seconds without a command after which the outputs go to their safe values; default 0.1.
    pub heartbeat: Option<f64>,
    /// Output that is set while the runner drives.
    pub enable: Option<Bit>,
    /// Input that is set while the power stage is on; default: all SubDevices are in the state OP.
    pub powered: Option<Bit>,
    /// The channels, in the order of the axes.
    #[serde(default, rename = "channel")]
    pub channels: Vec<ChannelData>,
}

/// One channel.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelData {
    /// Where the command goes.
    pub output: Entry,
    /// Where the position comes from.
    pub input: Entry,
    /// The SubDevice is a drive in cyclic synchronous position mode: output is its target (0x607A), input its
    /// position (0x6064).
    pub csp: Option<CspData>,
}

/// One number in the process data of one SubDevice: value = bias + scale · raw.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Position of the SubDevice in the segment, from 0.
    pub device: usize,
    /// First byte in the inputs or the outputs of that SubDevice.
    pub byte: usize,
    /// Type; numbers are little-endian.
    #[serde(rename = "type")]
    pub kind: NumberType,
    /// Unit of the bench per unit of the raw number.
    #[serde(default = "one")]
    pub scale: f64,
    /// Value at raw 0.
    #[serde(default)]
    pub bias: f64,
}

fn one() -> f64 {
    1.0
}

/// One bit in the process data of one SubDevice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bit {
    /// Position of the SubDevice in the segment, from 0.
    pub device: usize,
    /// Byte in the inputs or the outputs of that SubDevice.
    pub byte: usize,
    /// 0 to 7.
    pub bit: u8,
}

/// Types of numbers, as IEC 61131 knows them: SINT, USINT, INT, UINT, DINT, UDINT, REAL, LREAL.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// What one SubDevice has: its name, bytes of its outputs and of its inputs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceData {
    /// Name from its EEPROM.
    pub name: String,
    /// Bytes that the MainDevice writes.
    pub outputs: usize,
    /// Bytes that the MainDevice reads.
    pub inputs: usize,
}

impl NumberType {
    /// Bytes of a number.
    #[must_use]
    pub fn size(self) -> usize {
        match self {
            NumberType::I8 | NumberType::U8 => 1,
            NumberType::I16 | NumberType::U16 => 2,
            NumberType::I32 | NumberType::U32 | NumberType::F32 => 4,
            NumberType::F64 => 8,
        }
    }

    fn read(self, bytes: &[u8]) -> Option<f64> {
        fn at<const N: usize>(bytes: &[u8]) -> Option<[u8; N]> {
            bytes.first_chunk::<N>().copied()
        }
        Some(match self {
            NumberType::I8 => i8::from_le_bytes(at(bytes)?).into(),
            NumberType::U8 => u8::from_le_bytes(at(bytes)?).into(),
            NumberType::I16 => i16::from_le_bytes(at(bytes)?).into(),
            NumberType::U16 => u16::from_le_bytes(at(bytes)?).into(),
            NumberType::I32 => i32::from_le_bytes(at(bytes)?).into(),
            NumberType::U32 => u32::from_le_bytes(at(bytes)?).into(),
            NumberType::F32 => f32::from_le_bytes(at(bytes)?).into(),
            NumberType::F64 => f64::from_le_bytes(at(bytes)?),
        })
    }

    /// Writes a number, rounded to the nearest and limited to the type's range.
    fn write(self, raw: f64, bytes: &mut [u8]) {
        let nearest = raw.round();
        // `as` saturates; a NaN, which the runner never sends, would be 0.
        let field: &[u8] = match self {
            NumberType::I8 => &(nearest as i8).to_le_bytes(),
            NumberType::U8 => &(nearest as u8).to_le_bytes(),
            NumberType::I16 => &(nearest as i16).to_le_bytes(),
            NumberType::U16 => &(nearest as u16).to_le_bytes(),
            NumberType::I32 => &(nearest as i32).to_le_bytes(),
            NumberType::U32 => &(nearest as u32).to_le_bytes(),
            NumberType::F32 => &(raw as f32).to_le_bytes(),
            NumberType::F64 => &raw.to_le_bytes(),
        };
        if let Some(place) = bytes.get_mut(..field.len()) {
            place.copy_from_slice(field);
        }
    }
}

impl Entry {
    /// The value that stands in the inputs of its SubDevice.
    #[must_use]
    pub fn read(&self, inputs: &[u8]) -> Option<f64> {
        Some(self.bias + self.scale * self.kind.read(inputs.get(self.byte..)?)?)
    }

    /// Writes a value into the outputs of its SubDevice.
    pub fn write(&self, value: f64, outputs: &mut [u8]) {
        if let Some(bytes) = outputs.get_mut(self.byte..) {
            self.kind.write((value - self.bias) / self.scale, bytes);
        }
    }

    fn bytes(&self) -> std::ops::Range<usize> {
        self.byte..self.byte.saturating_add(self.kind.size())
    }
}

impl Bit {
    /// Whether it is set.
    #[must_use]
    pub fn read(&self, inputs: &[u8]) -> bool {
        inputs.get(self.byte).is_some_and(|byte| byte >> self.bit & 1 == 1)
    }

    /// Sets or clears it.
    pub fn write(&self, is_set: bool, outputs: &mut [u8]) {
        if let Some(byte) = outputs.get_mut(self.byte) {
            *byte = *byte & !(1 << self.bit) | u8::from(is_set) << self.bit;
        }
    }
}

/// An object of a drive.
struct Object {
    channel: usize,
    name: &'static str,
    is_output: bool,
    device: usize,
    bytes: std::ops::Range<usize>,
}

impl ProcessData {
    /// Everything that is wrong with it, for so many axes.
    #[must_use]
    pub fn problems(&self, axes: usize) -> Vec<String> {
        let mut problems = Vec::new();
        if self.channels.len() != axes {
            problems.push(format!(
                "[ethercat] has {} channels for {axes} axes; give one [[ethercat.channel]] with output and input for each axis",
                self.channels.len()
            ));
        }
        for (channel, which, entry) in self.entries() {
            if !(entry.scale.is_finite() && entry.scale != 0.0 && entry.bias.is_finite()) {
                problems.push(format!(
                    "[ethercat] channel {channel}: {which}: scale = {} and bias = {} must be finite, scale not 0",
                    entry.scale, entry.bias
                ));
            }
        }
        for (name, bit) in [("enable", self.enable), ("powered", self.powered)] {
            if let Some(bit) = bit.filter(|bit| bit.bit > 7) {
                problems.push(format!("[ethercat] {name}: bit = {} must be 0 to 7", bit.bit));
            }
        }
        let heartbeat = self.heartbeat.unwrap_or(0.1);
        if !(1e-4..=60.0).contains(&heartbeat) {
            problems.push(format!("[ethercat] heartbeat = {heartbeat} must be 0.0001 s to 60 s"));
        }
        problems.extend(self.overlaps());
        problems
    }

    /// Everything that the SubDevices of a segment do not have.
    #[must_use]
    pub fn missing(&self, devices: &[DeviceData]) -> Vec<String> {
        let mut problems = Vec::new();
        let mut look = |what: String, device: usize, end: usize, is_output: bool| {
            let word = if is_output { "outputs" } else { "inputs" };
            match devices.get(device) {
                None => problems.push(format!(
                    "{what}: there is no SubDevice {device}; the segment has {}",
                    listed(devices)
                )),
                Some(found) => {
                    let has = if is_output { found.outputs } else { found.inputs };
                    if end > has {
                        problems.push(format!(
                            "{what}: byte {} is outside SubDevice {device} ({}), which has {has} bytes of {word}",
                            end - 1,
                            found.name
                        ));
                    }
                }
            }
        };
        for (channel, which, entry) in self.entries() {
            let what = format!("channel {channel}: {which}");
            look(what, entry.device, entry.bytes().end, which == "output");
        }
        for Object { channel, name, is_output, device, bytes } in self.objects() {
            look(format!("channel {channel}: csp {name}"), device, bytes.end, is_output);
        }
        for (name, bit) in [("enable", self.enable), ("powered", self.powered)] {
            if let Some(bit) = bit {
                look(name.to_owned(), bit.device, bit.byte.saturating_add(1), name == "enable");
            }
        }
        problems
    }

    /// The objects of drives beside target and position.
    fn objects(&self) -> impl Iterator<Item = Object> {
        let drives = self.channels.iter().zip(1..).filter_map(|(c, n)| Some((c, n, c.csp?)));
        drives.flat_map(|(data, channel, csp)| {
            let object = |name, is_output, byte: usize, size: usize| {
                let entry = if is_output { &data.output } else { &data.input };
                let bytes = byte..byte.saturating_add(size);
                Object { channel, name, is_output, device: entry.device, bytes }
            };
            [
                Some(object("controlword", true, csp.controlword, 2)),
                csp.mode.map(|byte| object("mode", true, byte, 1)),
                Some(object("statusword", false, csp.statusword, 2)),
                csp.mode_display.map(|byte| object("mode_display", false, byte, 1)),
            ]
            .into_iter()
            .flatten()
        })
    }

    fn entries(&self) -> impl Iterator<Item = (usize, &'static str, &Entry)> {
        let channels = self.channels.iter().zip(1..);
        channels.flat_map(|(channel, number)| {
            [(number, "output", &channel.output), (number, "input", &channel.input)]
        })
    }

    fn overlaps(&self) -> Vec<String> {
        let outputs: Vec<(usize, &Entry)> = self
            .entries()
            .filter(|(_, which, _)| *which == "output")
            .map(|(channel, _, entry)| (channel, entry))
            .collect();
        let meets = |one: &Entry, device: usize, bytes: std::ops::Range<usize>| {
            one.device == device && one.bytes().start < bytes.end && bytes.start < one.bytes().end
        };
        let mut problems = Vec::new();
        for (index, (channel, entry)) in outputs.iter().enumerate() {
            for (other, second) in &outputs[index + 1..] {
                if meets(entry, second.device, second.bytes()) {
                    problems.push(format!(
                        "[ethercat] the outputs of channels {channel} and {other} overlap"
                    ));
                }
            }
            let enable = self.enable.filter(|bit| meets(entry, bit.device, bit.byte..bit.byte + 1));
            if enable.is_some() {
                problems.push(format!("[ethercat] enable lies in the output of channel {channel}"));
            }
        }
        let objects: Vec<Object> = self.objects().filter(|object| object.is_output).collect();
        for (index, Object { channel, name, device, bytes, .. }) in objects.iter().enumerate() {
            for (other, entry) in &outputs {
                if meets(entry, *device, bytes.clone()) {
                    problems.push(format!(
                        "[ethercat] csp {name} of channel {channel} lies in the output of channel {other}"
                    ));
                }
            }
            for second in &objects[index + 1..] {
                let is_met = second.bytes.start < bytes.end && bytes.start < second.bytes.end;
                if second.device == *device && is_met {
                    problems.push(format!(
                        "[ethercat] csp {name} of channel {channel} and {} of channel {} overlap",
                        second.name, second.channel
                    ));
                }
            }
        }
        problems
    }
}

fn listed(devices: &[DeviceData]) -> String {
    let text = |(index, device): (usize, &DeviceData)| {
        format!("{index} {} ({} out, {} in)", device.name, device.outputs, device.inputs)
    };
    devices.iter().enumerate().map(text).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn entry(kind: NumberType, byte: usize) -> Entry {
        Entry { device: 0, byte, kind, scale: 0.5, bias: 3.0 }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_to_half_a_step(value in -60.0f64..60.0, byte in 0usize..4) {
            for kind in [NumberType::I8, NumberType::I16, NumberType::I32, NumberType::F32] {
                let entry = entry(kind, byte);
                let mut bytes = [0xaa; 16];
                entry.write(value, &mut bytes);
                let found = entry.read(&bytes).unwrap();
                prop_assert!((found - value).abs() <= 0.25 + 1e-5, "{kind:?} {value} {found}");
                let others = bytes.iter().enumerate().filter(|(at, _)| !entry.bytes().contains(at));
                prop_assert_eq!(others.clone().count(), 16 - kind.size());
                prop_assert!(others.clone().all(|(_, byte)| *byte == 0xaa));
            }
        }
    }

    #[test]
    fn values_beyond_a_type_end_at_its_range() {
        let entry = Entry { device: 0, byte: 0, kind: NumberType::I16, scale: 1.0, bias: 0.0 };
        let mut bytes = [0; 2];
        for (value, end) in [(1e9, 32767.0), (-1e9, -32768.0)] {
            entry.write(value, &mut bytes);
            assert_eq!(entry.read(&bytes), Some(end));
        }
        assert_eq!(Entry { byte: 1, ..entry }.read(&bytes), None);
    }

    #[test]
    fn bits_leave_their_neighbours() {
        let bit = Bit { device: 0, byte: 1, bit: 3 };
        let mut bytes = [0, 0b0101_0101];
        bit.write(true, &mut bytes);
        assert_eq!((bytes[1], bit.read(&bytes)), (0b0101_1101, true));
        bit.write(false, &mut bytes);
        assert_eq!((bytes[1], bit.read(&bytes)), (0b0101_0101, false));
    }

    #[test]
    fn every_problem_is_reported() {
        let text = "heartbeat = 0\nenable = { device = 0, byte = 1, bit = 9 }\n\
                    [[channel]]\noutput = { device = 0, byte = 0, type = \"i16\", scale = 0 }\n\
                    input = { device = 1, byte = 0, type = \"i16\" }\n\
                    [[channel]]\noutput = { device = 0, byte = 1, type = \"u32\" }\n\
                    input = { device = 7, byte = 0, type = \"f64\" }\n";
        let data: ProcessData = toml::from_str(text).unwrap();
        let problems = data.problems(3);
        for word in ["2 channels for 3", "scale = 0", "0 to 7", "heartbeat", "1 and 2 overlap"] {
            assert!(problems.iter().any(|problem| problem.contains(word)), "{word}: {problems:?}");
        }
        let device =
            |name: &str, outputs, inputs| DeviceData { name: name.into(), outputs, inputs };
        let missing = data.missing(&[device("EL4132", 4, 0), device("EL3102", 0, 2)]);
        assert_eq!(missing.len(), 2, "{missing:?}");
        assert!(missing[0].contains("byte 4") && missing[0].contains("EL4132"), "{missing:?}");
        assert!(missing[1].contains("no SubDevice 7") && missing[1].contains("EL3102"));
    }
}
