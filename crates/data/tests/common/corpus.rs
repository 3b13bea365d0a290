//! The inputs that the fuzzer starts from, `dev/fuzz/corpus`, where a test makes them.

use std::fs;
use std::path::Path;

/// The corpus of this format has this file with these bytes. With `PIEZOLOOP_WRITE_CORPUS=1` it is written.
pub(crate) fn hold(format: &str, name: &str, content: &[u8]) {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../dev/fuzz/corpus");
    let file = corpus.join(format!("log-{format}")).join(name);
    if std::env::var_os("PIEZOLOOP_WRITE_CORPUS").is_some() {
        fs::create_dir_all(file.parent().expect("a folder")).expect("the folder can be made");
        fs::write(&file, content).expect("the file can be written");
    }
    let written = fs::read(&file).unwrap_or_default();
    assert!(written == content, "{}: PIEZOLOOP_WRITE_CORPUS=1 writes it", file.display());
}
