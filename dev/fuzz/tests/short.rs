//! A short campaign for every reader, and all inputs that once broke one.
#![allow(clippy::print_stdout)]

use counting::Counting;
use piezoloop_fuzz::campaign;
use piezoloop_fuzz::{corpus, targets};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Inputs for each reader; `cargo run --release -p piezoloop-fuzz --bin fuzz` tries more.
const EXECUTIONS: u64 = 3000;

#[test]
fn no_reader_panics_hangs_or_takes_memory_without_bound() {
    let mut wrong = Vec::new();
    for target in &targets() {
        // What one reader has beside its file is none of the next one's.
        let folder = tempfile::tempdir().unwrap();
        let inputs = corpus(target).unwrap().len();
        assert!(inputs > 0, "{} has no inputs", target.name);
        match campaign::run(target, EXECUTIONS, 20_261, folder.path()).unwrap() {
            Ok(figures) => {
                println!("{}: {figures:?}", target.name);
                if target.name == "driver" && std::process::Command::new("cc").output().is_err() {
                    println!("SKIPPED: {}", piezoloop_fuzz::NO_COMPILER);
                    continue;
                }
                // The mutations reach the reader: it says many things.
                assert!(figures.behaviours > 10, "{}: {figures:?}", target.name);
            }
            Err(finding) => {
                let path = std::env::temp_dir().join(format!("{}.finding", target.name));
                std::fs::write(&path, &finding.input).unwrap();
                wrong.push(format!("{}: {} {}", target.name, path.display(), finding.what));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
