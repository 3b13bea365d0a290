//! `piezoloop bench run --record` killed at its writes: the record is whole, or the journal has every row that
//! was written.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use common::bench::{machine, port, stage};
use common::{at_once, piezoloop};
use data::{Log, ReadOptions};

/// The calls by which a file changes; each thread counts its own. By the second kind only the end of the
/// run writes, not the thread with the journal's rows.
const WRITES: [&str; 2] = ["write,pwrite64", "fsync,rename,renameat,renameat2,unlink,unlinkat"];
/// f64 of each row of one axis.
const COLUMNS: usize = 18;
/// Bytes in front of the first row, at most.
const LONGEST_HEAD: usize = 6000;

/// A run that is killed at this call of those.
fn killed_at(writes: &str, count: u32, record: &str, port: u16, folder: &Path) -> Output {
    let inject = format!("inject={writes}:signal=SIGKILL:when={count}");
    let gateway = format!("udp://127.0.0.1:{port}");
    Command::new("strace")
        .args(["-f", "-o", "/dev/null", "-e", &format!("trace={writes}"), "-e", &inject])
        .arg(env!("CARGO_BIN_EXE_piezoloop"))
        .args(["bench", "run", "--plan", "plan.toml", "--gateway", &gateway, "--record", record])
        .current_dir(folder)
        .output()
        .expect("strace starts")
}

/// The rows of a log, which must be whole.
fn rows(path: &Path) -> usize {
    let log = Log::read(path, &ReadOptions::default()).expect("a whole record");
    assert!(log.time().windows(2).all(|pair| pair[0] < pair[1]));
    log.len()
}

/// What is left: `None` where there was no row yet, else the rows that are there or come back.
fn left(folder: &Path, record: &str) -> Option<usize> {
    let (file, journal) = (folder.join(record), folder.join(format!("{record}.journal")));
    let complete = file.is_file().then(|| rows(&file));
    let Ok(journal_bytes) = fs::metadata(&journal).map(|found| found.len() as usize) else {
        return complete;
    };
    let name = format!("{record}.journal");
    let recover = ["bench", "recover", &name, "-o", "recovered.csv"];
    // A head, and not as much as a block of one row behind it.
    let output = piezoloop(&recover, folder);
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(journal_bytes < 8 * COLUMNS + LONGEST_HEAD, "{journal_bytes} bytes: {message}");
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("delete it"), "{message}");
        assert_eq!(complete, None);
        return None;
    }
    let found = rows(&folder.join("recovered.csv"));
    // Nothing that the system took is lost.
    let written = journal_bytes.saturating_sub(LONGEST_HEAD) / (8 * COLUMNS);
    assert!(found >= written, "{found} rows of {journal_bytes} bytes");
    if let Some(complete) = complete {
        assert_eq!(complete, found, "the record and its journal");
    }
    Some(found)
}

#[test]
fn a_record_is_complete_or_comes_back_from_its_journal() {
    let traced = Command::new("strace").args(["-o", "/dev/null", "true"]).output();
    if !traced.is_ok_and(|output| output.status.success()) {
        println!("SKIPPED: no strace, or no process may be traced here");
        return;
    }
    let thorough = std::env::var_os("PIEZOLOOP_KILLS").is_some();
    let (killed, recovered) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let records = ["run.csv", "run.parquet", "run.mf4"];
    let cases: Vec<_> = WRITES.iter().flat_map(|w| records.map(|record| (w, record))).collect();
    at_once(&cases, |(writes, record)| {
        let (folder, port) = (stage(1.0), port());
        let _machine = machine(port, &["--timing", "commands"], folder.path());
        let mut count = 1;
        loop {
            let output = killed_at(writes, count, record, port, folder.path());
            let found = left(folder.path(), record);
            println!("{record}, call {count} of {writes}: {found:?} rows");
            if output.status.success() {
                assert!(found.is_some_and(|rows| rows > 60), "{found:?} rows of a whole run");
                break;
            }
            killed.fetch_add(1, Relaxed);
            recovered.fetch_add(usize::from(found.is_some()), Relaxed);
            for (name, _) in common::jobs::listing(folder.path()) {
                if name.starts_with("run.") || name.starts_with("recovered.") {
                    fs::remove_file(folder.path().join(name)).expect("it is ours");
                }
            }
            // Some of many blocks alike.
            count += 1 + if thorough { count / 16 } else { count / 8 * 2 };
            assert!(count < 100_000, "it never ends");
        }
    });
    let (killed, recovered) = (killed.into_inner(), recovered.into_inner());
    println!("killed {killed} times; rows came back {recovered} times");
    assert!(recovered > 10);
}
