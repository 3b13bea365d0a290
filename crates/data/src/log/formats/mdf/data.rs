//! The data of an MDF 4 file: one block (DT), packed (DZ), or lists of them (DL, HL).
//!
//! Source: ASAM MDF 4.2, sections 5.16 to 5.21. A DZ block is packed by zlib; before that, as many
//! whole rows as there are of `parameter` bytes each may have been transposed.

use std::borrow::Cow;
use std::collections::HashSet;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::super::budget::Budget;
use super::blocks::{Block, Blocks, damaged};
use crate::log::group::Refusal;

/// Takes a piece of data.
type Take<'t> = dyn FnMut(&[u8], &mut Budget) -> Result<(), Refusal> + 't;

/// Calls `take` with the pieces of data behind a link, in their order.
pub(super) fn each<'a>(
    blocks: &Blocks<'a>,
    block: &Block<'a>,
    link: usize,
    budget: &mut Budget,
    take: &mut Take<'_>,
) -> Result<(), Refusal> {
    let Some(mut found) = blocks.any(block, link)? else { return Ok(()) };
    if found.id == *b"HL" {
        match blocks.follow(&found, 0, b"DL")? {
            Some(list) => found = list,
            None => return Ok(()),
        }
    }
    if found.id != *b"DL" {
        return take(&piece(&found, budget)?, budget);
    }
    let mut seen = HashSet::new();
    loop {
        if !seen.insert(found.place) {
            return Err(damaged(found.place, "a list of data returns to itself"));
        }
        for link in 1..found.links() {
            // Lists are made longer than they are needed.
            if let Some(data) = blocks.any(&found, link)? {
                take(&piece(&data, budget)?, budget)?;
            }
        }
        match blocks.follow(&found, 0, b"DL")? {
            Some(next) => found = next,
            None => return Ok(()),
        }
    }
}

/// The bytes of one block.
fn piece<'a>(block: &Block<'a>, budget: &mut Budget) -> Result<Cow<'a, [u8]>, Refusal> {
    match &block.id {
        b"DT" | b"SD" | b"RD" => Ok(Cow::Borrowed(block.data)),
        b"DZ" => unpacked(block, budget).map(Cow::Owned),
        b"LD" | b"DV" | b"DI" => {
            let rule = "is an MDF 4.2 file that stores its data by column, which is not read";
            Err((rule.into(), "save it as MDF 4.1, for example with asammdf".into()))
        }
        other => {
            let name = String::from_utf8_lossy(other).into_owned();
            Err(damaged(block.place, format!("a block {name} is where data are expected")))
        }
    }
}

fn unpacked(block: &Block<'_>, budget: &mut Budget) -> Result<Vec<u8>, Refusal> {
    let (kind, width, size) = (block.byte(2), block.u32(4) as usize, block.u64(8));
    if kind > 1 {
        let rule = format!("has data packed in a way that is not read (zip type {kind})");
        return Err((rule, "save it packed by deflate, for example with asammdf".into()));
    }
    budget.unpack(size)?;
    let mut bytes = Vec::new();
    let packed = block.data.get(24..).unwrap_or_default();
    let read = ZlibDecoder::new(packed).take(size).read_to_end(&mut bytes);
    read.map_err(|error| damaged(block.place, error))?;
    if bytes.len() as u64 != size {
        let found = bytes.len();
        return Err(damaged(block.place, format!("{found} of {size} packed bytes are there")));
    }
    if kind == 0 || width < 2 {
        return Ok(bytes);
    }
    let rows = bytes.len() / width;
    let end = rows * width;
    let mut turned = Vec::with_capacity(bytes.len());
    for row in 0..rows {
        turned.extend(bytes[row..end].iter().step_by(rows));
    }
    turned.extend(&bytes[end..]);
    Ok(turned)
}
