//! The blocks of an MDF 4 file.
//!
//! Source: ASAM MDF 4.2, chapter 5: a block has its name, its length, how many links it has, the
//! links (places of other blocks in the file, 0 for none) and its data.

use std::collections::HashSet;

use super::super::broken;
use crate::log::group::Refusal;

/// Longest name or unit, in bytes.
const LONGEST_TEXT: usize = 4096;

/// The bytes of a file.
pub(super) struct Blocks<'a> {
    pub(super) bytes: &'a [u8],
}

/// One block.
#[derive(Clone, Copy)]
pub(super) struct Block<'a> {
    pub(super) place: u64,
    pub(super) id: [u8; 2],
    links: &'a [u8],
    pub(super) data: &'a [u8],
}

impl<'a> Blocks<'a> {
    /// The block at a place.
    pub(super) fn at(&self, place: u64) -> Result<Block<'a>, Refusal> {
        let cut = || damaged(place, "a block is cut off or none");
        let start = usize::try_from(place).map_err(|_| cut())?;
        let rest = self.bytes.get(start..).ok_or_else(cut)?;
        let head = rest.get(..24).filter(|head| head.starts_with(b"##")).ok_or_else(cut)?;
        let number = |at: usize| u64_at(head, at).and_then(|number| usize::try_from(number).ok());
        let (length, links) = number(8).zip(number(16)).ok_or_else(cut)?;
        // The last block of a file that was not finished has no length yet.
        let length = if length < 24 { rest.len() } else { length.min(rest.len()) };
        let links = links.checked_mul(8).and_then(|links| links.checked_add(24)).ok_or_else(cut)?;
        let (links, data) = (rest.get(24..links), rest.get(links..length));
        let (links, data) = links.zip(data).ok_or_else(cut)?;
        Ok(Block { place, id: [head[2], head[3]], links, data })
    }

    /// The block that a link leads to, which must have this name; `None` where the link is 0.
    pub(super) fn follow(
        &self,
        block: &Block<'_>,
        link: usize,
        id: &[u8; 2],
    ) -> Result<Option<Block<'a>>, Refusal> {
        let Some(found) = self.any(block, link)? else { return Ok(None) };
        match found.id == *id {
            true => Ok(Some(found)),
            false => {
                let [wanted, found] = [id, &found.id].map(|id| String::from_utf8_lossy(id));
                Err(damaged(block.place, format!("link {link} leads to {found}, not to {wanted}")))
            }
        }
    }

    pub(super) fn any(&self, block: &Block<'_>, link: usize) -> Result<Option<Block<'a>>, Refusal> {
        match block.link(link) {
            0 => Ok(None),
            place => self.at(place).map(Some),
        }
    }

    /// A list of blocks: the one that a link leads to, and those that follow by their first link.
    pub(super) fn list(
        &self,
        block: &Block<'_>,
        link: usize,
        id: &[u8; 2],
    ) -> Result<Vec<Block<'a>>, Refusal> {
        let (mut all, mut seen) = (Vec::new(), HashSet::new());
        let mut next = self.follow(block, link, id)?;
        while let Some(found) = next {
            if !seen.insert(found.place) {
                return Err(damaged(found.place, "a list of blocks returns to itself"));
            }
            all.push(found);
            next = self.follow(&found, 0, id)?;
        }
        Ok(all)
    }

    /// A name or a unit: a text (TX) or the text in a comment (MD); empty where there is none.
    pub(super) fn text(&self, block: &Block<'_>, link: usize) -> Result<String, Refusal> {
        self.long_text(block, link, LONGEST_TEXT)
    }

    /// A text of at most so many bytes: many blocks can name one text.
    pub(super) fn long_text(
        &self,
        block: &Block<'_>,
        link: usize,
        most: usize,
    ) -> Result<String, Refusal> {
        let Some(found) = self.any(block, link)? else { return Ok(String::new()) };
        let bytes = &found.data[..found.data.len().min(most)];
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
        let text = String::from_utf8_lossy(&bytes[..end]).trim().to_owned();
        Ok(match &found.id {
            b"MD" => inside(&text),
            _ => text,
        })
    }
}

impl Block<'_> {
    /// The place that a link leads to; 0 for none.
    pub(super) fn link(&self, index: usize) -> u64 {
        u64_at(self.links, 8 * index).unwrap_or(0)
    }

    pub(super) fn links(&self) -> usize {
        self.links.len() / 8
    }

    pub(super) fn byte(&self, at: usize) -> u8 {
        self.data.get(at).copied().unwrap_or(0)
    }

    pub(super) fn u16(&self, at: usize) -> u16 {
        let word = self.data.get(at..at + 2).and_then(|word| word.try_into().ok());
        word.map_or(0, u16::from_le_bytes)
    }

    pub(super) fn u32(&self, at: usize) -> u32 {
        let word = self.data.get(at..at + 4).and_then(|word| word.try_into().ok());
        word.map_or(0, u32::from_le_bytes)
    }

    pub(super) fn u64(&self, at: usize) -> u64 {
        u64_at(self.data, at).unwrap_or(0)
    }
}

pub(super) fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..at.checked_add(8)?)?.try_into().ok().map(u64::from_le_bytes)
}

pub(super) fn damaged(place: u64, what: impl std::fmt::Display) -> Refusal {
    broken("MDF 4", format_args!("at byte {place} {what}"))
}

/// The content of the first element TX of a comment.
fn inside(xml: &str) -> String {
    let text = xml.split_once("<TX").and_then(|(_, rest)| rest.split_once('>'));
    let text = text.and_then(|(_, rest)| rest.split_once("</TX>")).map_or("", |(text, _)| text);
    let named = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    named.iter().fold(text.trim().to_owned(), |text, (name, letter)| text.replace(name, letter))
}
