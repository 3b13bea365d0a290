//! The tool under test, as a program of its own: it gets a case's folder, and no label.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde::Deserialize;

use crate::label::Miss;

/// What the benchmark asks of a tool.
pub trait Tool: Sync {
    /// Packs a blueprint as an FMU.
    ///
    /// # Errors
    /// What the tool said.
    fn pack(&self, blueprint: &Path, fmu: &Path) -> Result<(), String>;

    /// Identifies a blueprint from the columns u1 and y1 of a log.
    ///
    /// # Errors
    /// What the tool said.
    fn identify(&self, log: &Path, blueprint: &Path) -> Result<(), String>;

    /// Diagnoses in a folder; the arguments name the files to read and to write.
    ///
    /// # Errors
    /// What the tool said.
    fn diagnose(&self, folder: &Path, arguments: &[String]) -> Result<(), String>;

    /// Simulates a model on a log and gives by how much the column `y1` is missed, record by record.
    ///
    /// # Errors
    /// What the tool said.
    fn simulate(&self, model: &Path, log: &Path) -> Result<Vec<Miss>, String>;
}

/// Which variables of an FMU that the tool packed read the columns of the first axis.
pub(crate) fn names_of_fmu() -> Vec<String> {
    ["--map", "command[1]=u1", "--map", "position[1]=y1"].map(str::to_owned).to_vec()
}

/// A program with the commands `pack`, `diagnose` and `simulate` of `piezoloop`.
#[derive(Clone, Debug)]
pub struct Program {
    /// Where it is.
    pub path: PathBuf,
    /// How long one call may take.
    pub patience: Duration,
}

/// What `simulate --json` prints, as far as it is needed.
#[derive(Deserialize)]
struct Run {
    fits: Vec<Fit>,
}

#[derive(Deserialize)]
struct Fit {
    against: String,
    samples: usize,
    /// With the mean taken out: the offset of a record is nobody's.
    rmse: f64,
}

impl Program {
    fn call(&self, folder: &Path, arguments: &[String]) -> Result<String, String> {
        // Files in place of pipes: a full pipe would stop the program while it is waited for.
        let out = scratch(folder, "out")?;
        let err = scratch(folder, "err")?;
        let result = self.call_into(folder, arguments, &out, &err);
        for path in [out, err] {
            // What cannot be removed disturbs nobody.
            let _ = std::fs::remove_file(path);
        }
        result
    }

    fn call_into(
        &self,
        folder: &Path,
        arguments: &[String],
        out: &Path,
        err: &Path,
    ) -> Result<String, String> {
        let create = |path: &Path| {
            std::fs::File::create(path).map_err(|error| format!("{}: {error}", path.display()))
        };
        let mut command = Command::new(&self.path);
        // Ctrl-C ends the benchmark, not the diagnosis that is under way.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let child = command
            .current_dir(folder)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(create(out)?)
            .stderr(create(err)?)
            .spawn()
            .map_err(|error| {
                let error = numerics::threads::refused(error);
                format!("{}: cannot be started: {error}", self.path.display())
            })?;
        let status = self.wait(child)?;
        let read = |path| std::fs::read_to_string(path).unwrap_or_default();
        if status.success() {
            return Ok(read(out));
        }
        // A program that was killed or crashed may have said nothing.
        let message = read(err).trim().to_owned();
        Err(if message.is_empty() {
            format!("it ended without a word ({status})")
        } else {
            message
        })
    }

    fn wait(&self, mut child: Child) -> Result<ExitStatus, String> {
        let begin = Instant::now();
        loop {
            match child.try_wait() {
                Ok(Some(status)) => return Ok(status),
                Ok(None) if begin.elapsed() > self.patience => {
                    // It may have ended in between; either way it is over.
                    let _ = child.kill();
                    let _ = child.wait();
                    return Err(format!("no answer within {} s", self.patience.as_secs()));
                }
                Ok(None) => std::thread::sleep(Duration::from_millis(5)),
                Err(error) => return Err(error.to_string()),
            }
        }
    }
}

/// A file of this call's own in the folder.
fn scratch(folder: &Path, what: &str) -> Result<PathBuf, String> {
    let thread = format!("{:?}", std::thread::current().id());
    let thread: String = thread.chars().filter(char::is_ascii_digit).collect();
    Ok(folder.join(format!(".{what}-{}-{thread}", std::process::id())))
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

impl Tool for Program {
    fn pack(&self, blueprint: &Path, fmu: &Path) -> Result<(), String> {
        let folder = blueprint.parent().unwrap_or(Path::new("."));
        let arguments =
            ["--quiet".to_owned(), "pack".to_owned(), text(blueprint), "-o".to_owned(), text(fmu)];
        self.call(folder, &arguments).map(|_| ())
    }

    fn identify(&self, log: &Path, blueprint: &Path) -> Result<(), String> {
        let folder = log.parent().unwrap_or(Path::new("."));
        let (log, blueprint) = (text(log), text(blueprint));
        let arguments = [
            "--quiet", "identify", "--log", &log, "--input", "u1", "--output", "y1", "-o",
            &blueprint,
        ];
        self.call(folder, &arguments.map(str::to_owned)).map(|_| ())
    }

    fn diagnose(&self, folder: &Path, arguments: &[String]) -> Result<(), String> {
        let mut all = vec!["diagnose".to_owned()];
        all.extend_from_slice(arguments);
        self.call(folder, &all).map(|_| ())
    }

    fn simulate(&self, model: &Path, log: &Path) -> Result<Vec<Miss>, String> {
        let folder = log.parent().unwrap_or(Path::new("."));
        let arguments = [
            "--json".to_owned(),
            "simulate".to_owned(),
            text(model),
            "--log".to_owned(),
            text(log),
        ];
        let mut with_names = arguments.to_vec();
        if model.extension().is_some_and(|e| e == "fmu") {
            with_names.extend(names_of_fmu());
        }
        let printed = self.call(folder, &with_names)?;
        let run: Run = serde_json::from_str(&printed).map_err(|error| error.to_string())?;
        let fits = run.fits.iter().filter(|fit| fit.against == "y1");
        Ok(fits.map(|fit| Miss { rms: fit.rmse, rows: fit.samples }).collect())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn program(folder: &Path, script: &str) -> Program {
        use std::os::unix::fs::PermissionsExt as _;
        let path = folder.join("tool.sh");
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        Program { path, patience: Duration::from_millis(400) }
    }

    #[test]
    fn errors_are_what_the_tool_reported() {
        let folder = tempfile::tempdir().unwrap();
        let tool = program(folder.path(), "echo \"error: no $2\" >&2; exit 2");
        let error = tool.diagnose(folder.path(), &["--model".into(), "m.toml".into()]);
        assert_eq!(error.unwrap_err(), "error: no --model");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_tool_that_dies_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let tool = program(folder.path(), "kill -9 $$");
        let error = tool.diagnose(folder.path(), &[]).unwrap_err();
        assert!(error.contains("without a word") && error.contains('9'), "{error}");
    }

    #[test]
    fn a_tool_that_never_answers_is_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let tool = program(folder.path(), "exec sleep 60");
        let error = tool.diagnose(folder.path(), &[]).unwrap_err();
        assert!(error.contains("no answer"), "{error}");
    }

    #[test]
    fn fits_of_the_first_output_are_taken() {
        let folder = tempfile::tempdir().unwrap();
        let fits = r#"{"fits":[{"against":"y1","samples":7,"rmse":0.5},{"against":"y2","samples":7,"rmse":9},{"against":"y1","samples":7,"rmse":0.25}]}"#;
        let tool = program(folder.path(), &format!("echo '{fits}'"));
        let log = folder.path().join("log.csv");
        let expected = [0.5, 0.25].map(|rms| Miss { rms, rows: 7 });
        assert_eq!(tool.simulate(Path::new("m.toml"), &log).unwrap(), expected);
    }
}
