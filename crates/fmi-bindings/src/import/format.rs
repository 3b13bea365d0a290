//! `printf` for the messages of FMI 2.0 FMUs, whose text is a format and whose values are variadic.
//!
//! Each conversion is handed to C's `snprintf` with its one value, so that the result is C's.
//! Nothing an FMU writes can crash this: strings are read through the kernel, which refuses a bad
//! address; whatever cannot be formatted leaves the text as it stands.

use std::borrow::Cow;
use std::ffi::{CStr, CString, c_char, c_double, c_int, c_long, c_void};

/// Values that fit into the message of an FMU; more leave its text as it stands.
pub(super) const WORDS: usize = 9;
/// Floating point values that travel in registers.
pub(super) const DOUBLES: usize = 8;
/// Longest text of one `%s`.
const LONGEST: usize = 4096;

/// The variadic arguments, apart by the way they travel: integers and pointers in order, floating
/// point values in order. Those that the caller did not give hold anything.
pub(super) struct Arguments {
    pub(super) words: [usize; WORDS],
    pub(super) doubles: [f64; DOUBLES],
}

/// The text with its conversions carried out, or as it stands if one cannot be.
pub(super) fn formatted(text: &CStr, arguments: &Arguments) -> String {
    let bytes = text.to_bytes();
    let mut values = Values { arguments, word: 0, double: 0 };
    let formatted = values.format(bytes);
    String::from_utf8_lossy(formatted.as_deref().unwrap_or(bytes)).into_owned()
}

/// Takes arguments one after the other.
struct Values<'a> {
    arguments: &'a Arguments,
    word: usize,
    double: usize,
}

/// One conversion: `%[flags][width][.precision][length]kind`.
struct Conversion {
    /// Everything before the length, with a width or precision of `*` filled in.
    head: String,
    length: Vec<u8>,
    kind: u8,
}

impl Values<'_> {
    fn format(&mut self, mut rest: &[u8]) -> Option<Vec<u8>> {
        let mut out = Vec::with_capacity(rest.len());
        while let Some(percent) = rest.iter().position(|byte| *byte == b'%') {
            out.extend_from_slice(&rest[..percent]);
            rest = &rest[percent + 1..];
            if let Some(after) = rest.strip_prefix(b"%") {
                out.push(b'%');
                rest = after;
                continue;
            }
            let conversion = self.parse(&mut rest)?;
            out.extend_from_slice(&self.convert(&conversion)?);
        }
        out.extend_from_slice(rest);
        Some(out)
    }

    fn parse(&mut self, rest: &mut &[u8]) -> Option<Conversion> {
        let mut head = "%".to_owned();
        let mut next = || {
            let (first, after) = rest.split_first()?;
            *rest = after;
            Some(*first)
        };
        let mut byte = next()?;
        // The flag "space" is left out: "50 % of it" is more likely a text than a format.
        while b"-+#0123456789.*".contains(&byte) {
            match byte {
                b'*' => head += &self.take_word()?.cast_signed().to_string(),
                _ => head.push(byte.into()),
            }
            byte = next()?;
        }
        let mut length = Vec::new();
        while b"hlqjzt".contains(&byte) {
            length.push(byte);
            byte = next()?;
        }
        // A width of thousands is no width but a text that is no format.
        (head.len() < 12).then_some(Conversion { head, length, kind: byte })
    }

    fn convert(&mut self, conversion: &Conversion) -> Option<Vec<u8>> {
        let Conversion { head, length, kind } = conversion;
        let kind = char::from(*kind);
        match kind {
            'd' | 'i' | 'u' | 'x' | 'X' | 'o' | 'c' => {
                let word = self.take_word()?;
                let (long, short) = (word.cast_signed() as c_long, word as c_int);
                match length.as_slice() {
                    [] | [b'h'] | [b'h', b'h'] => {
                        let length = String::from_utf8_lossy(length);
                        print(&format!("{head}{length}{kind}"), Value::Int(short))
                    }
                    _ => print(&format!("{head}l{kind}"), Value::Long(long)),
                }
            }
            'e' | 'E' | 'f' | 'F' | 'g' | 'G' | 'a' | 'A'
                if length.is_empty() || length == b"l" =>
            {
                let double = *self.arguments.doubles.get(self.double)?;
                self.double += 1;
                print(&format!("{head}{kind}"), Value::Double(double))
            }
            's' if length.is_empty() => {
                let text = string_at(self.take_word()?)?;
                print(&format!("{head}s"), Value::Pointer(text.as_ptr().cast()))
            }
            'p' => {
                let pointer = self.take_word()? as *const c_void;
                print(&format!("{head}p"), Value::Pointer(pointer))
            }
            _ => None,
        }
    }

    fn take_word(&mut self) -> Option<usize> {
        let word = *self.arguments.words.get(self.word)?;
        self.word += 1;
        Some(word)
    }
}

/// One value on its way to `snprintf`.
enum Value {
    Int(c_int),
    Long(c_long),
    Double(c_double),
    Pointer(*const c_void),
}

unsafe extern "C" {
    fn snprintf(buffer: *mut c_char, size: usize, format: *const c_char, ...) -> c_int;
}

/// One conversion by C; the type of the value is that of the conversion.
fn print(format: &str, value: Value) -> Option<Vec<u8>> {
    let format = CString::new(format).ok()?;
    let mut buffer = vec![0_u8; LONGEST + 1];
    let (place, size, format) = (buffer.as_mut_ptr().cast(), buffer.len(), format.as_ptr());
    // SAFETY: the buffer has the size given; the format holds one conversion, and the value is of
    // its type, a text's being zero-terminated and alive.
    let length = unsafe {
        match value {
            Value::Int(value) => snprintf(place, size, format, value),
            Value::Long(value) => snprintf(place, size, format, value),
            Value::Double(value) => snprintf(place, size, format, value),
            Value::Pointer(value) => snprintf(place, size, format, value),
        }
    };
    buffer.truncate(usize::try_from(length).ok()?.min(LONGEST));
    Some(buffer)
}

/// The text at an address, as far as it is readable; `None` if the address is not.
pub(super) fn string_at(address: usize) -> Option<Cow<'static, CStr>> {
    if address == 0 {
        return Some(Cow::Borrowed(c"(null)"));
    }
    let mut text = Vec::new();
    while text.len() < LONGEST {
        let mut page = [0_u8; 256];
        let from = address.checked_add(text.len())?;
        // Not beyond the end of a page, which may be the end of what is readable.
        let wanted = page.len().min(page_size() - from % page_size());
        let read = read_memory(from, &mut page[..wanted])?;
        match page[..read].iter().position(|byte| *byte == 0) {
            Some(end) => {
                text.extend_from_slice(&page[..end]);
                break;
            }
            None => text.extend_from_slice(&page[..read]),
        }
    }
    CString::new(text).ok().map(Cow::Owned)
}

/// The smallest page of any machine: a smaller step than needed is harmless.
const fn page_size() -> usize {
    4096
}

/// C's `struct iovec`.
#[repr(C)]
struct Span {
    base: *mut c_void,
    length: usize,
}

unsafe extern "C" {
    fn getpid() -> c_int;
    fn process_vm_readv(
        process: c_int,
        local: *const Span,
        locals: std::ffi::c_ulong,
        remote: *const Span,
        remotes: std::ffi::c_ulong,
        flags: std::ffi::c_ulong,
    ) -> isize;
}

/// Copies memory of this process through the kernel, which refuses what is not readable.
fn read_memory(address: usize, into: &mut [u8]) -> Option<usize> {
    let local = Span { base: into.as_mut_ptr().cast(), length: into.len() };
    let remote = Span { base: address as *mut c_void, length: into.len() };
    // SAFETY: the kernel writes at most the length of `into`, and checks the address it reads.
    let read = unsafe { process_vm_readv(getpid(), &raw const local, 1, &raw const remote, 1, 0) };
    usize::try_from(read).ok().filter(|read| *read > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(text: &CStr, words: &[usize], doubles: &[f64]) -> String {
        let mut arguments = Arguments { words: [1; WORDS], doubles: [0.0; DOUBLES] };
        arguments.words[..words.len()].copy_from_slice(words);
        arguments.doubles[..doubles.len()].copy_from_slice(doubles);
        formatted(text, &arguments)
    }

    #[test]
    fn conversions_are_those_of_c() {
        let name = c"axis[1]".as_ptr() as usize;
        assert_eq!(
            with(c"%s: %d of %5.2f, %lu%%", &[name, -3_isize as usize, 123_456_789_012], &[2.5]),
            "axis[1]: -3 of  2.50, 123456789012%"
        );
        assert_eq!(with(c"%-4c|%x %e", &['c' as usize, 255], &[1e-3]), "c   |ff 1.000000e-03");
        assert_eq!(with(c"%.*f %s", &[3, 0], &[1.0 / 3.0]), "0.333 (null)");
        assert_eq!(with(c"%zu %lld %hhd", &[7, usize::MAX, 257], &[]), "7 -1 1");
    }

    #[test]
    fn what_is_no_format_is_left_as_it_stands() {
        for text in
            [c"100% too large", c"at 5 % s of it", c"ends with %", c"%Lf", c"%n", c"% 99999999d"]
        {
            assert_eq!(with(text, &[1], &[]), text.to_str().unwrap());
        }
        let many = CString::new("%d ".repeat(WORDS + 1)).unwrap();
        assert_eq!(with(&many, &[], &[]), many.to_str().unwrap());
    }

    #[test]
    fn a_long_string_is_cut() {
        let long = CString::new("x".repeat(3 * LONGEST)).unwrap();
        assert_eq!(with(c"%s", &[long.as_ptr() as usize], &[]).len(), LONGEST);
    }
}
