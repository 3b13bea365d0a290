//! `fuzz`: mutated inputs for one reader or all of them, and the figures.
#![allow(clippy::print_stdout)]

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use counting::Counting;
use piezoloop_fuzz::{Target, campaign};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Reads mutated files with the project's readers; the first that panics, hangs or takes memory
/// without bound is written to `fuzz/findings`.
#[derive(Parser)]
struct Arguments {
    /// The reader; without it, all one after the other
    #[arg(long)]
    target: Option<String>,
    /// Inputs that are read, for each reader
    #[arg(long, default_value_t = 100_000)]
    executions: u64,
    /// Seed of the mutations
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let targets: Vec<Target> = match &arguments.target {
        None => piezoloop_fuzz::targets(),
        Some(name) => Target::find(name).into_iter().collect(),
    };
    if targets.is_empty() {
        let known = piezoloop_fuzz::targets();
        let names: Vec<&str> = known.iter().map(|target| &*target.name).collect();
        println!("there is no such reader; there are {}", names.join(", "));
        return ExitCode::from(2);
    }
    // Readers by others may panic inside ours, which answers with an error.
    std::panic::set_hook(Box::new(|_| {}));
    counting::set_limit(4 << 30);
    let folder = folder();
    let mut good = true;
    for target in targets {
        match campaign::run(&target, arguments.executions, arguments.seed, &folder) {
            Ok(Ok(figures)) => {
                let per_second = figures.executions as f64 / figures.time.as_secs_f64();
                println!(
                    "{}: {} executions in {:.0} s ({per_second:.0} per s), {} accepted, {} \
                     behaviours, at most {} kB and {:.0} ms, seed {}",
                    target.name,
                    figures.executions,
                    figures.time.as_secs_f64(),
                    figures.accepted,
                    figures.behaviours,
                    figures.most_bytes / 1000,
                    figures.longest.as_secs_f64() * 1e3,
                    arguments.seed
                );
            }
            Ok(Err(finding)) => {
                good = false;
                let place = keep(&target, &finding.input);
                println!("{}: {} {}", target.name, place.display(), finding.what);
            }
            Err(error) => {
                good = false;
                println!("{}: {error}", target.name);
            }
        }
    }
    drop(std::fs::remove_dir_all(folder));
    ExitCode::from(u8::from(!good))
}

/// A folder in memory where there is one, so that a disk is not worn out.
fn folder() -> PathBuf {
    let memory = Path::new("/dev/shm");
    let parent = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    let folder = parent.join(format!("piezoloop-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the inputs");
    // Archives are unpacked there too.
    tempfile::env::override_temp_dir(&folder).ok();
    folder
}

fn keep(target: &Target, input: &[u8]) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("findings");
    let path = folder.join(format!("{}-{:08x}", target.name, crc32fast::hash(input)));
    std::fs::create_dir_all(&folder).expect("the folder of findings");
    std::fs::write(&path, input).expect("the finding is kept");
    path
}
