//! Where the FMU's resources lie: where the importer says, else beside this library.

#[cfg(any(all(unix, not(target_os = "linux")), windows))]
use std::ffi::c_void;
use std::path::{Path, PathBuf};

use percent_encoding::percent_decode;

/// What the importer gives.
#[derive(Clone, Copy, Debug)]
pub(super) enum Location<'a> {
    /// Nothing.
    None,
    /// A URI (FMI 2.0).
    Uri(&'a [u8]),
    /// A path (FMI 3.0), or the URI that early versions of that standard asked for.
    Path(&'a [u8]),
}

/// The folder that holds the file `marker`: the first of those that the importer may have meant,
/// else `../../resources` from the folder of this library (`binaries/<platform>/`).
pub(super) fn find(location: Location<'_>, marker: &str) -> Result<PathBuf, String> {
    // A model inside WebAssembly has its blueprint compiled in.
    if cfg!(feature = "component") {
        return Ok(PathBuf::from("the component"));
    }
    if cfg!(target_family = "wasm") {
        return Ok(PathBuf::from("sources"));
    }
    let mut remark = String::new();
    let mut folders = match given(location) {
        Ok(folders) => folders,
        Err(message) => {
            remark = format!(" ({message})");
            Vec::new()
        }
    };
    folders.extend(library().as_deref().and_then(beside));
    if let Some(at) = folders.iter().position(|folder| folder.join(marker).is_file()) {
        return Ok(folders.swap_remove(at));
    }
    let tried: Vec<_> = folders.iter().map(|f| f.display().to_string()).collect();
    Err(format!(
        "no {marker} in the FMU's resources; looked in: {}{remark}. Unpack the whole FMU and give \
         the folder `resources` in it",
        if tried.is_empty() { "no folder".to_string() } else { tried.join(", ") },
    ))
}

/// The folders that the importer may have meant, the likeliest first.
fn given(location: Location<'_>) -> Result<Vec<PathBuf>, String> {
    match location {
        Location::None | Location::Uri(b"") | Location::Path(b"") => Ok(Vec::new()),
        Location::Uri(uri) => folders_of_uri(uri),
        Location::Path(path) if is_file_uri(path) => folders_of_uri(path),
        Location::Path(path) => Ok(vec![native(path)]),
    }
}

/// A `file` URI in any of its spellings (RFC 8089): `file:/p`, `file:///p`, `file://localhost/p`,
/// and the `file:////p` of several importers. A plain absolute path is understood too. Some
/// importers do not percent-encode, so that the path as it stands comes second.
fn folders_of_uri(uri: &[u8]) -> Result<Vec<PathBuf>, String> {
    let path = match uri {
        _ if is_file_uri(uri) => without_authority(&uri[5..])?,
        _ if is_plain_path(uri) => uri,
        _ => {
            return Err(format!(
                "\"{}\" is no file URI, which is the only kind that is understood here",
                String::from_utf8_lossy(uri)
            ));
        }
    };
    let decoded: Vec<u8> = percent_decode(path).collect();
    let mut folders = vec![native(&decoded)];
    if decoded != path {
        folders.push(native(path));
    }
    Ok(folders)
}

fn is_file_uri(text: &[u8]) -> bool {
    text.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case(b"file:"))
}

fn is_plain_path(text: &[u8]) -> bool {
    let drive = cfg!(windows) && text.get(1) == Some(&b':');
    text.starts_with(b"/") || drive
}

/// The path behind `file:`.
fn without_authority(rest: &[u8]) -> Result<&[u8], String> {
    let Some(behind) = rest.strip_prefix(b"//") else { return Ok(rest) };
    let end = behind.iter().position(|b| *b == b'/').unwrap_or(behind.len());
    let (authority, path) = behind.split_at(end);
    if authority.is_empty() || authority.eq_ignore_ascii_case(b"localhost") {
        return Ok(path);
    }
    // `file://C:/…` and `file://server/share`: wrong or not absolute elsewhere, usual on Windows.
    if cfg!(windows) {
        let drive = authority.len() == 2 && authority[1] == b':';
        return Ok(if drive { behind } else { rest });
    }
    Err(format!(
        "\"{}\" is another machine's file; give a path on this one",
        String::from_utf8_lossy(authority)
    ))
}

#[cfg(unix)]
fn native(path: &[u8]) -> PathBuf {
    use std::os::unix::ffi::OsStrExt;
    let slashes = path.iter().take_while(|b| **b == b'/').count();
    // `//home` may mean something else than `/home` (POSIX §4.13); importers mean the same.
    PathBuf::from(std::ffi::OsStr::from_bytes(&path[slashes.saturating_sub(1)..]))
}

#[cfg(not(any(unix, windows)))]
fn native(path: &[u8]) -> PathBuf {
    PathBuf::from(&*String::from_utf8_lossy(path))
}

#[cfg(windows)]
fn native(path: &[u8]) -> PathBuf {
    let text = String::from_utf8_lossy(path);
    let local = text.trim_start_matches('/');
    let drive = local.as_bytes().get(1).is_some_and(|b| matches!(b, b':' | b'|'));
    let text = if drive { local.replacen('|', ":", 1) } else { text.into_owned() };
    PathBuf::from(text.replace('/', "\\"))
}

/// `resources` of the FMU whose `binaries/<platform>/` holds this library.
fn beside(library: &Path) -> Option<PathBuf> {
    Some(library.parent()?.parent()?.parent()?.join("resources"))
}

/// The file of the library that this code is in.
#[cfg(unix)]
fn library() -> Option<PathBuf> {
    use std::ffi::{CStr, OsStr};
    use std::os::unix::ffi::OsStrExt;

    let name = name_of(library as fn() -> Option<PathBuf> as usize)?;
    // SAFETY: the name ends with a zero, and lives as long as the library is loaded.
    let name = unsafe { CStr::from_ptr(name.as_ptr()) };
    if name.is_empty() {
        // The program itself, which the loader keeps without a name.
        return std::env::current_exe().ok();
    }
    // It is as the host gave it to dlopen; lexically absolute, since a link to the library is
    // meant to stand for an FMU of its own.
    std::path::absolute(OsStr::from_bytes(name.to_bytes())).ok()
}

/// The name of the loaded object that has this address, as the loader keeps it.
///
/// glibc's `dladdr` would do, but since glibc 2.34 it is linked by a version that older ones do not have.
#[cfg(target_os = "linux")]
fn name_of(address: usize) -> Option<std::ptr::NonNull<std::ffi::c_char>> {
    use std::ffi::{c_char, c_int};
    use std::ptr::NonNull;

    const LOADED: u32 = 1;

    /// `ElfN_Phdr` of `elf.h`.
    #[repr(C)]
    struct Segment {
        kind: u32,
        #[cfg(target_pointer_width = "64")]
        _flags: u32,
        _offset: usize,
        address: usize,
        _physical: usize,
        _size_in_file: usize,
        size: usize,
        #[cfg(target_pointer_width = "32")]
        _flags: u32,
        _align: usize,
    }

    /// The beginning of `dl_phdr_info` of `link.h`.
    #[repr(C)]
    struct Object {
        base: usize,
        name: *const c_char,
        segments: *const Segment,
        count: u16,
    }

    /// Address, name of the object that has it.
    #[repr(C)]
    struct Search {
        address: usize,
        name: *const c_char,
    }

    unsafe extern "C" {
        fn dl_iterate_phdr(
            each: unsafe extern "C" fn(*const Object, usize, *mut Search) -> c_int,
            data: *mut Search,
        ) -> c_int;
    }

    unsafe extern "C" fn each(object: *const Object, _: usize, search: *mut Search) -> c_int {
        // SAFETY: the loader gives an object with its segments, and the search that it was given.
        let (object, search) = unsafe { (&*object, &mut *search) };
        for k in 0..usize::from(object.count) {
            // SAFETY: there are as many segments as are counted.
            let segment = unsafe { &*object.segments.add(k) };
            let begin = object.base.wrapping_add(segment.address);
            if segment.kind == LOADED && search.address.wrapping_sub(begin) < segment.size {
                search.name = object.name;
                return 1;
            }
        }
        0
    }

    let mut search = Search { address, name: std::ptr::null() };
    // SAFETY: the search lives during the call.
    unsafe { dl_iterate_phdr(each, &raw mut search) };
    NonNull::new(search.name.cast_mut())
}

/// The name of the loaded object that has this address, as the loader keeps it.
#[cfg(all(unix, not(target_os = "linux")))]
fn name_of(address: usize) -> Option<std::ptr::NonNull<std::ffi::c_char>> {
    use std::ffi::{c_char, c_int};

    /// `Dl_info` of `dlfcn.h`.
    #[repr(C)]
    struct DlInfo {
        file_name: *const c_char,
        file_base: *mut c_void,
        symbol_name: *const c_char,
        symbol_address: *mut c_void,
    }
    unsafe extern "C" {
        fn dladdr(address: *const c_void, info: *mut DlInfo) -> c_int;
    }

    let mut info = std::mem::MaybeUninit::<DlInfo>::uninit();
    // SAFETY: the address is one of a loaded object; the structure is filled where the result is not zero.
    unsafe {
        if dladdr(address as *const c_void, info.as_mut_ptr()) == 0 {
            return None;
        }
        std::ptr::NonNull::new(info.assume_init().file_name.cast_mut())
    }
}

/// The file of the library that this code is in.
#[cfg(windows)]
fn library() -> Option<PathBuf> {
    use std::ffi::OsString;
    use std::os::windows::ffi::OsStringExt;

    const FROM_ADDRESS: u32 = 4;
    const UNCHANGED_REFERENCE_COUNT: u32 = 2;
    #[link(name = "kernel32")]
    unsafe extern "system" {
        fn GetModuleHandleExW(flags: u32, name: *const c_void, module: *mut *mut c_void) -> i32;
        fn GetModuleFileNameW(module: *mut c_void, name: *mut u16, size: u32) -> u32;
    }

    let mut module = std::ptr::null_mut();
    // The longest path that Windows knows.
    let mut name = vec![0_u16; 32_768];
    // SAFETY: the address is one of this library's; the buffer has the length that is given.
    let length = unsafe {
        let address = library as fn() -> Option<PathBuf> as *const c_void;
        let flags = FROM_ADDRESS | UNCHANGED_REFERENCE_COUNT;
        if GetModuleHandleExW(flags, address, &raw mut module) == 0 {
            return None;
        }
        GetModuleFileNameW(module, name.as_mut_ptr(), name.len() as u32) as usize
    };
    (0 < length && length < name.len()).then(|| OsString::from_wide(&name[..length]).into())
}

/// There is no file.
#[cfg(not(any(unix, windows)))]
fn library() -> Option<PathBuf> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn first(uri: &str) -> String {
        folders_of_uri(uri.as_bytes()).unwrap()[0].display().to_string()
    }

    #[test]
    fn every_spelling_of_a_file_uri_is_understood() {
        for uri in [
            "file:///tmp/dir%20%C3%A9/resources",
            "file:/tmp/dir%20%C3%A9/resources",
            "file:////tmp/dir%20%C3%A9/resources",
            "file://localhost/tmp/dir%20%C3%A9/resources",
            "FILE:///tmp/dir%20é/resources",
            "/tmp/dir%20%c3%a9/resources",
        ] {
            assert_eq!(first(uri), "/tmp/dir é/resources", "{uri}");
        }
        assert_eq!(first("file:///tmp/resources/"), "/tmp/resources/");
    }

    #[test]
    fn a_path_is_taken_as_it_stands() {
        let first = |path: &[u8]| given(Location::Path(path)).unwrap().remove(0);
        assert_eq!(first("/tmp/a%20é/resources/".as_bytes()), Path::new("/tmp/a%20é/resources"));
        assert_eq!(first(b"file:///tmp/a%20b"), Path::new("/tmp/a b"));
    }

    #[test]
    fn an_unencoded_percent_sign_is_tried_second() {
        let folders = folders_of_uri(b"file:///tmp/100%25 a%20b").unwrap();
        assert_eq!(folders[0], Path::new("/tmp/100% a b"));
        assert_eq!(folders[1], Path::new("/tmp/100%25 a%20b"));
    }

    #[test]
    fn other_schemes_and_other_machines_are_named() {
        let error = find(Location::Uri(b"http://example.org/resources"), "none.toml").unwrap_err();
        assert!(error.contains("http://example.org/resources"), "{error}");
        let error = find(Location::Uri(b"file://server/share"), "none.toml").unwrap_err();
        assert!(error.contains("another machine"), "{error}");
    }

    #[test]
    fn without_a_location_the_folder_is_found_from_the_library() {
        let file = library().unwrap();
        assert_eq!(file, std::env::current_exe().unwrap());
        let resources = beside(Path::new("/fmu/binaries/linux64/plant.so")).unwrap();
        assert_eq!(resources, Path::new("/fmu/resources"));
        let error = find(Location::None, "none.toml").unwrap_err();
        assert!(error.contains("none.toml") && error.contains("resources"), "{error}");
    }
}
