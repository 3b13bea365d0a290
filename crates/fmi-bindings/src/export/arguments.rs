//! C arguments as slices: null pointers and lengths are checked once, here.

use std::ffi::{CStr, c_char};

use super::notice::Notice;

/// Whether `count` values may lie behind `pointer`.
#[inline(always)]
fn check<T>(pointer: *const T, count: usize, what: &str) -> Result<(), Notice> {
    let is_possible = count <= isize::MAX as usize / size_of::<T>().max(1);
    if pointer.is_null() || !pointer.is_aligned() || !is_possible {
        return Err(impossible(pointer.is_null(), is_possible, count, what));
    }
    Ok(())
}

#[cold]
#[inline(never)]
fn impossible(is_null: bool, is_possible: bool, count: usize, what: &str) -> Notice {
    let problem = match (is_null, is_possible) {
        (true, _) => "is a null pointer",
        (_, true) => "is not aligned for its type",
        (_, false) => "cannot be that long",
    };
    Notice::error(format!("{what} {problem}; give an array of {count}"))
}

/// The array of the importer; without elements the pointer does not matter.
///
/// # Safety
/// `pointer` is null or points to `count` initialised values that nobody changes meanwhile.
#[inline]
pub(super) unsafe fn array<'a, T>(
    pointer: *const T,
    count: usize,
    what: &str,
) -> Result<&'a [T], Notice> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer, count, what)?;
    // SAFETY: not null, aligned, not too long; the caller promises the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Room of the importer for results. It need not be initialised, so that it is only written.
pub(super) struct Room<T>(*mut T);

impl<T> Room<T> {
    /// Room for `count` values; without any the pointer does not matter.
    ///
    /// # Safety
    /// `pointer` is null or may be written as an array of `count` values until the call ends.
    #[inline]
    pub(super) unsafe fn new(pointer: *mut T, count: usize, what: &str) -> Result<Self, Notice> {
        if count > 0 {
            check(pointer.cast_const(), count, what)?;
        }
        Ok(Self(pointer))
    }

    /// Writes the value at a position.
    ///
    /// # Safety
    /// `at` is less than the count that was given.
    #[inline]
    pub(super) unsafe fn write(&self, at: usize, value: T) {
        // SAFETY: inside the room, as the caller promises.
        unsafe { self.0.add(at).write(value) }
    }
}

/// The text of the importer, `None` for a null pointer.
///
/// # Safety
/// `pointer` is null or a text that ends with a zero byte and is not changed meanwhile.
pub(super) unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: as the caller promises.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// The texts of the importer.
///
/// # Safety
/// `pointer` is null or points to `count` texts that end with a zero byte; nobody changes them meanwhile.
pub(super) unsafe fn texts<'a>(
    pointer: *const *const c_char,
    count: usize,
    what: &str,
) -> Result<Vec<&'a CStr>, Notice> {
    // SAFETY: as the caller promises.
    let pointers = unsafe { array(pointer, count, what)? };
    // SAFETY: as the caller promises.
    let all: Option<Vec<_>> = pointers.iter().map(|pointer| unsafe { text(*pointer) }).collect();
    all.ok_or_else(|| Notice::error(format!("{what} holds a null pointer; give texts")))
}
