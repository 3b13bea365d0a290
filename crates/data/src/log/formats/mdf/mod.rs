//! ASAM MDF 4: the data of a channel group are records, which stand one after the other, packed or not,
//! alone or mixed with those of other groups.

mod blocks;
mod channel;
mod conversion;
mod data;
mod formula;

use std::collections::HashMap;
use std::path::Path;

use self::blocks::{Block, Blocks};
use self::channel::{Channel, Channels};
use self::conversion::Conversions;
use super::broken;
use super::budget::Budget;
use super::names::Names;
use crate::log::group::{Found, Group, Refusal};

/// Bytes of the identification; the first block is behind it.
const IDENTIFICATION: u64 = 64;
/// Records are decoded in stretches of so many bytes, which a cache holds.
const STRETCH: usize = 1 << 18;

/// Each channel group is one group; its master channel is its time.
pub(super) fn read(path: &Path, budget: &mut Budget) -> Result<Found, Refusal> {
    let bytes = std::fs::read(path).map_err(|error| broken("MDF 4", error))?;
    let head = bytes.get(..IDENTIFICATION as usize);
    let head = head.ok_or_else(|| broken("MDF 4", "its head is cut off"))?;
    let version = u16::from_le_bytes([head[28], head[29]]);
    if version < 400 {
        let rule =
            format!("is an older MDF file, of version {}.{:02}", version / 100, version % 100);
        return Err((rule, "save it as MDF 4.1, for example with asammdf".into()));
    }
    let mut found = Found::default();
    let is_finished = head.starts_with(b"MDF ");
    if !is_finished {
        found.notes.push("the recording was not finished: what is whole is read".into());
    }
    let blocks = Blocks { bytes: &bytes };
    let mut conversions = Conversions::new(&blocks);
    for data_group in blocks.list(&blocks.at(IDENTIFICATION)?, 0, b"DG")? {
        let mut records = Records::of(&blocks, &data_group, &mut conversions, is_finished)?;
        let mut rest = Vec::new();
        data::each(&blocks, &data_group, 2, budget, &mut |piece, budget| {
            if rest.is_empty() {
                let used = records.read(piece, budget)?;
                rest.extend(&piece[used..]);
            } else {
                rest.extend(piece);
                let used = records.read(&rest, budget)?;
                rest.drain(..used);
            }
            Ok(())
        })?;
        records.finish(&mut found, rest.len(), is_finished)?;
    }
    let has_signals = found.groups.iter().any(|group| group.columns.len() > 1);
    if has_signals {
        // Groups of texts and of frames of a bus have times only.
        let (kept, others) = found.groups.into_iter().partition(|group| group.columns.len() > 1);
        found.groups = kept;
        let others: Vec<Group> = others;
        found.groups[0].left_out.extend(others.into_iter().flat_map(|group| group.left_out));
    }
    Ok(found)
}

/// The channel groups whose records stand in one stretch of data.
struct Records {
    /// Bytes before a record that say whose it is.
    id_bytes: usize,
    groups: Vec<Recorded>,
    by_id: HashMap<u64, usize>,
    /// Records that are no longer wanted, by the count in the head of the group.
    is_counted: bool,
}

/// A channel group.
struct Recorded {
    name: String,
    /// Bytes of a record, with the bits that say what is invalid.
    size: usize,
    /// Whether its records are texts, each behind its length.
    is_texts: bool,
    /// Records that the head of the group promises.
    promised: u64,
    rows: usize,
    channels: Vec<Channel>,
    left_out: Vec<(String, String)>,
}

impl Records {
    fn of<'a>(
        blocks: &'a Blocks<'a>,
        data_group: &Block<'a>,
        conversions: &mut Conversions<'a>,
        is_counted: bool,
    ) -> Result<Self, Refusal> {
        let id_bytes = usize::from(data_group.byte(0));
        if !matches!(id_bytes, 0 | 1 | 2 | 4 | 8) {
            let what = format!("records are numbered in {id_bytes} bytes");
            return Err(blocks::damaged(data_group.place, what));
        }
        let (mut groups, mut by_id) = (Vec::new(), HashMap::new());
        for block in blocks.list(data_group, 1, b"CG")? {
            let (data_bytes, invalid) = (block.u32(24) as usize, block.u32(28) as usize);
            let mut channels = Channels {
                blocks,
                conversions: &mut *conversions,
                data_bytes,
                found: Vec::new(),
                left_out: Vec::new(),
            };
            let is_texts = block.u16(16) & 1 != 0;
            for channel in blocks.list(&block, 1, b"CN")? {
                channels.add(&channel, "", 0)?;
            }
            let Channels { found, left_out, .. } = channels;
            by_id.entry(block.u64(0)).or_insert(groups.len());
            groups.push(Recorded {
                name: blocks.text(&block, 2)?,
                size: data_bytes + invalid,
                is_texts,
                promised: block.u64(8),
                rows: 0,
                channels: if is_texts { Vec::new() } else { found },
                left_out,
            });
        }
        Ok(Self { id_bytes, groups, by_id, is_counted })
    }

    /// Reads the complete records; the result is how many bytes these are.
    fn read(&mut self, bytes: &[u8], budget: &mut Budget) -> Result<usize, Refusal> {
        if self.id_bytes == 0 {
            let Some(group) = self.groups.first_mut().filter(|group| group.size > 0) else {
                return Ok(bytes.len());
            };
            let end = bytes.len() / group.size * group.size;
            group.read(&bytes[..end], 0, self.is_counted, budget)?;
            return Ok(end);
        }
        let mut used = 0;
        loop {
            let rest = &bytes[used..];
            let Some(id) = rest.get(..self.id_bytes) else { return Ok(used) };
            let id = id.iter().rev().fold(0_u64, |id, byte| id << 8 | u64::from(*byte));
            let Some(at) = self.by_id.get(&id) else {
                return Err(broken("MDF 4", format_args!("a record belongs to no group ({id})")));
            };
            let group = &mut self.groups[*at];
            let length = match group.is_texts {
                false => Some(group.size),
                true => rest.get(self.id_bytes..self.id_bytes + 4).map(|length| {
                    4 + u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize
                }),
            };
            let end = length.and_then(|length| length.checked_add(self.id_bytes));
            let Some(record) = end.and_then(|end| rest.get(..end)) else { return Ok(used) };
            group.read(record, self.id_bytes, self.is_counted, budget)?;
            used += record.len();
        }
    }

    fn finish(self, found: &mut Found, rest: usize, is_finished: bool) -> Result<(), Refusal> {
        for recorded in self.groups {
            let (rows, promised) = (recorded.rows, recorded.promised);
            let name = match recorded.name.is_empty() {
                true => (found.groups.len() + 1).to_string(),
                false => recorded.name.clone(),
            };
            if is_finished && !recorded.is_texts && (rows as u64) < promised {
                found.notes.push(format!(
                    "group \"{name}\" is cut off: {rows} of its {promised} rows are there{}",
                    if rest > 0 { ", the last one in part" } else { "" }
                ));
            }
            found.groups.push(recorded.group(name));
        }
        Ok(())
    }
}

impl Recorded {
    /// Reads records of `before` bytes and their content each.
    fn read(
        &mut self,
        bytes: &[u8],
        before: usize,
        is_counted: bool,
        budget: &mut Budget,
    ) -> Result<(), Refusal> {
        if self.channels.is_empty() {
            return Ok(());
        }
        let size = before + self.size;
        let left =
            if is_counted { self.promised.saturating_sub(self.rows as u64) } else { u64::MAX };
        let rows = (bytes.len() / size).min(usize::try_from(left).unwrap_or(usize::MAX));
        budget.take(rows as u64, 8 * self.channels.len() as u64)?;
        for stretch in bytes[..rows * size].chunks((STRETCH / size).max(1) * size) {
            for channel in &mut self.channels {
                channel.read(stretch, size, before, self.rows);
            }
            self.rows += stretch.len() / size;
        }
        Ok(())
    }

    fn group(self, name: String) -> Group {
        let mut group = Group::new(name, Vec::new());
        let mut given = Names::default();
        given.free("time");
        let mut has_time = false;
        for channel in self.channels {
            if channel.has_text {
                let name = channel.name;
                group.leave_out(name, "holds texts (its conversion makes words of numbers)");
                continue;
            }
            if channel.is_time && !has_time {
                has_time = true;
                group.columns.insert(0, channel.raw("time".into()));
                continue;
            }
            let name = given.free(&channel.name);
            group.columns.push(channel.raw(name));
        }
        for (name, why) in self.left_out {
            group.leave_out(name, why);
        }
        group
    }
}
