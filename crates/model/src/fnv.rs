//! Fingerprints: FNV-1a of 64 and of 128 bits.
//!
//! Source: G. Fowler, L. C. Noll, K.-P. Vo, D. Eastlake, The FNV non-cryptographic hash algorithm.

/// FNV-1a of 64 bits over bytes, or over words that are taken like one byte each.
#[must_use]
pub fn fnv_64<T: Into<u64>>(items: impl IntoIterator<Item = T>) -> u64 {
    let mix = |hash: u64, item: T| (hash ^ item.into()).wrapping_mul(0x0000_0100_0000_01b3);
    items.into_iter().fold(0xcbf2_9ce4_8422_2325, mix)
}

/// FNV-1a of 128 bits over bytes.
#[must_use]
pub fn fnv_128(bytes: impl IntoIterator<Item = u8>) -> u128 {
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    let mix = |hash: u128, byte| (hash ^ u128::from(byte)).wrapping_mul(PRIME);
    bytes.into_iter().fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d, mix)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_widths_give_the_published_vectors() {
        assert_eq!(fnv_64("".bytes()), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv_64("a".bytes()), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv_128("".bytes()), 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d);
        assert_eq!(fnv_128("a".bytes()), 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
    }
}
