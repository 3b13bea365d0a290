//! The values of a segment of TDMS: one channel after the other, interleaved, or as the buffers of DAQmx.

use std::collections::HashMap;

use super::super::budget::Budget;
use super::object::{BOOL, Cell, INSTANT, Layout, Object, TEXT, size_of_kind};
use crate::log::group::Refusal;

/// How values stand in a segment.
#[derive(Clone, Copy)]
pub(super) struct Order {
    pub(super) is_big: bool,
    pub(super) is_interleaved: bool,
}

/// A number; for an instant, seconds since 1904. `None` for what is no number.
pub(super) fn number(bytes: &[u8], kind: u32, is_big: bool) -> Option<f64> {
    macro_rules! of {
        ($type:ty) => {{
            let word = bytes.first_chunk()?;
            (if is_big { <$type>::from_be_bytes(*word) } else { <$type>::from_le_bytes(*word) })
                as f64
        }};
    }
    Some(match kind {
        1 => of!(i8),
        2 => of!(i16),
        3 => of!(i32),
        4 => of!(i64),
        5 => of!(u8),
        6 => of!(u16),
        7 => of!(u32),
        8 => of!(u64),
        9 | 0x19 => of!(f32),
        10 | 0x1a => of!(f64),
        BOOL => f64::from(u8::from(*bytes.first()? != 0)),
        _ => return None,
    })
}

/// An instant: whole seconds since 1904 and parts of 2⁻⁶⁴ s.
fn instant(bytes: &[u8], is_big: bool) -> Option<(i64, u64)> {
    let (first, second) = (*bytes.first_chunk::<8>()?, *bytes.last_chunk::<8>()?);
    Some(match is_big {
        true => (i64::from_be_bytes(first), u64::from_be_bytes(second)),
        false => (i64::from_le_bytes(second), u64::from_le_bytes(first)),
    })
}

/// The type of a value of DAQmx.
fn daqmx_kind(kind: u32) -> Option<u32> {
    [5, 1, 6, 2, 7, 3, 8, 4, 9, 10].get(kind as usize).copied()
}

/// The objects with values of a segment, in their order.
pub(super) struct Chunk {
    objects: Vec<(usize, Layout)>,
}

/// A stretch of values: the object, the first byte, from one to the next, their number.
struct Stretch<'a> {
    object: usize,
    layout: &'a Layout,
    cell: Option<Cell>,
    start: usize,
    step: usize,
    count: usize,
}

impl Chunk {
    pub(super) fn new(objects: Vec<(usize, Layout)>) -> Self {
        Self { objects: objects.into_iter().filter(|(_, layout)| layout.count > 0).collect() }
    }

    /// Reads all values of a segment; a sentence about an end within a chunk.
    pub(super) fn read(
        &self,
        bytes: &[u8],
        order: Order,
        objects: &mut [Object],
        budget: &mut Budget,
    ) -> Result<Option<String>, Refusal> {
        let Some(size) = self.size().and_then(|size| usize::try_from(size).ok()) else {
            self.refuse(objects, "is stored in a type of unknown size, or beside one");
            return Ok(None);
        };
        if size == 0 {
            return Ok(None);
        }
        let is_daqmx = self.is_daqmx();
        if order.is_interleaved && !is_daqmx {
            let step: usize =
                self.objects.iter().filter_map(|(_, layout)| size_of_kind(layout.kind)).sum();
            if self.objects.iter().any(|(_, layout)| size_of_kind(layout.kind).is_none()) {
                self.refuse(objects, "is interleaved with texts");
                return Ok(None);
            }
            let rows = bytes.len() / step;
            let mut start = 0;
            for (object, layout) in &self.objects {
                let stretch =
                    Stretch { object: *object, layout, cell: None, start, step, count: rows };
                stretch.read(bytes, order, objects, budget)?;
                start += size_of_kind(layout.kind).unwrap_or(0);
            }
            let is_cut = !bytes.len().is_multiple_of(step);
            return Ok(is_cut.then(|| ": the last row is there in part".into()));
        }
        let mut chunks = bytes.chunks_exact(size);
        let of_chunk = self.stretches(size);
        for chunk in chunks.by_ref() {
            for stretch in &of_chunk {
                stretch.read(chunk, order, objects, budget)?;
            }
        }
        let rest = chunks.remainder();
        if rest.is_empty() {
            return Ok(None);
        }
        // Of a chunk that is cut off, the rows that all channels of one length have.
        let stretches = self.stretches(rest.len());
        let mut rows = HashMap::new();
        for stretch in &stretches {
            let least = rows.entry(stretch.layout.count).or_insert(stretch.count);
            *least = stretch.count.min(*least);
        }
        for mut stretch in stretches {
            stretch.count = rows[&stretch.layout.count];
            stretch.read(rest, order, objects, budget)?;
        }
        Ok(Some(": of its last part the rows are read that all channels have".into()))
    }

    fn is_daqmx(&self) -> bool {
        self.objects.iter().any(|(_, layout)| !layout.cells.is_empty())
    }

    /// Bytes of a chunk.
    fn size(&self) -> Option<u64> {
        if self.is_daqmx() {
            let buffers = self.buffers();
            return buffers.iter().try_fold(0_u64, |sum, (samples, width)| {
                sum.checked_add(samples.checked_mul(u64::from(*width))?)
            });
        }
        let mut bytes = self.objects.iter().map(|(_, layout)| layout.bytes());
        bytes.try_fold(0_u64, |sum, bytes| sum.checked_add(bytes?))
    }

    /// The buffers of DAQmx: samples and bytes of each.
    fn buffers(&self) -> Vec<(u64, u32)> {
        let widths = self.objects.first().map_or(&[][..], |(_, layout)| &layout.widths);
        let mut buffers: Vec<(u64, u32)> = widths.iter().map(|width| (0, *width)).collect();
        for (_, layout) in &self.objects {
            for cell in &layout.cells {
                if let Some((samples, _)) = buffers.get_mut(cell.buffer as usize) {
                    *samples = layout.count.max(*samples);
                }
            }
        }
        buffers
    }

    /// Where the values stand in the first `length` bytes of a chunk.
    fn stretches(&self, length: usize) -> Vec<Stretch<'_>> {
        let mut stretches = Vec::new();
        if self.is_daqmx() {
            let mut starts = vec![0_usize];
            let buffers = self.buffers();
            for (samples, width) in &buffers {
                starts.push(starts[starts.len() - 1] + *samples as usize * *width as usize);
            }
            for (object, layout) in &self.objects {
                for cell in &layout.cells {
                    let Some((_, width)) = buffers.get(cell.buffer as usize) else { continue };
                    let (step, offset) = (*width as usize, cell.offset as usize);
                    let size = daqmx_kind(cell.kind).and_then(size_of_kind).unwrap_or(16);
                    if offset + size > step {
                        continue;
                    }
                    let start = starts[cell.buffer as usize] + offset;
                    let rows = (length + step).saturating_sub(start + size) / step;
                    let count = rows.min(layout.count as usize);
                    let cell = Some(*cell);
                    stretches.push(Stretch { object: *object, layout, cell, start, step, count });
                }
            }
            return stretches;
        }
        let mut start = 0_usize;
        for (object, layout) in &self.objects {
            let bytes = layout.bytes().unwrap_or(0) as usize;
            let step = size_of_kind(layout.kind).filter(|_| layout.text_bytes.is_none());
            let count = step.map_or(0, |step| length.saturating_sub(start) / step);
            let (step, count) = (step.unwrap_or(0), count.min(layout.count as usize));
            stretches.push(Stretch { object: *object, layout, cell: None, start, step, count });
            start = start.saturating_add(bytes);
        }
        stretches
    }

    fn refuse(&self, objects: &mut [Object], why: &str) {
        for (object, _) in &self.objects {
            objects[*object].why_not.get_or_insert_with(|| why.to_owned());
        }
    }
}

impl Stretch<'_> {
    fn read(
        &self,
        bytes: &[u8],
        order: Order,
        objects: &mut [Object],
        budget: &mut Budget,
    ) -> Result<(), Refusal> {
        let object = &mut objects[self.object];
        let kind = match self.cell {
            Some(cell) => daqmx_kind(cell.kind),
            None => Some(self.layout.kind),
        };
        let why = match kind {
            Some(TEXT) => Some("holds texts"),
            Some(0x0008_000c | 0x0010_000d) => Some("holds complex numbers"),
            Some(11 | 0x1b) => Some("holds numbers of 80 bits"),
            None => Some("is stored in a type that is not known"),
            _ => None,
        };
        let (Some(kind), None) = (kind, why) else {
            object.why_not = object.why_not.take().or(why.map(Into::into));
            return Ok(());
        };
        budget.column(self.count as u64)?;
        let size = size_of_kind(kind).unwrap_or(0);
        let cells = (0..self.count).map(|row| {
            let start = self.start + row * self.step;
            &bytes[start..start + size]
        });
        if kind == INSTANT {
            object.instants.extend(cells.filter_map(|cell| instant(cell, order.is_big)));
            return Ok(());
        }
        let bit = self.cell.and_then(|cell| cell.bit);
        let values = cells.map(|cell| match bit {
            Some(bit) => f64::from(cell[0] >> bit & 1),
            None => number(cell, kind, order.is_big).unwrap_or(f64::NAN),
        });
        match self.cell {
            Some(cell) => object.raw.entry(cell.scale).or_default().extend(values),
            None => object.values.extend(values),
        }
        Ok(())
    }
}
