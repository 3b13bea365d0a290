use proptest::prelude::*;

use super::*;

fn header(kind: Kind, channels: u16) -> Header {
    Header {
        kind,
        channels,
        sequence: 0x0102_0304,
        status: Status::POWERED.with(Status::VALID),
        time_ns: 0x1112_1314_1516_1718,
        echo_sequence: 0x2122_2324,
        state: 2,
        reason: 7,
        echo_time_ns: 0x3132_3334_3536_3738,
    }
}

fn packet(values: &[f64]) -> Vec<u8> {
    let mut bytes = [0; MAX_BYTES];
    let length = encode(&header(Kind::Measurement, values.len() as u16), values, &mut bytes);
    bytes[..length].to_vec()
}

#[test]
fn the_bytes_are_those_of_the_table() {
    let bytes = packet(&[1.0]);
    let expected = "505a4c42 01 02 0100 04030201 00030000 1817161514131211 24232221 02 07 0000 \
                    3837363534333231 000000000000f03f";
    let expected: String = expected.split_whitespace().collect();
    let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hex[..expected.len()], expected);
    assert_eq!(bytes.len(), 52);
    // The check value of CRC-32/ISO-HDLC, which zlib computes too.
    assert_eq!(crc32fast::hash(b"123456789"), 0xcbf4_3926);
}

#[test]
fn the_table_has_no_gap() {
    let numbers: Vec<(usize, usize)> = LAYOUT
        .iter()
        .filter_map(|field| Some((field.offset.parse().ok()?, field.size.parse().ok()?)))
        .collect();
    assert!(numbers.windows(2).all(|pair| pair[0].0 + pair[0].1 == pair[1].0), "{numbers:?}");
    let (offset, size) = numbers[numbers.len() - 1];
    assert_eq!(offset + size, HEADER);
}

#[test]
fn what_does_not_fit_is_reported() {
    let good = packet(&[1.0, 2.0]);
    let decoded = |bytes: &[u8], channels: usize, kind: Kind| {
        decode(bytes, kind, &mut vec![0.0; channels]).unwrap_err()
    };
    let wrong = decoded(&good, 3, Kind::Measurement);
    assert_eq!(wrong, PacketError::Channels { has: 2, wanted: 3 });
    assert!(!wrong.is_corruption());
    assert_eq!(decoded(&good, 2, Kind::Command), PacketError::Kind(2));
    assert_eq!(decoded(&good[..43], 2, Kind::Measurement), PacketError::Length(43));
    assert_eq!(decoded(b"", 2, Kind::Measurement), PacketError::Length(0));
    let mut other = good.clone();
    other[4] = 9;
    let end = other.len() - CHECKSUM;
    let checksum = crc32fast::hash(&other[..end]).to_le_bytes();
    other[end..].copy_from_slice(&checksum);
    assert_eq!(decoded(&other, 2, Kind::Measurement), PacketError::Version(9));
}

#[test]
fn too_many_values_are_not_written() {
    let mut bytes = vec![0; 4096];
    let values = [0.0; MAX_CHANNELS + 1];
    assert_eq!(encode(&header(Kind::Command, 129), &values, &mut bytes), 0);
    assert_eq!(encode(&header(Kind::Command, 1), &[0.0], &mut bytes[..51]), 0);
}

proptest! {
    #[test]
    fn what_is_written_is_read(values in prop::collection::vec(any::<f64>(), 1..=MAX_CHANNELS)) {
        let bytes = packet(&values);
        let mut read = vec![0.0; values.len()];
        let found = decode(&bytes, Kind::Measurement, &mut read).unwrap();
        prop_assert_eq!(found, header(Kind::Measurement, values.len() as u16));
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&read), bits(&values));
    }

    #[test]
    fn no_burst_of_up_to_32_bits_passes(start in 0usize..(52 * 8 - 32), pattern in 1u32..) {
        let mut bytes = packet(&[1.5]);
        for bit in 0..32 {
            if pattern >> bit & 1 == 1 {
                bytes[(start + bit) / 8] ^= 1 << ((start + bit) % 8);
            }
        }
        let mut value = [0.0];
        let error = decode(&bytes, Kind::Measurement, &mut value).unwrap_err();
        prop_assert!(error.is_corruption());
        prop_assert_eq!(value, [0.0]);
    }

    #[test]
    fn any_bytes_are_looked_at_without_harm(bytes in prop::collection::vec(any::<u8>(), 0..1200)) {
        prop_assert!(decode(&bytes, Kind::Command, &mut [0.0; 4]).is_err());
    }
}
