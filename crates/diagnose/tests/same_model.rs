//! Models that do the same get the same diagnosis, however their blueprints spell it.

use crate::common::machine::Normal;
use crate::common::positions;
use components::COMPONENTS;
use data::{Blueprint, CheckedBlueprint, Log};
use diagnose::{Gap, Model, Noise, Request, Silent, Verdict, diagnose};

const STEP: f64 = 1e-3;
const NOISE: f64 = 0.002;

/// A plant of an actuator and what is behind it.
fn plant(actuator: &str, behind: &str) -> CheckedBlueprint {
    let text = format!(
        "piezoloop = 1\nkind = \"plant\"\nname = \"stage\"\nstep = {STEP}\n[[axis]]\nname = \"X\"\n\
         command = {{ name = \"u\", unit = \"V\", min = 0, max = 100 }}\n\
         position = {{ name = \"y\", unit = \"um\" }}\n[[axis.component]]\n{actuator}\n{behind}\n"
    );
    Blueprint::parse(&text, "stage.toml").unwrap().check(COMPONENTS).unwrap()
}

const MODE: &str = "[[axis.component]]\ntype = \"mode\"\nfrequency = 400\ndamping = 0.1\n";
const PLAYS: &str = "r = [0, 4, 10, 20, 35]\nw = [0.05, 0.012, 0.01, 0.012, 0.015]\n";

/// Triangles from 0 to a peak that falls from 100 V to 10 V in ten cycles.
fn triangles(frequency: f64) -> Vec<f64> {
    let rows = (10.0 / frequency / STEP) as usize;
    let at = |n: usize| {
        let cycles = n as f64 * STEP * frequency;
        let peak = 100.0 - 9.0 * cycles.floor();
        peak * (1.0 - (2.0 * cycles.fract() - 1.0).abs())
    };
    (0..rows).map(at).collect()
}

/// The logs of a machine.
fn logs(machine: &CheckedBlueprint) -> Vec<Log> {
    let mut noise = Normal::new(7);
    let log = |frequency: f64| {
        let commands = triangles(frequency);
        let mut noisy = positions(machine, &commands, STEP);
        noisy.iter_mut().for_each(|y| *y += NOISE * noise.draw());
        let time = (0..commands.len()).map(|n| n as f64 * STEP).collect();
        let mut log = Log::new(&format!("{frequency} Hz.csv"), time).unwrap();
        log.add_column("u", Some("V"), commands).unwrap();
        log.add_column("y", Some("um"), noisy).unwrap();
        log
    };
    [2.0, 20.0].map(log).into()
}

fn gap(model: CheckedBlueprint, logs: &[Log]) -> Gap {
    let mut request = Request::new(Model::Blueprint(Box::new(model)), logs.to_vec());
    request.noise = Noise::Given(vec![(None, NOISE)]);
    diagnose(&request, &mut Silent).unwrap()
}

/// Verdict, sentence, effects with their probability, number of candidates.
fn answer(gap: &Gap) -> (Verdict, Vec<(String, f64)>, usize) {
    let effects = gap.effects.iter().map(|e| (e.effect.clone(), e.probability)).collect();
    (gap.verdict, effects, gap.candidates.len())
}

#[test]
fn a_dead_zone_that_is_never_reached_changes_no_diagnosis() {
    let plain = plant(&format!("type = \"prandtl-ishlinskii\"\n{PLAYS}"), MODE);
    let zones = plant(
        &format!("type = \"modified-prandtl-ishlinskii\"\n{PLAYS}edge = [1000]\nslope = [0]\n"),
        MODE,
    );
    let commands = triangles(2.0);
    assert_eq!(positions(&plain, &commands, STEP), positions(&zones, &commands, STEP));
    let machine = plant(
        "type = \"rate-dependent-play\"\nr = [4, 10, 20, 35]\nw = [0.012, 0.01, 0.012, 0.015]\n\
         gain = 0.05\nrate = 1e-3\n",
        MODE,
    );
    let logs = logs(&machine);
    let (plain, zones) = (gap(plain, &logs), gap(zones, &logs));
    assert_eq!(plain.verdict, Verdict::Effects, "{}", plain.sentence);
    assert_eq!(plain.effects[0].effect, "rate_dependence", "{}", plain.sentence);
    assert_eq!(answer(&plain), answer(&zones), "{}\n{}", plain.sentence, zones.sentence);
    assert_eq!(plain.shrink.rms_after.to_bits(), zones.shrink.rms_after.to_bits());
}

#[test]
fn a_rate_is_found_where_the_internal_step_divides_the_sample() {
    let fine = |text: String, behind: &str| {
        let text = format!(
            "piezoloop = 1\nkind = \"plant\"\nname = \"stage\"\nstep = 2e-4\n[[axis]]\nname = \"X\"\n\
             command = {{ name = \"u\", unit = \"V\", min = 0, max = 100 }}\n\
             position = {{ name = \"y\", unit = \"um\" }}\n[[axis.component]]\n{text}\n{behind}\n"
        );
        Blueprint::parse(&text, "fine.toml").unwrap().check(COMPONENTS).unwrap()
    };
    let machine = fine(
        "type = \"rate-dependent-play\"\nr = [4, 10, 20, 35]\nw = [0.012, 0.01, 0.012, 0.015]\n\
         gain = 0.05\nrate = 1e-3\n"
            .to_owned(),
        MODE,
    );
    let model = fine(format!("type = \"prandtl-ishlinskii\"\n{PLAYS}"), MODE);
    let gap = gap(model, &logs(&machine));
    assert_eq!(gap.effects[0].effect, "rate_dependence", "{}", gap.sentence);
    let found = gap.effects[0].parameters.iter().find(|(_, p)| p.unit == "s");
    let found = found.unwrap_or_else(|| panic!("{:?}", gap.effects[0]));
    assert!((found.1.value / 1e-3 - 1.0).abs() < 0.02, "{found:?}");
}

#[test]
fn plays_of_every_model_are_the_memory_that_rate_and_start_act_on() {
    let machine = plant(
        "type = \"rate-dependent-play\"\nr = [4, 10, 20, 35]\nw = [0.012, 0.01, 0.012, 0.015]\n\
         gain = 0.05\nrate = 1e-3\n",
        MODE,
    );
    let logs = logs(&machine);
    let zeros = "[0, 0, 0, 0]";
    for actuator in [
        format!("type = \"grpi\"\n{PLAYS}"),
        format!("type = \"mpi\"\n{PLAYS}linear = 0\nrate = 0\n"),
        format!("type = \"lagging-play\"\n{PLAYS}bandwidth = 100000\n"),
        format!(
            "type = \"skewed-play\"\n{PLAYS}skew = [0, 0, 0, 0, 0]\ncentre = 50\nhalf_range = 50\n"
        ),
        format!("type = \"dynamic-prandtl-ishlinskii\"\n{PLAYS}alpha = {zeros}\nbeta = {zeros}\n"),
        format!(
            "type = \"generalised-play\"\n{PLAYS}left_a0 = 1e5\nleft_a1 = 1e-5\nright_a0 = 1e5\n\
             right_a1 = 1e-5\n"
        ),
    ] {
        let gap = gap(plant(&actuator, MODE), &logs);
        let first = gap.effects.first().map(|e| e.effect.as_str());
        assert_eq!(first, Some("rate_dependence"), "{actuator}: {}", gap.sentence);
    }
}

#[test]
fn a_matrix_of_one_axis_is_a_component_in_series() {
    let plays = format!("type = \"prandtl-ishlinskii\"\n{PLAYS}");
    let matrix = |frequency: f64| {
        format!(
            "[[coupling]]\ntype = \"modal-matrix\"\naxes = [\"X\"]\ndirect = [[0]]\n\
             frequency = [{frequency}]\ndamping = [0.1]\nresidue = [[1]]\nrate_residue = [[0]]\n"
        )
    };
    let one =
        |f: f64| format!("[[axis.component]]\ntype = \"mode\"\nfrequency = {f}\ndamping = 0.1\n");
    let logs = logs(&plant(&plays, &one(60.0)));
    let (mode, coupled) =
        (gap(plant(&plays, &one(80.0)), &logs), gap(plant(&plays, &matrix(80.0)), &logs));
    for gap in [&mode, &coupled] {
        assert_eq!(gap.effects[0].effect, "resonance_shift", "{}", gap.sentence);
    }
    let found = coupled.effects[0].parameters.iter().find(|p| p.0.contains("frequency"));
    let found = found.unwrap_or_else(|| panic!("{:?}", coupled.effects[0].parameters));
    assert!((found.1.value / 60.0 - 1.0).abs() < 0.01, "{found:?}");
}
