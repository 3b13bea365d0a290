//! ASAM MDF 4, not compressed, by crate `mf4-rs`.

use std::path::Path;

use mf4_rs::api::channel::Channel;
use mf4_rs::api::mdf::MDF;
use mf4_rs::error::MdfError;

use super::broken;
use crate::log::group::{Group, Raw, Refusal};

/// Each channel group is one group; its master channel is its time.
pub(super) fn read(path: &Path) -> Result<Vec<Group>, Refusal> {
    let bytes = std::fs::read(path).map_err(|error| broken("MDF 4", error))?;
    let size = bytes.len() as u64;
    let is_packed = bytes.windows(4).any(|word| word == b"##DZ");
    let file = MDF::from_bytes(bytes).map_err(refuse)?;
    let groups = file.channel_groups();
    let groups = groups.iter().enumerate().map(|(index, group)| {
        let block = &group.raw_channel_group().block;
        // Memory follows what the file holds, not what it says.
        let bytes = block.cycles_nr.checked_mul(u64::from(block.samples_byte_nr.max(1)));
        if bytes.is_none_or(|bytes| bytes > size) {
            return Err(match is_packed {
                true => packed(),
                false => broken("MDF 4", "a channel group is longer than the file"),
            });
        }
        let master = group.master_channel();
        let (mut columns, mut texts) = (Vec::new(), Vec::new());
        if let Some(master) = &master {
            let unit = master.unit().map_err(refuse)?;
            columns.push(Raw::new("time", unit, master.values_as_f64().map_err(refuse)?));
        }
        for channel in group.channels() {
            let is_master = |m: &Channel<'_>| std::ptr::eq(m.block(), channel.block());
            if master.as_ref().is_some_and(is_master) {
                continue;
            }
            let Some(name) = channel.name().map_err(refuse)? else { continue };
            if is_text(&channel) {
                texts.push(name);
                continue;
            }
            let unit = channel.unit().map_err(refuse)?;
            columns.push(Raw::new(name, unit, channel.values_as_f64().map_err(refuse)?));
        }
        let rows = columns.first().map_or(0, |raw| raw.values.len());
        columns.retain(|raw| raw.values.len() == rows);
        let name = group.name().map_err(refuse)?.filter(|name| !name.is_empty());
        let mut found = Group::new(name.unwrap_or_else(|| (index + 1).to_string()), columns);
        texts.into_iter().for_each(|name| found.leave_out(name, "holds texts, bytes or dates"));
        Ok(found)
    });
    groups.collect()
}

/// Whether a channel holds texts, bytes or dates.
fn is_text(channel: &Channel<'_>) -> bool {
    // ASAM MDF 4.1, CN block: types 6 to 14 are no numbers.
    channel.block().data_type.to_u8() > 5
}

fn refuse(error: MdfError) -> Refusal {
    let text = error.to_string();
    if text.contains("##DZ") || text.contains("##HL") {
        return packed();
    }
    if matches!(error, MdfError::FileVersioningError(_)) {
        let rule = format!("is an older MDF file: {text}");
        return (rule, "save it as MDF 4.1, for example with asammdf".into());
    }
    broken("MDF 4", text)
}

fn packed() -> Refusal {
    let rule = "is a compressed MDF 4 file, which is not read";
    (rule.into(), "save it without compression, for example with asammdf".into())
}
