//! A log as ASAM MDF 4.10 (`.mf4`): sorted, one group of 64-bit floats, not compressed.
//!
//! Source: ASAM MDF 4.1.0, sections 5 (block structure) and 6 (blocks). Written are IDBLOCK, HD, FH,
//! DG, CG, one CN per column with TX for name and unit, MD for comments, and one DT block.

use std::io::{self, Write};
use std::path::Path;

use super::ColumnHeader;
use crate::AtomicFile;

/// Bytes of the identification at the begin of the file.
const IDENTIFICATION: u64 = 64;
const ID: usize = 24;

/// Writes an MF4 file row by row; it appears when [`finish`](Self::finish) is called, whole.
#[derive(Debug)]
pub struct Mf4Writer {
    file: AtomicFile,
    values: usize,
    promised: u64,
    rows: u64,
}

/// What an MF4 file says about itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mf4About {
    /// Begin of the measurement in ns since 1970-01-01, UTC.
    pub start_ns: u64,
    /// One sentence.
    pub comment: String,
    /// Further properties: name and value.
    pub properties: Vec<(String, String)>,
}

impl Mf4Writer {
    /// Begins the file `path` with `rows` rows of time and these columns.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn create(
        path: &Path,
        columns: &[ColumnHeader],
        rows: u64,
        about: &Mf4About,
    ) -> io::Result<Self> {
        let mut file = AtomicFile::create(path)?;
        file.write_all(&head(columns, rows, about))?;
        Ok(Mf4Writer { file, values: columns.len(), promised: rows, rows: 0 })
    }

    /// Adds a row: time in s, one value per column. NaN is kept.
    ///
    /// # Errors
    /// The wrong number of values, more rows than were promised, or the disk is full.
    pub fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        if values.len() != self.values || self.rows == self.promised {
            let text = format!(
                "row {} of {}: {} values for {} columns",
                self.rows + 1,
                self.promised,
                values.len(),
                self.values
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        self.rows += 1;
        self.file.write_all(&time.to_le_bytes())?;
        values.iter().try_for_each(|value| self.file.write_all(&value.to_le_bytes()))
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// Fewer rows than were promised, or the disk is full; nothing remains then.
    pub fn finish(self) -> io::Result<()> {
        if self.rows != self.promised {
            let text = format!("{} rows were promised, {} came", self.promised, self.rows);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        self.file.commit()
    }
}

/// The blocks before the data, laid out one after the other.
struct Layout {
    bytes: Vec<u8>,
}

impl Layout {
    fn next(&self) -> u64 {
        IDENTIFICATION + self.bytes.len() as u64
    }

    /// Adds a block; the return value is its address.
    fn block(&mut self, id: &[u8; 4], links: &[u64], data: &[u8]) -> u64 {
        let address = self.next();
        let length = ID + 8 * links.len() + data.len().next_multiple_of(8);
        self.bytes.extend(id);
        self.bytes.extend([0; 4]);
        self.bytes.extend((length as u64).to_le_bytes());
        self.bytes.extend((links.len() as u64).to_le_bytes());
        links.iter().for_each(|link| self.bytes.extend(link.to_le_bytes()));
        self.bytes.extend(data);
        self.bytes.resize((address - IDENTIFICATION) as usize + length, 0);
        address
    }

    /// A text; 0 for none.
    fn text(&mut self, id: &[u8; 4], text: &str) -> u64 {
        if text.is_empty() {
            return 0;
        }
        let mut data = text.replace('\0', " ").into_bytes();
        data.push(0);
        self.block(id, &[], &data)
    }

    /// Sets link `index` of the block at `address`.
    fn link(&mut self, address: u64, index: usize, to: u64) {
        let place = (address - IDENTIFICATION) as usize + ID + 8 * index;
        self.bytes[place..place + 8].copy_from_slice(&to.to_le_bytes());
    }
}

fn head(columns: &[ColumnHeader], rows: u64, about: &Mf4About) -> Vec<u8> {
    let mut layout = Layout { bytes: Vec::new() };
    let time = about.start_ns.to_le_bytes();
    // Start in UTC, no offsets of zone or summer time known; angle and distance not valid.
    let hd = layout.block(b"##HD", &[0; 6], &[&time[..], &[0; 24]].concat());
    let history = format!(
        "<FHcomment xmlns=\"http://www.asam.net/mdf/v4\"><TX>created</TX><tool_id>piezoloop</tool_id>\
         <tool_vendor>piezoloop</tool_vendor><tool_version>{}</tool_version></FHcomment>",
        env!("CARGO_PKG_VERSION")
    );
    let history = layout.text(b"##MD", &history);
    let fh = layout.block(b"##FH", &[0, history], &[&time[..], &[0; 8]].concat());
    let comment = layout.text(b"##MD", &comment(about));
    let dg = layout.block(b"##DG", &[0; 4], &[0; 8]);
    let width = 8 * (columns.len() as u32 + 1);
    let group = [0u64.to_le_bytes(), rows.to_le_bytes(), [0; 8]].concat();
    let group = [&group[..], &width.to_le_bytes(), &[0; 4]].concat();
    let cg = layout.block(b"##CG", &[0; 6], &group);
    for (index, to) in [(0, dg), (1, fh), (5, comment)] {
        layout.link(hd, index, to);
    }
    layout.link(dg, 1, cg);
    let channels = channels(&mut layout, columns);
    for pair in channels.windows(2) {
        layout.link(pair[0], 0, pair[1]);
    }
    layout.link(cg, 1, channels[0]);
    let data = layout.next();
    layout.link(dg, 2, data);
    layout.bytes.extend(b"##DT\0\0\0\0");
    layout.bytes.extend((ID as u64 + rows * u64::from(width)).to_le_bytes());
    layout.bytes.extend(0u64.to_le_bytes());
    [identification(), layout.bytes].concat()
}

/// The master channel and one for each column.
fn channels(layout: &mut Layout, columns: &[ColumnHeader]) -> Vec<u64> {
    let mut all = vec![channel(layout, 0, "time", "s", "")];
    for (column, index) in columns.iter().zip(1..) {
        let unit = column.unit.as_ref().map_or("", |unit| unit.text.as_str());
        all.push(channel(layout, index, &column.name, unit, &column.description));
    }
    all
}

fn channel(layout: &mut Layout, index: u32, name: &str, unit: &str, description: &str) -> u64 {
    let name = layout.text(b"##TX", name);
    let unit = layout.text(b"##TX", unit);
    let description = layout.text(b"##TX", description);
    // Type (2: master, 0: values), what it is in step with (1: time), data type 4: IEEE 754 little
    // endian, bit 0 of its first byte.
    let kind: [u8; 4] = if index == 0 { [2, 1, 4, 0] } else { [0, 0, 4, 0] };
    let offset = (8 * index).to_le_bytes();
    let bits = 64u32.to_le_bytes();
    let data = [&kind[..], &offset, &bits, &[0; 60]].concat();
    layout.block(b"##CN", &[0, 0, name, 0, 0, 0, unit, description], &data)
}

fn identification() -> Vec<u8> {
    let mut bytes = b"MDF     4.10    piezolop".to_vec();
    bytes.extend([0; 4]);
    bytes.extend(410u16.to_le_bytes());
    bytes.resize(IDENTIFICATION as usize, 0);
    bytes
}

fn comment(about: &Mf4About) -> String {
    let property =
        |(name, value): &(String, String)| format!("<e name=\"{}\">{}</e>", xml(name), xml(value));
    let properties: String = about.properties.iter().map(property).collect();
    format!(
        "<HDcomment xmlns=\"http://www.asam.net/mdf/v4\"><TX>{}</TX>\
         <common_properties>{properties}</common_properties></HDcomment>",
        xml(&about.comment)
    )
}

/// Text inside XML; characters that XML forbids become blanks.
fn xml(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' | '\r' => out.push(c),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn u64_at(bytes: &[u8], place: u64) -> u64 {
        let place = place as usize;
        u64::from_le_bytes(bytes[place..place + 8].try_into().unwrap())
    }

    fn link(bytes: &[u8], block: u64, index: u64) -> u64 {
        u64_at(bytes, block + 24 + 8 * index)
    }

    fn text(bytes: &[u8], block: u64) -> String {
        let length = u64_at(bytes, block + 8) as usize;
        let text = &bytes[block as usize + 24..block as usize + length];
        String::from_utf8_lossy(text).trim_end_matches('\0').to_owned()
    }

    fn columns() -> Vec<ColumnHeader> {
        ["a", "position[1]"]
            .map(|name| ColumnHeader {
                name: name.into(),
                unit: crate::ColumnUnit::parse("um").ok(),
                description: "Where <it> is".into(),
            })
            .into()
    }

    #[test]
    fn the_links_lead_to_the_values() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mf4");
        let about = Mf4About { start_ns: 7, comment: "a & b".into(), ..Mf4About::default() };
        let mut writer = Mf4Writer::create(&path, &columns(), 2, &about).unwrap();
        writer.row(0.0, &[1.0, f64::NAN]).unwrap();
        writer.row(0.5, &[3.0, 4.0]).unwrap();
        writer.finish().unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!((&bytes[..16], &bytes[64..68]), (&b"MDF     4.10    "[..], &b"##HD"[..]));
        let dg = link(&bytes, 64, 0);
        let cg = link(&bytes, dg, 1);
        let time = link(&bytes, cg, 1);
        let last = link(&bytes, link(&bytes, time, 0), 0);
        assert_eq!(text(&bytes, link(&bytes, time, 2)), "time");
        assert_eq!(text(&bytes, link(&bytes, last, 2)), "position[1]");
        assert_eq!(text(&bytes, link(&bytes, last, 6)), "um");
        assert!(text(&bytes, link(&bytes, 64, 5)).contains("a &amp; b"));
        let data = link(&bytes, dg, 2);
        assert_eq!(u64_at(&bytes, data + 8), 24 + 2 * 24);
        assert_eq!(bytes.len() as u64, data + 24 + 2 * 24, "nothing behind the data");
        assert_eq!(f64::from_bits(u64_at(&bytes, data + 24 + 24 + 16)), 4.0);
        for (block, id) in [(dg, "DG"), (cg, "CG"), (time, "CN"), (last, "CN"), (data, "DT")] {
            assert_eq!(block % 8, 0);
            let place = block as usize;
            assert_eq!(&bytes[place..place + 4], format!("##{id}").as_bytes());
        }
    }

    #[cfg(feature = "formats")]
    #[test]
    fn a_foreign_reader_reads_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mf4");
        let mut writer = Mf4Writer::create(&path, &columns(), 3, &Mf4About::default()).unwrap();
        for k in 0..3 {
            writer.row(f64::from(k) * 0.1, &[f64::from(k), 7.5]).unwrap();
        }
        writer.finish().unwrap();
        let log = crate::Log::read(&path, &crate::ReadOptions::default()).unwrap();
        let column = log.column("a").unwrap();
        assert_eq!(column.values, [0.0, 1.0, 2.0]);
        assert_eq!(column.unit.as_ref().map(|unit| unit.text.as_str()), Some("um"));
        assert_eq!(log.time(), [0.0, 0.1, 0.2]);
    }

    #[test]
    fn a_broken_promise_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mf4");
        let mut writer = Mf4Writer::create(&path, &columns(), 2, &Mf4About::default()).unwrap();
        assert!(writer.row(0.0, &[1.0]).is_err());
        writer.row(0.0, &[1.0, 2.0]).unwrap();
        assert!(writer.finish().unwrap_err().to_string().contains("2 rows were promised, 1 came"));
        assert!(!path.exists());
    }
}
