//! From the value in a record to the physical one.
//!
//! Source: ASAM MDF 4.2, section 5.17 (CC). A conversion that makes texts of some values can name
//! further conversions for the others.

use std::collections::HashMap;
use std::rc::Rc;

use super::super::table;
use super::blocks::{Block, Blocks, u64_at};
use super::formula::{Formula, LONGEST};
use crate::log::group::Refusal;

/// Deepest conversion in a conversion; two are common.
const DEEPEST: usize = 16;

/// What a conversion makes of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Converted {
    Number(f64),
    Text,
}

/// A conversion, with those that it names.
pub(super) enum Conversion {
    None,
    /// P1 + P2·x.
    Linear([f64; 2]),
    /// (P1·x² + P2·x + P3) / (P4·x² + P5·x + P6).
    Rational([f64; 6]),
    Formula(Formula),
    /// Keys that grow, their values, and whether there are values between them.
    Table {
        pairs: Vec<[f64; 2]>,
        is_smooth: bool,
    },
    /// Lower bounds that grow, upper ones and values; the value for all others.
    Ranges {
        rows: Vec<[f64; 3]>,
        otherwise: f64,
    },
    /// Ranges (or single keys) that grow, with what belongs to each; what belongs to all others.
    Words {
        rows: Vec<([f64; 2], Rc<Conversion>)>,
        otherwise: Rc<Conversion>,
    },
    Text,
}

/// The conversions of a file, each of which is read once.
pub(super) struct Conversions<'a> {
    blocks: &'a Blocks<'a>,
    /// `None` while it is read: then it refers to itself.
    known: HashMap<u64, Option<Result<Rc<Conversion>, String>>>,
}

impl<'a> Conversions<'a> {
    pub(super) fn new(blocks: &'a Blocks<'a>) -> Self {
        Self { blocks, known: HashMap::new() }
    }

    /// The conversion that a link of a channel leads to, or why there is none that can be used.
    pub(super) fn of(
        &mut self,
        channel: &Block<'a>,
        link: usize,
    ) -> Result<Result<Rc<Conversion>, String>, Refusal> {
        match self.blocks.follow(channel, link, b"CC")? {
            Some(block) => self.read(&block, 0),
            None => Ok(Ok(Rc::new(Conversion::None))),
        }
    }

    fn read(
        &mut self,
        block: &Block<'a>,
        depth: usize,
    ) -> Result<Result<Rc<Conversion>, String>, Refusal> {
        match self.known.get(&block.place) {
            Some(Some(known)) => return Ok(known.clone()),
            Some(None) => return Ok(Err("has a conversion that refers to itself".into())),
            None if depth > DEEPEST => {
                return Ok(Err(format!("has conversions in conversions, deeper than {DEEPEST}")));
            }
            None => {}
        }
        self.known.insert(block.place, None);
        let read = self.make(block, depth)?.map(Rc::new);
        self.known.insert(block.place, Some(read.clone()));
        Ok(read)
    }

    fn make(
        &mut self,
        block: &Block<'a>,
        depth: usize,
    ) -> Result<Result<Conversion, String>, Refusal> {
        let count = usize::from(block.u16(6));
        let values: Vec<f64> = (0..count)
            .map_while(|at| u64_at(block.data, 24 + 8 * at))
            .map(f64::from_bits)
            .collect();
        let cut = || Ok(Err("has a conversion that is cut off".to_owned()));
        Ok(Ok(match block.byte(0) {
            0 => Conversion::None,
            1 => match values.first_chunk() {
                Some(parameters) => Conversion::Linear(*parameters),
                None => return cut(),
            },
            2 => match values.first_chunk() {
                Some(parameters) => Conversion::Rational(*parameters),
                None => return cut(),
            },
            3 => match Formula::parse(&self.blocks.long_text(block, 4, LONGEST + 1)?) {
                Ok(formula) => Conversion::Formula(formula),
                Err(why) => return Ok(Err(format!("has a formula that is not read: {why}"))),
            },
            kind @ (4 | 5) => {
                let mut pairs = values.as_chunks::<2>().0.to_vec();
                pairs.sort_by(|left, right| left[0].total_cmp(&right[0]));
                match pairs.is_empty() {
                    false => Conversion::Table { pairs, is_smooth: kind == 4 },
                    true => return cut(),
                }
            }
            6 => {
                let (rows, rest) = values.as_chunks::<3>();
                let mut rows = rows.to_vec();
                rows.sort_by(|left, right| left[0].total_cmp(&right[0]));
                Conversion::Ranges { rows, otherwise: rest.first().copied().unwrap_or(f64::NAN) }
            }
            kind @ (7 | 8) => return self.words(block, &values, kind == 8, depth),
            _ => Conversion::Text,
        }))
    }

    fn words(
        &mut self,
        block: &Block<'a>,
        values: &[f64],
        has_ranges: bool,
        depth: usize,
    ) -> Result<Result<Conversion, String>, Refusal> {
        let keys: Vec<[f64; 2]> = match has_ranges {
            true => values.as_chunks().0.to_vec(),
            false => values.iter().map(|key| [*key, *key]).collect(),
        };
        let mut rows = Vec::new();
        for (key, link) in keys.iter().zip(4..) {
            match self.word(block, link, depth)? {
                Ok(conversion) => rows.push((*key, conversion)),
                Err(why) => return Ok(Err(why)),
            }
        }
        rows.sort_by(|left, right| left.0[0].total_cmp(&right.0[0]));
        let otherwise = self.word(block, 4 + keys.len(), depth)?;
        Ok(otherwise.map(|otherwise| Conversion::Words { rows, otherwise }))
    }

    /// What belongs to a key: a text, or a conversion.
    fn word(
        &mut self,
        block: &Block<'a>,
        link: usize,
        depth: usize,
    ) -> Result<Result<Rc<Conversion>, String>, Refusal> {
        match self.blocks.any(block, link)?.filter(|found| found.id == *b"CC") {
            Some(found) => self.read(&found, depth + 1),
            None => Ok(Ok(Rc::new(Conversion::Text))),
        }
    }
}

impl Conversion {
    pub(super) fn convert(&self, x: f64) -> Converted {
        Converted::Number(match self {
            Self::None => x,
            _ if x.is_nan() => x,
            Self::Linear([offset, factor]) => offset + factor * x,
            Self::Rational([a, b, c, d, e, f]) => ((a * x + b) * x + c) / ((d * x + e) * x + f),
            Self::Formula(formula) => formula.value(x),
            Self::Table { pairs, is_smooth: true } => table::between(pairs, x),
            Self::Table { pairs, .. } => table::nearest(pairs, x),
            Self::Ranges { rows, otherwise } => {
                let at = rows.partition_point(|row| row[0] <= x);
                let row = at.checked_sub(1).map(|at| rows[at]).filter(|row| x <= row[1]);
                row.map_or(*otherwise, |row| row[2])
            }
            Self::Words { rows, otherwise } => {
                let at = rows.partition_point(|(key, _)| key[0] <= x);
                let row = at.checked_sub(1).map(|at| &rows[at]).filter(|(key, _)| x <= key[1]);
                return row.map_or(otherwise, |(_, conversion)| conversion).convert(x);
            }
            Self::Text => return Converted::Text,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_words() {
        let ranges =
            Conversion::Ranges { rows: vec![[0.0, 9.0, 1.0], [10.0, 19.0, 2.0]], otherwise: -1.0 };
        let number = |x| ranges.convert(x);
        assert_eq!(number(9.0), Converted::Number(1.0));
        assert_eq!(number(10.0), Converted::Number(2.0));
        assert_eq!(number(20.0), Converted::Number(-1.0));
        let linear = Rc::new(Conversion::Linear([1.0, 2.0]));
        let words = Conversion::Words {
            rows: vec![([255.0; 2], Rc::new(Conversion::Text))],
            otherwise: linear,
        };
        assert_eq!(words.convert(255.0), Converted::Text);
        assert_eq!(words.convert(4.0), Converted::Number(9.0));
    }
}
