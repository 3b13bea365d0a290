//! Files appear whole or not at all: killed at any moment, on a full disk, where nothing may be
//! written, with others at work in the same folder; what was there before is there afterwards.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use common::jobs::{Job, allow, jobs, listing, old};

/// What a killed process may leave behind: hidden, and by no name that anybody reads. A sweep keeps its
/// journal, to go on from.
fn is_left_over(name: &str) -> bool {
    let hidden = [".fmu-", ".piezoloop-report-", ".tmp"];
    let temporary = name.starts_with('.') && name.ends_with(".tmp");
    temporary || hidden.iter().any(|begin| name.starts_with(begin)) || name.ends_with(".journal")
}

/// Whether many moments are tried, which takes minutes: PIEZOLOOP_KILLS is set.
fn thorough() -> bool {
    std::env::var_os("PIEZOLOOP_KILLS").is_some()
}

/// Each file is the old one or a whole new one.
fn holds(job: &Job, out: &Path, had_old: bool, when: &str) {
    let found = listing(out);
    for (name, bytes) in &found {
        if is_left_over(name) {
            continue;
        }
        let is_old = had_old && *bytes == old(name);
        let complete = is_old || job.is_new(name, bytes);
        assert!(complete, "{}, killed {when}: {name} has {} bytes", job.name, bytes.len());
    }
    if had_old {
        for (name, _) in &job.files {
            let stays = found.iter().any(|(n, _)| n == name);
            assert!(stays, "{}, killed {when}: {name} is gone", job.name);
        }
    }
}

/// How many hidden files killed ones left.
fn leftovers(out: &Path) -> usize {
    listing(out).iter().filter(|(name, _)| is_left_over(name)).count()
}

/// Whether old files lie there, for both cases; long jobs get the second only, unless all are wanted.
fn cases(job: &Job) -> impl Iterator<Item = bool> {
    let one = !thorough() && job.time >= SHORT && job.may_replace();
    [false, true].into_iter().filter(move |old| if *old { job.may_replace() } else { !one })
}

/// A job that many others fit beside.
const SHORT: Duration = Duration::from_secs(1);

/// The jobs that are run very often.
fn often() -> impl Iterator<Item = &'static Job> {
    let most = if thorough() { Duration::from_secs(8) } else { SHORT };
    jobs().iter().filter(move |job| job.time < most)
}

/// A folder for the files, with older ones or not.
fn out(job: &Job, with_old: bool) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    if with_old {
        job.put_old(folder.path());
    }
    folder
}

#[test]
fn killed_at_any_moment_files_are_old_or_new() {
    let (mut killed, mut left) = (0, 0);
    for job in jobs() {
        // More moments where a run is short; the last ones are after its usual end.
        let (time, most) = if thorough() { (3.0, 16.0) } else { (0.5, 8.0) };
        let moments = (time / job.time.as_secs_f64()).clamp(3.0, most) as u32;
        for with_old in cases(job) {
            let folder = out(job, with_old);
            for moment in 0..moments {
                let delay = job.time.mul_f64(1.1 * f64::from(moment) / f64::from(moments));
                let mut child = job
                    .command(folder.path())
                    .stdout(Stdio::null())
                    .stderr(Stdio::null())
                    .spawn()
                    .expect("the tool starts");
                std::thread::sleep(delay);
                child.kill().expect("it is ours");
                let status = child.wait().expect("it ends");
                killed += usize::from(status.signal() == Some(9));
                holds(job, folder.path(), with_old, &format!("after {delay:?}"));
            }
            left += leftovers(folder.path());
            // What killed ones left is in nobody's way.
            let output = job.command(folder.path()).output().expect("the tool starts");
            let message = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}: {message}", job.name);
            for (name, _) in &job.files {
                let bytes = fs::read(folder.path().join(name)).expect(name);
                assert!(job.is_new(name, &bytes), "{}: {name} after all", job.name);
            }
        }
    }
    println!("{} commands killed {killed} times, {left} hidden files left", jobs().len());
    assert!(killed > 50, "only {killed} were killed before their end");
}

/// The calls by which a file changes.
const WRITES: &str =
    "write,pwrite64,rename,renameat,renameat2,linkat,unlink,unlinkat,fsync,ftruncate";

#[test]
fn killed_at_each_write_files_are_old_or_new() {
    let traced = Command::new("strace").args(["-o", "/dev/null", "true"]).output();
    if !traced.is_ok_and(|output| output.status.success()) {
        println!("SKIPPED: no strace, or no process may be traced here");
        return;
    }
    let (mut killed, mut left) = (0, 0);
    for job in often() {
        for with_old in cases(job) {
            let folder = out(job, with_old);
            let mut count = 1_u32;
            loop {
                let inject = format!("inject={WRITES}:signal=SIGKILL:when={count}");
                let trace = format!("trace={WRITES}");
                let strace = ["strace", "-f", "-o", "/dev/null", "-e", &trace, "-e", &inject];
                let output = job.under(&strace, folder.path()).output().expect("strace starts");
                let when = format!("at its write {count}");
                holds(job, folder.path(), with_old, &when);
                if output.status.success() {
                    break;
                }
                killed += 1;
                // Each of the first, then some of many alike.
                count += (if thorough() { count / 4 } else { count }).max(1);
                assert!(count < 100_000, "{}: it never ends", job.name);
            }
            left += leftovers(folder.path());
            assert!(count > 1, "{}: it writes something", job.name);
        }
    }
    println!("killed at {killed} writes, {left} hidden files left");
    assert!(killed > 50);
}

/// A small disk of our own in memory, unmounted when dropped.
struct SmallDisk {
    folder: tempfile::TempDir,
}

impl SmallDisk {
    /// `None`, with a line, where none may be mounted.
    fn new() -> Option<Self> {
        let folder = tempfile::tempdir().expect("a folder");
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", "size=64k", "piezoloop-test"])
            .arg(folder.path())
            .output();
        if !mounted.is_ok_and(|output| output.status.success()) {
            println!("SKIPPED: no tmpfs may be mounted here; it takes root");
            return None;
        }
        Some(SmallDisk { folder })
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn remount(&self, how: &str) {
        let status = Command::new("mount")
            .args(["-o", &format!("remount,{how}")])
            .arg(self.path())
            .status()
            .expect("mount starts");
        assert!(status.success());
    }

    /// Empties it, puts the old files there and fills the rest.
    fn fill(&self, job: &Job) {
        for (name, _) in listing(self.path()) {
            fs::remove_file(self.path().join(name)).expect("it is ours");
        }
        job.put_old(self.path());
        let filled = fs::write(self.path().join("filler"), vec![0; 1 << 17]);
        assert!(filled.is_err(), "it is small");
        // Linux counts a tmpfs's blocks per processor and may refuse before the last one, and what the last call wrote is
        // free only once all its processes have ended: the disk is full when pages are refused for a while.
        let mut refused = 0;
        for page in 0.. {
            let filler = self.path().join(format!("filler-{page}"));
            if fs::write(filler, [0; 4096]).is_ok() {
                refused = 0;
                continue;
            }
            refused += 1;
            if refused == 8 {
                break;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.path()).status();
    }
}

/// Refuses with a file's name and these words, and everything in the folder is as it was.
fn refuses(job: &Job, out: &Path, command: &mut Command, words: &[&str]) {
    let before = listing(out);
    let output = command.output().expect("the tool starts");
    let message = String::from_utf8_lossy(&output.stderr);
    let code = output.status.code();
    assert_eq!(code, Some(2), "{}: {message}", job.name);
    assert!(!message.contains("panicked"), "{}: {message}", job.name);
    let is_named = job.files.iter().any(|(name, _)| message.contains(name.as_str()));
    assert!(is_named, "{}: no file is named in: {message}", job.name);
    for words in words {
        assert!(message.contains(words), "{}: \"{words}\" is not in: {message}", job.name);
    }
    let mut after = listing(out);
    // A sweep keeps its journal, to go on from.
    after.retain(|(name, _)| !name.ends_with(".journal") || before.iter().any(|(n, _)| n == name));
    let names = |files: &[(String, Vec<u8>)]| -> Vec<(String, usize)> {
        files.iter().map(|(name, bytes)| (name.clone(), bytes.len())).collect()
    };
    assert!(before == after, "{}: {:?}, {:?}", job.name, names(&before), names(&after));
}

#[test]
fn a_full_disk_is_told_and_loses_nothing() {
    let Some(disk) = SmallDisk::new() else { return };
    for job in jobs().iter().filter(|job| job.time < Duration::from_secs(8)) {
        disk.fill(job);
        let mut command = job.command(disk.path());
        refuses(job, disk.path(), &mut command, &["No space left on device", "space"]);
    }
}

/// Where one file of a call fits and the next one does not, the error names both.
#[test]
fn what_is_written_and_what_is_not_is_stated() {
    let Some(disk) = SmallDisk::new() else { return };
    let mut reports_both = 0;
    for job in jobs().iter().filter(|job| job.files.len() > 1 && job.time < Duration::from_secs(8))
    {
        // Room for all of them but some kilobytes: a disk has blocks of four. A page that says how long the work took is
        // some bytes longer or shorter each time, which may be a block.
        let total: usize = job.files.iter().map(|(_, bytes)| bytes.len().div_ceil(4096) * 4).sum();
        for (name, _) in listing(disk.path()) {
            fs::remove_file(disk.path().join(name)).expect("it is ours");
        }
        disk.remount(&format!("size={}k", total.saturating_sub(8).max(4)));
        let output = job.command(disk.path()).output().expect("the tool starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{}: {message}", job.name);
        assert!(message.contains("No space left on device"), "{}: {message}", job.name);
        let is_there = |name: &str| disk.path().join(name).exists();
        let (there, absent): (Vec<&str>, Vec<&str>) =
            job.files.iter().map(|(name, _)| name.as_str()).partition(|name| is_there(name));
        if there.is_empty() {
            continue;
        }
        let (before, written) = message.split_once("written before: ").unwrap_or((&message, ""));
        let (written, missing) = written.split_once("; not written: ").unwrap_or((written, ""));
        for name in there {
            let path = disk.path().join(name).display().to_string();
            assert!(written.contains(&path), "{}, {name}: {message}", job.name);
        }
        for name in absent {
            let path = disk.path().join(name).display().to_string();
            // A file that nobody named is told where it fails.
            let is_reported = missing.contains(&path) || before.contains(&path);
            assert!(is_reported && !written.contains(&path), "{}, {name}: {message}", job.name);
        }
        reports_both += 1;
    }
    println!("{reports_both} commands wrote some of their files");
    assert!(reports_both >= 4, "only {reports_both}");
}

#[test]
fn a_folder_that_is_read_only_is_told_before_the_work() {
    let Some(disk) = SmallDisk::new() else { return };
    for job in jobs() {
        disk.remount("rw");
        for (name, _) in listing(disk.path()) {
            fs::remove_file(disk.path().join(name)).expect("it is ours");
        }
        job.put_old(disk.path());
        disk.remount("ro");
        let mut command = job.command(disk.path());
        refuses(job, disk.path(), &mut command, &["Read-only file system"]);
    }
}

#[test]
fn missing_permissions_are_reported() {
    let nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"];
    let is_possible = Command::new(nobody[0])
        .args(&nobody[1..])
        .arg(env!("CARGO_BIN_EXE_piezoloop"))
        .arg("--version")
        .output();
    if !is_possible.is_ok_and(|output| output.status.success()) {
        println!("SKIPPED: nobody else can run the tool here; it takes root and setpriv");
        return;
    }
    for job in jobs() {
        let folder = out(job, true);
        allow(folder.path(), 0o755);
        let mut command = job.under(&nobody, folder.path());
        refuses(job, folder.path(), &mut command, &["Permission denied", "permissions"]);
    }
}

#[test]
fn a_write_protected_file_is_not_replaced() {
    for job in jobs().iter().filter(|job| job.may_replace()) {
        let folder = out(job, true);
        for (name, _) in listing(folder.path()) {
            let path = folder.path().join(name);
            let mut permissions = fs::metadata(&path).expect("there").permissions();
            permissions.set_readonly(true);
            fs::set_permissions(&path, permissions).expect("it is ours");
        }
        let mut command = job.command(folder.path());
        refuses(job, folder.path(), &mut command, &["is write-protected", "give another file"]);
    }
}

#[test]
fn several_at_once_in_one_folder_do_not_disturb_each_other() {
    for job in often() {
        let folder = out(job, true);
        let start = || {
            let mut command = job.command(folder.path());
            command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the tool starts")
        };
        let children: Vec<_> = (0..4).map(|_| start()).collect();
        let mut done = 0;
        for child in children {
            let output = child.wait_with_output().expect("it ends");
            let message = String::from_utf8_lossy(&output.stderr);
            // Of one sweep only one works at a time; the others say so.
            let waits = job.name == "sweep" && message.contains("another process runs this sweep");
            assert!(output.status.success() || waits, "{}: {message}", job.name);
            done += usize::from(output.status.success());
        }
        assert!(done > 0, "{}", job.name);
        let names: Vec<String> = listing(folder.path()).into_iter().map(|(n, _)| n).collect();
        let wanted: Vec<String> = job.files.iter().map(|(name, _)| name.clone()).collect();
        assert_eq!(names, wanted, "{}", job.name);
        for (name, bytes) in listing(folder.path()) {
            assert!(job.is_new(&name, &bytes), "{}: {name}", job.name);
        }
    }
}
