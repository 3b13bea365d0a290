//! The matrices of a MATLAB 4 file.
//!
//! Source: MathWorks, "MAT-File Format" (R2024a), appendix A. A matrix has five whole numbers (type,
//! rows, columns, complex or not, bytes of the name), its name and its values; there is no mark at
//! the begin of the file.

use super::super::broken;
use super::super::budget::Budget;
use super::{Array, Value};
use crate::log::group::Refusal;

const HEADER: usize = 20;
/// Longest name, with its final zero; MATLAB's have 64.
const LONGEST_NAME: usize = 256;

/// A matrix of numbers or, in rows, of characters.
pub(super) struct Matrix {
    pub(super) name: String,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// The first index running fastest; of complex numbers all imaginary parts behind all real ones.
    pub(super) values: Vec<f64>,
    is_text: bool,
    /// What the matrix is, where it is no matrix of real numbers.
    other: Option<&'static str>,
}

impl Matrix {
    pub(super) fn variable(self) -> (String, Value) {
        let value = match self.other {
            Some(other) => Value::Other(other.into()),
            None if self.is_text => Value::Text(self.lines().join(" ")),
            None => {
                let numbers = |values: Vec<f64>| {
                    Value::Numbers(Array {
                        size: vec![self.rows, self.columns],
                        values,
                        unit: None,
                    })
                };
                let mut values = self.values;
                let imag = values.split_off(values.len().min(self.rows * self.columns));
                match imag.is_empty() {
                    true => numbers(values),
                    false => Value::complex(numbers(values), numbers(imag)),
                }
            }
        };
        (self.name, value)
    }

    /// The texts of its rows; an empty matrix, whose other size may be anything, has none.
    pub(super) fn lines(&self) -> Vec<String> {
        let rows = if self.columns == 0 { 0 } else { self.rows };
        (0..rows).map(|row| self.text(row, self.rows, self.columns)).collect()
    }

    /// The texts of its columns.
    pub(super) fn standing(&self) -> Vec<String> {
        let columns = if self.rows == 0 { 0 } else { self.columns };
        (0..columns).map(|column| self.text(column * self.rows, 1, self.rows)).collect()
    }

    fn text(&self, first: usize, step: usize, length: usize) -> String {
        let codes = (0..length).filter_map(|at| self.values.get(first + at * step));
        let letters = codes.map(|code| char::from_u32(*code as u32).unwrap_or('\u{fffd}'));
        let text: String = letters.take_while(|letter| *letter != '\0').collect();
        text.trim_end().to_owned()
    }
}

/// What the header of a matrix says.
struct Header {
    is_little: bool,
    precision: i32,
    kind: i32,
    rows: usize,
    columns: usize,
    is_complex: bool,
    name: usize,
}

impl Header {
    fn of(bytes: &[u8]) -> Option<Self> {
        let words = bytes.get(..HEADER)?.as_chunks::<4>().0;
        // The thousands of the type are the byte order; those of VAX and Cray nobody writes.
        let little = i32::from_le_bytes(words[0]);
        let (kind, is_little) = match (little, i32::from_be_bytes(words[0])) {
            (kind @ 0..1000, _) => (kind, true),
            (_, kind @ 1000..2000) => (kind - 1000, false),
            _ => return None,
        };
        let number = |at: usize| match is_little {
            true => i32::from_le_bytes(words[at]),
            false => i32::from_be_bytes(words[at]),
        };
        let length = |at: usize| usize::try_from(number(at)).ok();
        let (precision, kind) = (kind / 10, kind % 10);
        let name = length(4).filter(|name| (2..=LONGEST_NAME).contains(name))?;
        let is_known = (0..=5).contains(&precision) && (0..=2).contains(&kind);
        (is_known && matches!(number(3), 0 | 1)).then_some(Self {
            is_little,
            precision,
            kind,
            rows: length(1)?,
            columns: length(2)?,
            is_complex: number(3) == 1,
            name,
        })
    }

    fn name<'a>(&self, bytes: &'a [u8]) -> Option<&'a str> {
        let (zero, name) = bytes.get(HEADER..HEADER + self.name)?.split_last()?;
        let name = str::from_utf8(name).ok()?;
        let is_name = name.starts_with(|c: char| c.is_alphabetic() || c == '_')
            && !name.contains(char::is_control);
        (*zero == 0 && is_name).then_some(name)
    }
}

/// Whether a file begins with a matrix.
pub(in crate::log::formats) fn is_begin(bytes: &[u8]) -> bool {
    Header::of(bytes).is_some_and(|header| header.name(bytes).is_some())
}

/// The matrices of a file.
pub(super) fn read(bytes: &[u8], budget: &mut Budget) -> Result<Vec<Matrix>, Refusal> {
    let mut matrices = Vec::new();
    let mut place = 0;
    while place < bytes.len() {
        let damaged = |what: &str| broken("MATLAB 4", format_args!("at byte {place} {what}"));
        let rest = &bytes[place..];
        let header = Header::of(rest).ok_or_else(|| damaged("there is no matrix"))?;
        let name = header.name(rest).ok_or_else(|| damaged("a matrix has no name"))?;
        let width = match header.precision {
            0 => 8,
            1 | 2 => 4,
            3 | 4 => 2,
            _ => 1,
        };
        let count = header.rows.checked_mul(header.columns);
        let parts = if header.is_complex { 2 } else { 1 };
        let start = HEADER + header.name;
        let end = count.and_then(|count| count.checked_mul(width * parts));
        let end = end.and_then(|size| size.checked_add(start));
        let data = end.and_then(|end| rest.get(start..end));
        let data = data.ok_or_else(|| damaged(&format!("{name} is cut off")))?;
        let other = (header.kind == 2).then_some("is a sparse array");
        let values = if other.is_some() { Vec::new() } else { numbers(&header, data, budget)? };
        matrices.push(Matrix {
            name: name.to_owned(),
            rows: header.rows,
            columns: header.columns,
            values,
            is_text: header.kind == 1,
            other,
        });
        place += start + data.len();
    }
    Ok(matrices)
}

fn numbers(header: &Header, data: &[u8], budget: &mut Budget) -> Result<Vec<f64>, Refusal> {
    macro_rules! of {
        ($type:ty) => {{
            const SIZE: usize = size_of::<$type>();
            let words = data.as_chunks::<SIZE>().0;
            budget.column(words.len() as u64)?;
            let number = |word: &[u8; SIZE]| match header.is_little {
                true => <$type>::from_le_bytes(*word),
                false => <$type>::from_be_bytes(*word),
            };
            Ok(words.iter().map(number).map(f64::from).collect())
        }};
    }
    match header.precision {
        0 => of!(f64),
        1 => of!(f32),
        2 => of!(i32),
        3 => of!(i16),
        4 => of!(u16),
        _ => of!(u8),
    }
}
