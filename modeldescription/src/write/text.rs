//! Indented XML text.

use super::WriteError;

/// XML under construction; the first defect is reported by [`Text::finish`].
pub(super) struct Text {
    text: String,
    /// Names of the open elements; whether the innermost start tag is still open.
    open: Vec<&'static str>,
    in_tag: bool,
    error: Option<WriteError>,
}

impl Text {
    pub(super) fn new() -> Self {
        let text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned();
        Text { text, open: Vec::new(), in_tag: false, error: None }
    }

    /// Starts an element.
    pub(super) fn open(&mut self, name: &'static str) {
        if self.in_tag {
            self.text.push_str(">\n");
        }
        self.indent();
        self.text.push('<');
        self.text.push_str(name);
        self.open.push(name);
        self.in_tag = true;
    }

    /// Ends the innermost element.
    pub(super) fn close(&mut self) {
        let Some(name) = self.open.pop() else { return };
        if self.in_tag {
            self.text.push_str("/>\n");
        } else {
            self.indent();
            self.text.push_str("</");
            self.text.push_str(name);
            self.text.push_str(">\n");
        }
        self.in_tag = false;
    }

    fn indent(&mut self) {
        for _ in 0..self.open.len() {
            self.text.push_str("  ");
        }
    }

    /// An attribute of the element that was opened last.
    pub(super) fn attribute(&mut self, name: &str, value: &str) {
        self.text.push(' ');
        self.text.push_str(name);
        self.text.push_str("=\"");
        for character in value.chars() {
            self.push_escaped(name, character);
        }
        self.text.push('"');
    }

    fn push_escaped(&mut self, attribute: &str, character: char) {
        match character {
            '&' => self.text.push_str("&amp;"),
            '<' => self.text.push_str("&lt;"),
            '>' => self.text.push_str("&gt;"),
            '"' => self.text.push_str("&quot;"),
            // Written as they are, they would be read back as spaces.
            '\t' => self.text.push_str("&#9;"),
            '\n' => self.text.push_str("&#10;"),
            '\r' => self.text.push_str("&#13;"),
            '\u{0}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => {
                let element = format!("<{}>", self.open.last().copied().unwrap_or_default());
                self.error.get_or_insert(WriteError::Character {
                    element,
                    attribute: attribute.to_owned(),
                    character: character.into(),
                });
            }
            _ => self.text.push(character),
        }
    }

    pub(super) fn optional(&mut self, name: &str, value: Option<&str>) {
        if let Some(value) = value {
            self.attribute(name, value);
        }
    }

    pub(super) fn optional_display<T: ToString>(&mut self, name: &str, value: Option<T>) {
        if let Some(value) = value {
            self.attribute(name, &value.to_string());
        }
    }

    pub(super) fn optional_float(&mut self, name: &str, value: Option<f64>) {
        if let Some(value) = value {
            self.attribute(name, &float(value));
        }
    }

    /// A flag whose default is false.
    pub(super) fn flag(&mut self, name: &str, value: bool) {
        if value {
            self.attribute(name, "true");
        }
    }

    pub(super) fn finish(self) -> Result<String, WriteError> {
        match self.error {
            Some(error) => Err(error),
            None => Ok(self.text),
        }
    }
}

/// `xs:double` that reads back as the same value.
pub(super) fn float(value: f64) -> String {
    if value.is_nan() {
        "NaN".to_owned()
    } else if value.is_infinite() {
        if value > 0.0 { "INF".to_owned() } else { "-INF".to_owned() }
    } else {
        format!("{value:?}")
    }
}

pub(super) fn integers<T: ToString>(values: &[T]) -> String {
    values.iter().map(T::to_string).collect::<Vec<_>>().join(" ")
}
