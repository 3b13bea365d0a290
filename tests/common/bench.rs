//! Runner and machine of the bench as processes.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicU16, Ordering};

/// A free pair of ports of this test process. They lie below those that systems give to clients, from 32768 on, which
/// stay taken for a minute after each connection.
pub(crate) fn port() -> u16 {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    let base = 10_000 + (std::process::id() % 1000) as u16 * 20;
    loop {
        let port = base + 2 * NEXT.fetch_add(1, Ordering::Relaxed);
        let free = |port: u16| {
            let place = ("127.0.0.1", port);
            std::net::UdpSocket::bind(place).is_ok() && std::net::TcpListener::bind(place).is_ok()
        };
        if free(port) && free(port + 1) {
            return port;
        }
    }
}

/// A process whose first line has been read.
pub(crate) struct Process {
    pub(crate) child: Child,
    pub(crate) out: BufReader<ChildStdout>,
    pub(crate) first: String,
}

impl Process {
    pub(crate) fn start(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
        let mut out = BufReader::new(child.stdout.take().expect("a pipe"));
        let mut first = String::new();
        out.read_line(&mut first).expect("it speaks");
        Process { child, out, first }
    }

    pub(crate) fn tool(arguments: &[&str], folder: &Path) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_piezoloop"));
        Process::start(command.args(arguments).current_dir(folder))
    }

    pub(crate) fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        assert!(super::kill(&[name, &id]).status().expect("kill runs").success());
    }

    /// What the process said until its end, and its exit code.
    pub(crate) fn end(mut self) -> (String, Option<i32>) {
        let mut text = self.first.clone();
        self.out.read_to_string(&mut text).expect("UTF-8");
        (text, self.child.wait().expect("it ends").code())
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A folder with a plan that plays commands to a machine of one axis.
pub(crate) fn stage(seconds: f64) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = format!(
        "rate = 200\nsettle = 0.05\napproach = 0.1\npatience = 20\n\
         [[axis]]\ncommand_limits = [-2, 12]\nsafe_rate = 100\n\
         command_unit = \"V\"\nposition_unit = \"um\"\n\
         [watch]\nhold = 150\nmax_age = 100\n\
         [[sequence]]\nkind = \"rest\"\nseconds = {seconds}\nat = [6]\n"
    );
    std::fs::write(folder.path().join("plan.toml"), plan).expect("a plan");
    folder
}

/// Writes the folder's plan with parts of its text replaced.
pub(crate) fn change_plan(folder: &Path, changes: &[(&str, &str)]) {
    let file = folder.join("plan.toml");
    let plan = std::fs::read_to_string(&file).expect("a plan");
    let changed = changes.iter().fold(plan, |plan, (from, to)| plan.replace(from, to));
    std::fs::write(file, changed).expect("a plan");
}

/// A log in the folder.
pub(crate) fn log(folder: &Path, name: &str) -> data::Log {
    data::Log::read(&folder.join(name), &data::ReadOptions::default()).expect("a log")
}

/// The machine that the tool plays: p1, a stage of one axis.
pub(crate) fn machine(port: u16, more: &[&str], folder: &Path) -> Process {
    let gateway = format!("udp://127.0.0.1:{port}");
    let mut all = vec!["bench", "emulate", "p1", "--gateway", &gateway, "--rate", "200"];
    all.extend(more);
    Process::tool(&all, folder)
}
