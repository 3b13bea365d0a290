//! TDMS files as LabVIEW, VeriStand and NI-DAQmx write them.
#![cfg(feature = "formats")]

#[path = "binary/tdms.rs"]
mod tdms;

use data::{Log, ReadOptions};
use tdms::{Channel, Property, daqmx, plain, segment};

const DOUBLE: u32 = 10;
const INTERLEAVED: u32 = 1 << 5;
const DAQMX: u32 = 1 << 7;

fn read(bytes: &[u8]) -> Result<Log, String> {
    let file = tempfile::Builder::new().suffix(".tdms").tempfile().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    Log::read(file.path(), &ReadOptions::default()).map_err(|problems| problems.to_string())
}

fn of(bytes: &[u8]) -> Log {
    read(bytes).unwrap_or_else(|error| panic!("{error}"))
}

fn channel(path: &'static str, index: Vec<u8>) -> Channel {
    Channel { path, index, properties: vec![("wf_increment", Property::Double(0.5))] }
}

fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn values<'a>(log: &'a Log, name: &str) -> &'a [f64] {
    &log.column(name).unwrap_or_else(|| panic!("no column {name}: {:?}", log.notes())).values
}

#[test]
fn a_unit_in_the_name_is_a_unit() {
    let mut with_unit = channel("/'g'/'RT-IO:AI0 Volt. [V]'", plain(DOUBLE, 2));
    with_unit.properties.push(("unit_string", Property::Text("V")));
    let other = channel("/'g'/'it''s [mm]'", plain(DOUBLE, 2));
    let log = of(&segment(0, &[with_unit, other], &doubles(&[1.0, 2.0, 3.0, 4.0])));
    let unit = |name: &str| log.column(name).unwrap().unit.as_ref().unwrap().text.clone();
    assert_eq!(unit("RT-IO:AI0 Volt."), "V");
    assert_eq!((unit("it's").as_str(), values(&log, "it's")), ("mm", &[3.0, 4.0][..]));
}

#[test]
fn several_chunks_and_lists_that_change() {
    let both = [channel("/'g'/'u'", plain(DOUBLE, 1)), channel("/'g'/'y'", plain(3, 1))];
    let row = |u: f64, y: i32| [&u.to_le_bytes()[..], &y.to_le_bytes()].concat();
    // Two chunks in one segment.
    let mut bytes = segment(0, &both, &[row(1.0, 10), row(2.0, -20)].concat());
    // The list goes on, u with three values: bit 2 is not set.
    let mut more = segment(
        0,
        &[channel("/'g'/'u'", plain(DOUBLE, 3)), channel("/'g'/'y'", plain(3, 3))],
        &[doubles(&[3.0, 4.0, 5.0]), [30_i32, 40, 50].map(i32::to_le_bytes).concat()].concat(),
    );
    more[4] &= !4;
    bytes.extend(more);
    // Values alone, in the layout of before.
    let values_of =
        [doubles(&[6.0, 7.0, 8.0]), [60_i32, 70, 80].map(i32::to_le_bytes).concat()].concat();
    let mut alone = b"TDSm".to_vec();
    alone.extend([8_u32, 4713].map(u32::to_le_bytes).concat());
    alone.extend([values_of.len() as u64, 0].map(u64::to_le_bytes).concat());
    alone.extend(values_of);
    bytes.extend(alone);
    let log = of(&bytes);
    assert_eq!(values(&log, "u"), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    assert_eq!(values(&log, "y"), [10.0, -20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0]);
    assert_eq!(log.time()[7], 3.5);
}

#[test]
fn interleaved_values_with_scales() {
    let mut raw = channel("/'g'/'force'", plain(2, 1));
    raw.properties.extend([
        ("NI_Scaling_Status", Property::Text("unscaled")),
        ("NI_Number_Of_Scales", Property::Count(2)),
        ("NI_Scale[1]_Scale_Type", Property::Text("Linear")),
        ("NI_Scale[1]_Linear_Slope", Property::Double(0.5)),
        ("NI_Scale[1]_Linear_Y_Intercept", Property::Double(10.0)),
        ("NI_Scale[1]_Linear_Input_Source", Property::Count(0)),
    ]);
    let rows = [(1.0, 2_i16), (3.0, -4), (5.0, 6)];
    let bytes = rows.iter().flat_map(|(u, raw)| {
        [&u64::to_le_bytes(f64::to_bits(*u))[..], &raw.to_le_bytes()].concat()
    });
    let log = of(&segment(
        INTERLEAVED,
        &[channel("/'g'/'u'", plain(DOUBLE, 1)), raw],
        &bytes.collect::<Vec<u8>>(),
    ));
    assert_eq!(values(&log, "u"), [1.0, 3.0, 5.0]);
    assert_eq!(values(&log, "force"), [11.0, 8.0, 13.0]);
}

#[test]
fn raw_values_of_daqmx() {
    // A sample: 16 bits of each of two channels, side by side in one buffer.
    let scaled = |path, offset, slope| {
        let mut channel = channel(path, daqmx(2, &[[3, offset, 0]], 4));
        channel.properties.extend([
            ("NI_Number_Of_Scales", Property::Count(2)),
            ("NI_Scale[1]_Scale_Type", Property::Text("Polynomial")),
            ("NI_Scale[1]_Polynomial_Coefficients_Size", Property::Count(2)),
            ("NI_Scale[1]_Polynomial_Coefficients[0]", Property::Double(1.0)),
            ("NI_Scale[1]_Polynomial_Coefficients[1]", Property::Double(slope)),
            ("NI_Scale[1]_Polynomial_Input_Source", Property::Count(0)),
        ]);
        channel
    };
    let samples = [100_i16, -1, 200, -2, 300, -3, 400, -4].map(i16::to_le_bytes).concat();
    let channels = [scaled("/'g'/'a'", 0, 0.25), scaled("/'g'/'b'", 2, 2.0)];
    let log = of(&segment(DAQMX, &channels, &samples));
    assert_eq!(values(&log, "a"), [26.0, 51.0, 76.0, 101.0]);
    assert_eq!(values(&log, "b"), [-1.0, -3.0, -5.0, -7.0]);
    // A scale that is not read leaves its channel out, never raw.
    let mut strain = scaled("/'g'/'b'", 2, 2.0);
    strain.properties[2].1 = Property::Text("Strain");
    let log = of(&segment(DAQMX, &[scaled("/'g'/'a'", 0, 0.25), strain], &samples));
    assert!(log.column("b").is_none() && log.left_out()[0].why.contains("\"Strain\""));
}

#[test]
fn instants_are_times() {
    let mut time = channel("/'g'/'Time'", plain(0x44, 3));
    time.properties.clear();
    let mut value = channel("/'g'/'u'", plain(DOUBLE, 3));
    value.properties.clear();
    let half = 1_u64 << 63;
    let instants = [(0, 3_800_000_000_i64), (half, 3_800_000_000), (0, 3_800_000_001)];
    let mut bytes: Vec<u8> = instants
        .iter()
        .flat_map(|(part, complete)| [part.to_le_bytes(), complete.to_le_bytes()].concat())
        .collect();
    bytes.extend(doubles(&[1.0, 2.0, 3.0]));
    let log = of(&segment(0, &[time, value], &bytes));
    assert_eq!(log.time(), [0.0, 0.5, 1.0]);
    assert!(log.notes().join("\n").contains("channel \"g/Time\" is taken as the time"));
}

/// Starts that differ by less than a clock can say are one start; others are groups of their own.
#[test]
fn starts_are_compared_as_clocks_are() {
    let at = |path, seconds, offset| {
        let mut channel = channel(path, plain(DOUBLE, 2));
        channel.properties.push(("wf_start_time", Property::Instant(seconds)));
        channel.properties.push(("wf_start_offset", Property::Double(offset)));
        channel
    };
    let values = doubles(&[1.0, 2.0, 3.0, 4.0]);
    let log = of(&segment(0, &[at("/'g'/'u'", 5, 0.0), at("/'g'/'y'", 5, 1e-12)], &values));
    assert_eq!(log.columns().len(), 2);
    let error =
        read(&segment(0, &[at("/'g'/'u'", 5, 0.0), at("/'g'/'y'", 5, 1e-3)], &values)).unwrap_err();
    assert!(error.contains("different times") && error.contains("\"g/y\""), "{error}");
}

#[test]
fn a_file_that_was_cut_off_keeps_its_complete_rows() {
    let both = || [channel("/'g'/'u'", plain(DOUBLE, 4)), channel("/'g'/'y'", plain(DOUBLE, 4))];
    let values_of: Vec<f64> = (0..8).map(f64::from).collect();
    let first = segment(0, &both(), &doubles(&values_of));
    let second = segment(0, &both(), &doubles(&values_of));
    // Within the values of y, of u, and within the list of objects.
    for (cut, rows) in [(20, 4 + 1), (40, 4), (64 + 10, 4)] {
        let mut bytes = [&first[..], &second[..second.len() - cut]].concat();
        for open in [false, true] {
            if open {
                bytes[first.len() + 12..first.len() + 20].fill(0xff);
            }
            let log = of(&bytes);
            assert_eq!(log.len(), rows, "{cut}");
            assert_eq!(values(&log, "y")[..4], [4.0, 5.0, 6.0, 7.0]);
            assert!(log.notes().join("\n").contains("is cut off"), "{:?}", log.notes());
        }
    }
}

#[test]
fn texts_and_lengths_that_cannot_be() {
    let log = of(&segment(0, &[channel("/'g'/'u'", plain(DOUBLE, 2))], &doubles(&[1.0, 2.0])));
    assert_eq!(log.len(), 2);
    let log =
        of(&segment(0, &[channel("/'g'/'u'", plain(DOUBLE, 1 << 60))], &doubles(&[1.0, 2.0])));
    assert_eq!(log.len(), 2);
    assert!(log.notes().join("\n").contains("is cut off"));
    for index in [plain(DOUBLE, u64::MAX), plain(99, 2), plain(0, 2)] {
        assert!(read(&segment(0, &[channel("/'g'/'u'", index)], &doubles(&[1.0, 2.0]))).is_err());
    }
    for at in [28, 32, 44] {
        let mut bytes = segment(0, &[channel("/'g'/'u'", plain(DOUBLE, 2))], &doubles(&[1.0, 2.0]));
        bytes[at..at + 4].copy_from_slice(&0xffff_fffe_u32.to_le_bytes());
        assert!(read(&bytes).is_err(), "{at}");
    }
}

#[test]
fn what_is_assumed_about_times_is_noted() {
    let at = |start| ("wf_start_time", Property::Instant(start));
    let part = |start: i64| {
        let mut u = channel("/'g'/'u'", plain(DOUBLE, 2));
        u.properties.push(at(start));
        let y = Channel { path: "/'g'/'y'", index: plain(DOUBLE, 2), properties: Vec::new() };
        segment(0, &[u, y], &doubles(&[1.0, 2.0, 3.0, 4.0]))
    };
    // Appended ten seconds later: the times are those of the first values, and the other start is noted.
    let log = of(&[part(100), part(110)].concat());
    assert_eq!(log.time(), [0.0, 0.5, 1.0, 1.5]);
    let notes = log.notes().join("\n");
    assert!(notes.contains("\"g/u\" has another wf_start_time behind row 2"), "{notes}");
    assert!(notes.contains("\"g/y\" says no wf_increment"), "{notes}");
}
