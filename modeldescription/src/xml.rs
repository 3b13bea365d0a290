//! XML as a tree of elements with line numbers.
//!
//! Made for files of unknown origin: document type declarations (and with them entity expansion) are
//! refused, and size, nesting and the length of values are limited.

use std::borrow::Cow;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

/// Line of an element in its file, counted from 1; 0 where there is no file.
///
/// Two lines are always equal: descriptions are compared by what they say, not by their layout.
#[derive(Debug, Clone, Copy, Default)]
pub struct Line(pub u32);

impl PartialEq for Line {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Why an XML document cannot be read.
#[derive(Debug, thiserror::Error, Clone, PartialEq, Eq)]
pub enum XmlError {
    /// The file is larger than allowed.
    #[error("the file has {bytes} bytes; at most {limit} are read")]
    TooLarge {
        /// Size of the file.
        bytes: usize,
        /// Largest size that is read.
        limit: usize,
    },
    /// The bytes are not UTF-8.
    #[error(
        "byte {offset} is not UTF-8; the standard requires UTF-8, so save the file in that encoding"
    )]
    NotUtf8 {
        /// Line of the byte.
        line: u32,
        /// Offset of the byte.
        offset: usize,
    },
    /// There is a document type declaration.
    #[error(
        "a document type declaration (<!DOCTYPE …>) is refused, because entities can expand without bound; remove it"
    )]
    DocumentType {
        /// Line of the declaration.
        line: u32,
    },
    /// The text is not well-formed XML.
    #[error("not well-formed XML: {message}")]
    NotWellFormed {
        /// Line of the defect.
        line: u32,
        /// What is wrong.
        message: String,
    },
    /// A limit is exceeded.
    #[error("{what} exceeds the limit of {limit}; no FMU needs that")]
    Limit {
        /// Line of the element.
        line: u32,
        /// What is too large.
        what: String,
        /// The limit.
        limit: usize,
    },
}

impl XmlError {
    /// The line of the defect, counted from 1, where it has one.
    pub fn line(&self) -> Option<u32> {
        match self {
            XmlError::TooLarge { .. } => None,
            XmlError::NotUtf8 { line, .. }
            | XmlError::DocumentType { line }
            | XmlError::NotWellFormed { line, .. }
            | XmlError::Limit { line, .. } => Some(*line),
        }
    }
}

/// Bounds of what is read.
#[derive(Debug, Clone, Copy)]
pub struct XmlLimits {
    /// Most bytes of a document.
    pub bytes: usize,
    /// Most elements of a document.
    pub elements: usize,
    /// Deepest nesting of elements.
    pub depth: usize,
    /// Most attributes of an element.
    pub attributes: usize,
    /// Longest value of an attribute other than `start` and `value` (which may hold a large array).
    pub value_bytes: usize,
}

impl Default for XmlLimits {
    fn default() -> Self {
        XmlLimits {
            bytes: 128 << 20,
            elements: 4_000_000,
            depth: 64,
            attributes: 64,
            value_bytes: 1 << 20,
        }
    }
}

/// Bytes of a text that are kept, and texts of one document.
const TEXT: usize = 256;
const TEXTS: usize = 64;

/// An element, its attributes and its child elements; text between elements is dropped.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    /// Name, with its prefix if it has one.
    pub name: String,
    /// Attributes in the file's order, values unescaped.
    pub attributes: Vec<(String, String)>,
    /// Child elements.
    pub children: Vec<Element>,
    /// Line of the start tag, counted from 1.
    pub line: u32,
}

impl Element {
    /// The value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    /// The first child of this name.
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }
}

/// A document: its root element and the encoding it declares.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    /// The root element.
    pub root: Element,
    /// `encoding` of the XML declaration, if there is one.
    pub encoding: Option<String>,
    /// Which children of the root hold a text, and the text without blanks around it; of few and short
    /// ones, as FMI and SSP need none.
    pub texts: Vec<(usize, String)>,
}

/// Reads a document.
///
/// # Errors
/// If the bytes are too many, not UTF-8, not well-formed, hold a document type declaration or exceed
/// a limit.
pub fn parse(bytes: &[u8], limits: &XmlLimits) -> Result<Document, XmlError> {
    if bytes.len() > limits.bytes {
        return Err(XmlError::TooLarge { bytes: bytes.len(), limit: limits.bytes });
    }
    let text = decode(bytes)?;
    if let Some(at) = text.bytes().position(|byte| byte < b' ' && !b"\t\n\r".contains(&byte)) {
        let (before, rest) = text.split_at(at);
        let line = 1 + before.bytes().filter(|byte| *byte == b'\n').count() as u32;
        let code = rest.bytes().next().unwrap_or_default();
        let message = format!("the character U+{code:04X}, which no XML holds");
        return Err(XmlError::NotWellFormed { line, message });
    }
    Parser::new(&text, limits).run()
}

/// The text of a document; ISO-8859-1, though not allowed, is understood where it is declared.
fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, XmlError> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => Ok(Cow::Borrowed(text)),
        Err(_) if declares_latin1(bytes) => {
            Ok(Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()))
        }
        Err(error) => {
            let offset = error.valid_up_to();
            let before = bytes.get(..offset).unwrap_or_default();
            let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count() as u32;
            Err(XmlError::NotUtf8 { line, offset })
        }
    }
}

fn declares_latin1(bytes: &[u8]) -> bool {
    let head = String::from_utf8_lossy(bytes.get(..bytes.len().min(200)).unwrap_or_default());
    let declaration = head.split("?>").next().unwrap_or_default().to_ascii_lowercase();
    declaration.starts_with("<?xml") && declaration.contains("iso-8859-1")
}

struct Parser<'a> {
    text: &'a str,
    reader: Reader<&'a [u8]>,
    limits: &'a XmlLimits,
    /// Line of the byte at `counted`.
    line: u32,
    counted: usize,
    /// Number of elements so far.
    elements: usize,
    open: Vec<Element>,
    root: Option<Element>,
    encoding: Option<String>,
    texts: Vec<(usize, String)>,
}

impl<'a> Parser<'a> {
    fn new(text: &'a str, limits: &'a XmlLimits) -> Self {
        let reader = Reader::from_str(text);
        Parser {
            text,
            reader,
            limits,
            line: 1,
            counted: 0,
            elements: 0,
            open: Vec::new(),
            root: None,
            encoding: None,
            texts: Vec::new(),
        }
    }

    fn run(mut self) -> Result<Document, XmlError> {
        loop {
            self.count_lines_up_to(self.reader.buffer_position());
            let event = match self.reader.read_event() {
                Ok(event) => event,
                Err(error) => {
                    self.count_lines_up_to(self.reader.error_position());
                    return Err(self.not_well_formed(error));
                }
            };
            match event {
                Event::Start(tag) => {
                    let element = self.element(&tag)?;
                    self.open.push(element);
                }
                Event::Empty(tag) => {
                    let element = self.element(&tag)?;
                    self.close(element)?;
                }
                Event::End(_) => match self.open.pop() {
                    Some(element) => self.close(element)?,
                    None => return Err(self.not_well_formed("an end tag without a start tag")),
                },
                Event::DocType(_) => return Err(XmlError::DocumentType { line: self.line }),
                Event::Decl(declaration) => {
                    self.encoding =
                        declaration.encoding().and_then(Result::ok).map(Cow::into_owned);
                }
                Event::GeneralRef(reference) => self.check_reference(&reference)?,
                Event::Text(text) => self.text(&text.into_inner())?,
                Event::Eof => return self.finish(),
                Event::CData(_) | Event::Comment(_) | Event::PI(_) => {}
            }
        }
    }

    fn finish(mut self) -> Result<Document, XmlError> {
        if let Some(element) = self.open.pop() {
            let message = format!(
                "the file ends inside <{}>, which starts at line {}; it is cut off",
                element.name, element.line
            );
            return Err(self.not_well_formed(message));
        }
        match self.root.take() {
            Some(root) => Ok(Document { root, encoding: self.encoding, texts: self.texts }),
            None => Err(self.not_well_formed("there is no root element")),
        }
    }

    fn element(&mut self, tag: &BytesStart<'_>) -> Result<Element, XmlError> {
        self.elements += 1;
        if self.elements > self.limits.elements {
            return Err(self.limit("the number of elements", self.limits.elements));
        }
        if self.open.len() >= self.limits.depth {
            return Err(self.limit("the nesting of elements", self.limits.depth));
        }
        let mut attributes = Vec::new();
        for attribute in tag.attributes() {
            let attribute = attribute.map_err(|error| self.not_well_formed(error))?;
            if attributes.len() >= self.limits.attributes {
                return Err(self.limit("the number of attributes", self.limits.attributes));
            }
            let name = attribute.key.as_ref().to_owned();
            let may_be_long = name == "start" || name == "value";
            if attribute.value.len() > self.limits.value_bytes && !may_be_long {
                let what = format!("attribute \"{name}\" with {} bytes", attribute.value.len());
                return Err(self.limit(&what, self.limits.value_bytes));
            }
            let value = attribute
                .normalized_value(XmlVersion::Explicit1_0)
                .map_err(|error| self.not_well_formed(error))?;
            attributes.push((name, value.into_owned()));
        }
        let name = tag.name().as_ref().to_owned();
        Ok(Element { name, attributes, children: Vec::new(), line: self.line })
    }

    fn close(&mut self, element: Element) -> Result<(), XmlError> {
        match self.open.last_mut() {
            Some(parent) => parent.children.push(element),
            None if self.root.is_none() => self.root = Some(element),
            None => {
                let message = format!("a second root element <{}>", element.name);
                return Err(self.not_well_formed(message));
            }
        }
        Ok(())
    }

    /// Only the five predefined entities and character references exist without a DTD.
    fn check_reference(&self, reference: &str) -> Result<(), XmlError> {
        let predefined = ["lt", "gt", "amp", "apos", "quot"];
        if reference.starts_with('#') || predefined.contains(&reference) {
            return Ok(());
        }
        Err(self.not_well_formed(format!("the entity \"&{reference};\" is not defined")))
    }

    fn text(&mut self, text: &str) -> Result<(), XmlError> {
        let text = text.trim();
        match self.open.as_slice() {
            [] if !text.is_empty() => {
                return Err(self.not_well_formed("text outside the root element"));
            }
            [root, _] if !text.is_empty() && text.len() <= TEXT && self.texts.len() < TEXTS => {
                self.texts.push((root.children.len(), text.to_owned()));
            }
            _ => {}
        }
        Ok(())
    }

    fn count_lines_up_to(&mut self, position: u64) {
        let position = usize::try_from(position).unwrap_or(usize::MAX).min(self.text.len());
        let passed = self.text.as_bytes().get(self.counted..position).unwrap_or_default();
        self.line += passed.iter().filter(|&&byte| byte == b'\n').count() as u32;
        self.counted = self.counted.max(position);
    }

    fn not_well_formed(&self, message: impl ToString) -> XmlError {
        XmlError::NotWellFormed { line: self.line, message: message.to_string() }
    }

    fn limit(&self, what: &str, limit: usize) -> XmlError {
        XmlError::Limit { line: self.line, what: what.to_owned(), limit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Document, XmlError> {
        parse(text.as_bytes(), &XmlLimits::default())
    }

    #[test]
    fn keeps_lines_and_unescapes_values() {
        let text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- two\nlines -->\n<a>\n\n\
                    <b x='1 &lt; 2 &#x3bc;'/>\n<c\n y=\"2\"/></a>\n";
        let document = read(text).unwrap();
        assert_eq!(document.encoding.as_deref(), Some("UTF-8"));
        assert_eq!(document.root.line, 4);
        assert_eq!(document.root.children[0].line, 6);
        assert_eq!(document.root.children[0].attribute("x"), Some("1 < 2 μ"));
        assert_eq!(document.root.child("c").unwrap().line, 7);
    }

    #[test]
    fn refuses_entity_expansion() {
        let bomb = "<?xml version=\"1.0\"?>\n<!DOCTYPE a [<!ENTITY x \"ha\">\
                    <!ENTITY y \"&x;&x;&x;\">]>\n<a b=\"&y;\"/>";
        assert_eq!(read(bomb), Err(XmlError::DocumentType { line: 2 }));
        let undefined = read("<a>\n<b c=\"&y;\"/></a>");
        assert!(matches!(undefined, Err(XmlError::NotWellFormed { line: 2, .. })), "{undefined:?}");
    }

    #[test]
    fn refuses_what_is_cut_off_or_broken() {
        for text in
            ["", "<a>", "<a><b></a></b>", "<a/><b/>", "<a b=\"1\" b=\"2\"/>", "x<a/>", "<a b=1/>"]
        {
            assert!(read(text).is_err(), "{text:?} was read");
        }
    }

    #[test]
    fn names_the_line_of_bytes_that_are_not_utf8() {
        let error = parse(b"<a>\n\xff</a>", &XmlLimits::default()).unwrap_err();
        assert_eq!(error, XmlError::NotUtf8 { line: 2, offset: 4 });
    }

    #[test]
    fn reads_latin1_where_it_is_declared() {
        let text = b"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><a b=\"\xb5m\"/>";
        let document = parse(text, &XmlLimits::default()).unwrap();
        assert_eq!(document.root.attribute("b"), Some("µm"));
    }

    #[test]
    fn limits_nesting_names_and_size() {
        let few = XmlLimits { elements: 2, ..XmlLimits::default() };
        assert!(parse(b"<a><b/></a>", &few).is_ok());
        let third = parse(b"<a><b/>\n<c/></a>", &few);
        assert!(matches!(third, Err(XmlError::Limit { line: 2, limit: 2, .. })), "{third:?}");
        let deep = "<a>".repeat(65) + &"</a>".repeat(65);
        assert!(matches!(read(&deep), Err(XmlError::Limit { limit: 64, .. })));
        let long = format!("<a name=\"{}\"/>", "x".repeat(10 << 20));
        assert!(matches!(read(&long), Err(XmlError::Limit { limit: 1048576, .. })));
        let limits = XmlLimits { bytes: 3, ..XmlLimits::default() };
        assert_eq!(parse(b"<a/>", &limits), Err(XmlError::TooLarge { bytes: 4, limit: 3 }));
        let many: String = (0..65).map(|i| format!(" a{i}=''")).collect();
        assert!(matches!(read(&format!("<a{many}/>")), Err(XmlError::Limit { limit: 64, .. })));
    }
}
