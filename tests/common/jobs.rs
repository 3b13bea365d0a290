//! One call of each command that writes files, and what it writes.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use super::{COORDINATED, root, succeed};

/// A call whose files go to a folder.
pub(crate) struct Job {
    pub(crate) name: &'static str,
    /// Arguments; `OUT/` stands for the folder.
    call: &'static str,
    /// What a whole run writes: names and bytes.
    pub(crate) files: Vec<(String, Vec<u8>)>,
    /// How long that takes.
    pub(crate) time: Duration,
}

const CALLS: [(&str, &str); 16] = [
    ("signal", "signal multisine-odd -o OUT/signal.csv"),
    ("log", "log u.csv -o OUT/copy.csv"),
    ("invert", "invert evc -o OUT/controller.toml"),
    ("pack", "pack evc -o OUT/plant.fmu"),
    ("simulate", "simulate plant.fmu --log u.csv -o OUT/run.csv --report OUT/page.html"),
    ("loop", "simulate --loop plant.fmu controller.fmu --reference r.csv -o OUT/run.csv"),
    ("system csv", "system loop.toml --input r.csv -o OUT/run.csv"),
    ("system npz", "system loop.toml --input r.csv -o OUT/run.npz"),
    ("system parquet", "system loop.toml --input r.csv -o OUT/run.parquet"),
    ("system ssp", "system loop.toml --export OUT/loop.ssp"),
    (
        "calibrate",
        "calibrate motion.csv --motion a --motion b --position x --position y \
         --blueprint jacobian.toml -o OUT/calibrated.toml --report OUT/page.html",
    ),
    (
        "identify",
        "identify --log run.csv --input command[1] --output position[1] --model prandtl-ishlinskii \
         -o OUT/found.toml --picture OUT/loop.svg --report OUT/page.html",
    ),
    (
        "tune",
        "tune plant.fmu --period 5e-5 --middle 60 --amplitude 2 --samples 40 --report OUT/page.html",
    ),
    (
        "frequency-response",
        "frequency-response run.csv --input command[1] --output position[1] -o OUT/response.csv \
         --report OUT/page.html",
    ),
    ("sweep", "sweep plan.toml -o OUT/table.parquet"),
    (
        "diagnose",
        "diagnose --model evc --log run.csv --max-effects 1 --json OUT/gap.json \
         --report OUT/page.html --repair OUT/repaired.toml",
    ),
];

const PLAN: &str = "runs = 20\nseed = 7\n\n[loop]\nplant = \"evc\"\ncontroller = \"controller.toml\"\n\
    reference = \"r.csv\"\nfrom = 0.01\n\n[vary]\n\
    \"plant.*.mechanics.frequency\" = { tolerance = 0.05 }\n";

/// The folder with what the calls read.
fn inputs(folder: &Path) {
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("writable");
    succeed(&["pack", "evc", "-o", "plant.fmu"], folder);
    succeed(&["invert", "evc", "-o", "controller.toml"], folder);
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], folder);
    let example = root().join("examples/03_system");
    fs::copy(example.join("loop.toml"), folder.join("loop.toml")).expect("the example");
    let reference = fs::read_to_string(example.join("reference.csv")).expect("the example");
    write("r.csv", &reference.lines().take(1000).fold(String::new(), |t, line| t + line + "\n"));
    write("jacobian.toml", COORDINATED);
    write("plan.toml", PLAN);
    let (mut u, mut motion) =
        ("time,command[1],command[2]\n".to_owned(), "time [s],a,b,x [um],y [um]\n".to_owned());
    for k in 0..1000 {
        let t = f64::from(k) * 2e-4;
        let v = 60.0 - 50.0 * (120.0 * t).cos() * (1.0 - t);
        u += &format!("{t},{v},{v}\n");
    }
    for k in 0..200 {
        let turn = std::f64::consts::TAU * f64::from(k) / 200.0;
        let (a, b) = (0.5 - 0.4 * (3.0 * turn).cos(), 0.5 - 0.4 * (5.0 * turn).cos());
        let x = 7.0 + 500.0 * a + 0.1 * (91.0 * turn).sin();
        let y = 3.0 + 14.0 * a - 515.0 * b + 0.1 * (83.0 * turn).sin();
        motion += &format!("{},{a},{b},{x},{y}\n", 0.005 * f64::from(k));
    }
    write("u.csv", &u);
    write("motion.csv", &motion);
    succeed(&["simulate", "plant.fmu", "--log", "u.csv", "-o", "run.csv"], folder);
}

/// The folder that calls run in; anybody may read it. What killed ones leave in their temporary folder
/// lies in it too, until the next time.
pub(crate) fn base() -> &'static Path {
    static BASE: OnceLock<PathBuf> = OnceLock::new();
    BASE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("jobs");
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join(TEMPORARY)).expect("a folder");
        allow(&folder, 0o755);
        allow(&folder.join(TEMPORARY), 0o777);
        inputs(&folder);
        folder
    })
}

/// The temporary folder of the calls.
const TEMPORARY: &str = "temporary";

/// Gives a folder of ours these permissions.
pub(crate) fn allow(folder: &Path, mode: u32) {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(folder, fs::Permissions::from_mode(mode)).expect("it is ours");
}

/// All jobs, each run once.
pub(crate) fn jobs() -> &'static [Job] {
    static JOBS: OnceLock<Vec<Job>> = OnceLock::new();
    JOBS.get_or_init(|| {
        let job = |(name, call)| {
            let mut job = Job { name, call, files: Vec::new(), time: Duration::ZERO };
            let out = tempfile::tempdir().expect("a folder");
            let begin = Instant::now();
            let output = job.command(out.path()).output().expect("the tool starts");
            job.time = begin.elapsed();
            let message = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{name}: {message}");
            job.files = listing(out.path());
            assert!(job.files.iter().all(|(_, bytes)| !bytes.is_empty()), "{name}");
            job
        };
        CALLS.into_iter().map(job).collect()
    })
}

/// The files of a folder with their bytes, by name.
pub(crate) fn listing(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let file = |path: PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        (name, fs::read(&path).expect("a file"))
    };
    let mut all: Vec<_> = entries.map(|entry| file(entry.path())).collect();
    all.sort();
    all
}

impl Job {
    /// The call, with its files in `out`.
    pub(crate) fn command(&self, out: &Path) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_piezoloop"));
        command.args(self.arguments(out)).current_dir(base());
        command.env("TMPDIR", base().join(TEMPORARY));
        command
    }

    /// Another program, which is given the call.
    pub(crate) fn under(&self, program: &[&str], out: &Path) -> Command {
        let mut command = Command::new(program[0]);
        command.args(&program[1..]).arg(env!("CARGO_BIN_EXE_piezoloop"));
        command.args(self.arguments(out)).current_dir(base());
        command.env("TMPDIR", base().join(TEMPORARY));
        command
    }

    fn arguments(&self, out: &Path) -> Vec<String> {
        let out = out.to_str().expect("UTF-8");
        self.call.split_whitespace().map(|word| word.replacen("OUT", out, 1)).collect()
    }

    /// Whether an older file may stand where it writes: a sweep goes on from its own table only.
    pub(crate) fn may_replace(&self) -> bool {
        self.name != "sweep"
    }

    /// Puts older files where it writes.
    pub(crate) fn put_old(&self, out: &Path) {
        for (name, _) in self.files.iter().filter(|_| self.may_replace()) {
            fs::write(out.join(name), old(name)).expect("writable");
        }
    }

    /// Whether the bytes are a whole new file of this name. Pages, answers and FMUs tell times, so they
    /// differ from run to run, but their ends do not, and an FMU opens with all checksums right.
    pub(crate) fn is_new(&self, name: &str, bytes: &[u8]) -> bool {
        let text = String::from_utf8_lossy(bytes);
        match name.rsplit_once('.').map(|(_, ending)| ending) {
            Some("html") => text.trim_end().ends_with("</html>"),
            Some("fmu") => {
                let mut file = tempfile::Builder::new().suffix(".fmu").tempfile().expect("a file");
                file.write_all(bytes).expect("writable");
                modeldescription::Package::open(file.path()).is_ok()
            }
            Some("json") => serde_json::from_slice::<serde_json::Value>(bytes).is_ok(),
            _ => self.files.iter().any(|(n, new)| n == name && new == bytes),
        }
    }
}

/// An older file. One that describes a log is replaced only where it has the form that the tool writes.
pub(crate) fn old(name: &str) -> Vec<u8> {
    if name.ends_with(".dataset.toml") {
        return b"time = { column = \"time\", unit = \"s\" }\n\n[columns]\nold = { unit = \"V\" }\n".to_vec();
    }
    format!("the old {name}").into_bytes()
}
