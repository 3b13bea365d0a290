//! Validates an FMU with fmi-rs and simulates it there, without a word about this project's code.
//!
//! `fmi-rs-importer check <FMU>` prints every problem.
//! `fmi-rs-importer simulate <FMU> <input.csv> <output.csv> <log> <start> <stop> <step>
//! [load=<state>] [save=<state>]` runs it with the inputs of a file, from and to a serialised state.

use std::error::Error;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fmi_rs::fmi3::LibraryKind;
use fmi_rs::model_description::{FMIMajorVersion, fmi2, fmi3, peek_fmi_major_version};
use fmi_rs::sim;
use fmi_rs::zip::{extract_zip_archive, get_zip_contents};

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["check", fmu] => check(fmu),
        ["simulate", fmu, input, output, log, start, stop, step, states @ ..] => {
            let state = |key: &str| states.iter().find_map(|s| s.strip_prefix(key));
            simulate(&Run {
                fmu: Path::new(fmu),
                input: Path::new(input),
                output: Path::new(output),
                log: log.into(),
                time: [start.parse()?, stop.parse()?, step.parse()?],
                load: state("load=").map(PathBuf::from),
                save: state("save=").map(PathBuf::from),
            })
        }
        _ => Err("say check or simulate, and the FMU".into()),
    }
}

/// An unpacked FMU and its version.
fn unpacked(fmu: &Path) -> Outcome<(tempfile::TempDir, PathBuf, FMIMajorVersion)> {
    let folder = tempfile::tempdir()?;
    extract_zip_archive(fmu, folder.path())?;
    let xml = folder.path().join("modelDescription.xml");
    let version = peek_fmi_major_version(&xml)?;
    Ok((folder, xml, version))
}

fn check(fmu: &str) -> Outcome<()> {
    for name in get_zip_contents(fmu)? {
        if name.contains('\\') || name.starts_with('/') {
            println!("the name of an entry is {name:?}");
        }
    }
    let (_folder, xml, version) = unpacked(Path::new(fmu))?;
    let problems = match version {
        FMIMajorVersion::V2 => fmi2::ModelDescription::from_path(&xml)?.validate(),
        FMIMajorVersion::V3 => fmi3::ModelDescription::from_path(&xml)?.validate(),
    };
    problems.iter().for_each(|problem| println!("{}", problem.message));
    Ok(())
}

/// What is to be simulated.
struct Run<'a> {
    fmu: &'a Path,
    input: &'a Path,
    output: &'a Path,
    log: PathBuf,
    /// Start, stop, step.
    time: [f64; 3],
    load: Option<PathBuf>,
    save: Option<PathBuf>,
}

/// How close two times must be to be the same.
const TOLERANCE: f64 = 1e-12;

fn simulate(run: &Run) -> Outcome<()> {
    let (folder, xml, version) = unpacked(run.fmu)?;
    match version {
        FMIMajorVersion::V2 => simulate_2(run, folder.path(), &xml),
        FMIMajorVersion::V3 => simulate_3(run, folder.path(), &xml),
    }
}

fn simulate_2(run: &Run, folder: &Path, xml: &Path) -> Outcome<()> {
    use sim::fmi2::{SimulationSettings, Trajectories, cs, csv, input::StaticInput};
    let description = Arc::new(fmi2::ModelDescription::from_path(xml)?);
    let variables = description.modelVariables.iter().enumerate();
    let outputs =
        variables.filter(|(_, v)| v.causality == fmi2::Causality::Output).map(|(i, _)| i).collect();
    let [start_time, stop_time, output_interval] = run.time;
    let settings = SimulationSettings {
        unzipdir: folder.to_owned(),
        model_description: description.clone(),
        start_time,
        stop_time,
        logging_on: true,
        set_stop_time: run.save.is_none(),
        output_interval,
        log_time_scale: false,
        tolerance: TOLERANCE,
        set_tolerance: true,
        start_values: Vec::new(),
        log_fmi_calls: false,
        input_file: None,
        early_return_allowed: false,
        event_mode_used: false,
        log_file: Some(run.log.clone()),
        initial_fmu_state_file: run.load.clone(),
        final_fmu_state_file: run.save.clone(),
    };
    let recorder = Arc::new(sim::fmi2::recorder::Recorder::new(Trajectories::new(
        description.clone(),
        outputs,
    )));
    let input = StaticInput::new(csv::read_csv(File::open(run.input)?, description)?, TOLERANCE);
    cs::simulate(&settings, Some(Arc::new(input)), recorder.clone())?;
    csv::write_csv(&recorder.trajectories.borrow(), run.output)?;
    Ok(())
}

fn simulate_3(run: &Run, folder: &Path, xml: &Path) -> Outcome<()> {
    use sim::fmi3::{SimulationSettings, Trajectories, cs, csv, input::StaticInput};
    let description = Arc::new(fmi3::ModelDescription::from_path(xml)?);
    let variables = description.modelVariables.iter().enumerate();
    let outputs =
        variables.filter(|(_, v)| v.causality == fmi3::Causality::Output).map(|(i, _)| i).collect();
    let [start_time, stop_time, output_interval] = run.time;
    let settings = SimulationSettings {
        unzipdir: folder.to_owned(),
        model_description: description.clone(),
        library_kind: LibraryKind::Native,
        enable_dae: false,
        start_time,
        stop_time,
        visible: false,
        logging_on: true,
        set_stop_time: run.save.is_none(),
        output_interval,
        log_time_scale: false,
        tolerance: TOLERANCE,
        set_tolerance: true,
        start_values: Vec::new(),
        log_fmi_calls: false,
        intermediate_update: false,
        input_file: None,
        early_return_allowed: true,
        event_mode_used: false,
        log_file: Some(run.log.clone()),
        initial_fmu_state_file: run.load.clone(),
        final_fmu_state_file: run.save.clone(),
    };
    let recorder = Arc::new(sim::fmi3::recorder::Recorder::new(Trajectories::new(
        description.clone(),
        outputs,
    )));
    let input = StaticInput::new(csv::read_csv(File::open(run.input)?, description)?, TOLERANCE);
    cs::simulate(&settings, Some(Arc::new(input)), recorder.clone())?;
    csv::write_csv(&recorder.trajectories.borrow(), run.output)?;
    Ok(())
}
