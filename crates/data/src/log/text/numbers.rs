//! Lines of numbers alone, of which most logs consist: read without looking for quotation marks and words, on all
//! processors.

use std::io::{self, Read};
use std::thread;

use crate::log::lines::Place;
use crate::log::table::Table;
use crate::log::ticks::Base;

/// Bytes that each thread takes at a time.
const BLOCK: usize = 2 << 20;
/// Bytes below which another thread is not worth its start.
const LEAST: usize = 1 << 17;

/// Takes lines into the table as long as each has one finite number for each column; `before` lines stand above.
/// The text that was read and not taken, which begins with a line, and the number of lines above it.
pub(super) fn read(
    mut bytes: impl Read,
    separator: u8,
    table: &mut Table<'_>,
    before: usize,
) -> io::Result<(Vec<u8>, usize)> {
    let (mut text, mut line) = (Vec::new(), before);
    let Some(columns) = table.plain_columns() else { return Ok((text, line)) };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let most = threads * BLOCK;
    let mut shape = None;
    loop {
        let is_last = bytes.by_ref().take(most as u64).read_to_end(&mut text)? < most;
        let end = if is_last { text.len() } else { line_end(&text, text.len()) };
        let shape = *shape.get_or_insert_with(|| {
            let line = text.split(|byte| *byte == b'\n').next().unwrap_or_default();
            let base = table.begin_times(|at| line.split(|byte| *byte == separator).nth(at));
            Shape { separator, columns, base }
        });
        let blocks = blocks(&text[..end], threads);
        let mut taken = 0;
        for (block, found) in blocks.iter().zip(parsed(&blocks, shape)) {
            for row in found.numbers.chunks_exact(columns) {
                line += 1;
                table.numbers(row.iter().copied(), Place::Line(line));
            }
            taken += found.bytes;
            if found.bytes < block.len() {
                return Ok((text.split_off(taken), line));
            }
        }
        text.drain(..end);
        // Without an end of a line in all of it, this is no line of numbers.
        if is_last || end == 0 {
            return Ok((text, line));
        }
    }
}

/// The end of the last line that ends at `most` bytes or before, 0 where there is none.
fn line_end(text: &[u8], most: usize) -> usize {
    text[..most].iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1)
}

/// The text in up to `count` blocks of lines.
fn blocks(mut text: &[u8], count: usize) -> Vec<&[u8]> {
    let size = text.len().div_ceil(count).max(LEAST);
    let mut blocks = Vec::new();
    while !text.is_empty() {
        let end = if text.len() > size { line_end(text, size) } else { text.len() };
        let (block, rest) = text.split_at(if end > 0 { end } else { text.len() });
        blocks.push(block);
        text = rest;
    }
    blocks
}

/// What a line of numbers looks like.
#[derive(Clone, Copy)]
struct Shape {
    separator: u8,
    columns: usize,
    /// The column of times whose first one is taken off all.
    base: Option<(usize, Base)>,
}

/// What a block begins with.
#[derive(Default)]
struct Found {
    numbers: Vec<f64>,
    /// The length of the lines that they stand in.
    bytes: usize,
}

/// What each of the blocks begins with; a block for which there is no thread is read by this one.
fn parsed(blocks: &[&[u8]], shape: Shape) -> Vec<Found> {
    let [first, others @ ..] = blocks else { return Vec::new() };
    thread::scope(|scope| {
        let others: Vec<_> = others
            .iter()
            .map(|block| {
                let work = move || lines(block, shape);
                (block, thread::Builder::new().spawn_scoped(scope, work))
            })
            .collect();
        let first = lines(first, shape);
        let others = others.into_iter().map(|(block, thread)| {
            let found = thread.ok().and_then(|thread| thread.join().ok());
            found.unwrap_or_else(|| lines(block, shape))
        });
        std::iter::once(first).chain(others).collect()
    })
}

fn lines(text: &[u8], shape: Shape) -> Found {
    // Without a base, what is asked of each cell is not asked.
    match shape.base {
        None => lines_of(text, shape, &|_, text: &[u8]| number(text)),
        Some((at, base)) => lines_of(text, shape, &|column, text: &[u8]| match column == at {
            true => base.off_text(text),
            false => number(text),
        }),
    }
}

fn lines_of(
    text: &[u8],
    shape: Shape,
    number: &impl Fn(usize, &[u8]) -> Option<(f64, usize)>,
) -> Found {
    let mut found = Found::default();
    while found.bytes < text.len() {
        let kept = found.numbers.len();
        let Some(length) = line(&text[found.bytes..], shape, number, &mut found.numbers) else {
            found.numbers.truncate(kept);
            break;
        };
        found.bytes += length;
    }
    found
}

#[inline]
fn number(text: &[u8]) -> Option<(f64, usize)> {
    fast_float2::parse_partial(text).ok()
}

/// The length of the first line with its end, if it is numbers alone.
#[inline]
fn line(
    text: &[u8],
    shape: Shape,
    number_of: &impl Fn(usize, &[u8]) -> Option<(f64, usize)>,
    numbers: &mut Vec<f64>,
) -> Option<usize> {
    let Shape { separator, columns, .. } = shape;
    let mut rest = text;
    for column in 0..columns {
        let (number, length) = number_of(column, unpadded(rest))?;
        if !number.is_finite() {
            return None;
        }
        numbers.push(number);
        rest = unpadded(&unpadded(rest)[length..]);
        rest = match rest {
            [next, rest @ ..] if column + 1 < columns && *next == separator => rest,
            [b'\n', rest @ ..] | [b'\r', b'\n', rest @ ..] if column + 1 == columns => rest,
            [] if column + 1 == columns => rest,
            _ => return None,
        };
    }
    Some(text.len() - rest.len())
}

#[inline]
fn unpadded(mut text: &[u8]) -> &[u8] {
    while let [b' ', rest @ ..] = text {
        text = rest;
    }
    text
}
