use std::collections::BTreeMap;
use std::sync::atomic::AtomicU64;

use surround::{Memory, Piece as Surrounding, Repair, Side, Surround};

use super::*;
use crate::chain::{Bench, Horizon, OWN_COMMAND};
use crate::data_set::RecordRows;

/// Two records of loops with a neighbour's command and a temperature beside them.
fn data() -> DataSet {
    let at = |k: usize, seed: f64| {
        let t = 1e-3 * k as f64;
        40.0 + 30.0 * (25.0 * t + seed).sin() + 8.0 * (311.0 * t * (1.0 + seed)).sin()
    };
    let over = |seed: f64| (0..400).map(|k| at(k, seed)).collect::<Vec<f64>>();
    let record = |seed: f64| RecordRows {
        name: seed.to_string(),
        command: over(seed),
        y: over(seed),
        aux: vec![over(0.3 + seed), over(0.5 + seed)],
        ..RecordRows::still(400, 1.0)
    };
    let aux = [("neighbour".to_owned(), true), ("temperature".to_owned(), false)];
    DataSet::new(vec![record(0.1), record(0.7)], &aux, None)
}

/// A model that passes its command on, with plays.
fn base(is_white: bool) -> Base {
    let slots = Slot::ALL.iter().map(|slot| (*slot, 0)).collect::<BTreeMap<_, _>>();
    let (r, w) = (vec![4.0, 9.0, 15.0, 22.0, 30.0], vec![0.2, 0.1, 0.1, 0.05, 0.1]);
    let memory = Some(Memory { r, w });
    Base { slots, memory, is_white, ..Base::empty(Part::Axis, 0.01) }
}

fn setting<'a>(base: &'a Base, data: &'a DataSet) -> Setting<'a> {
    let gaps = Gaps { every: 5, missing: 3, steps: 40.0, phase: 0.2 };
    Setting {
        base,
        data,
        command: data.command_span,
        position: data.output_span,
        leaves: 0.1,
        sample: 1e-3,
        length: 0.4,
        steepest: 3000.0,
        slope_power: 4e5,
        loop_power: 1e4,
        apparent_power: 2e4,
        lines: vec![50.0],
        swings: Vec::new(),
        resonance: Some(180.0),
        steps: vec![(40.0, 0.3)],
        gaps: Some(gaps),
        reading_steps: vec![(60.0, 0.1)],
        reading_gaps: Some(gaps),
    }
}

/// The blocks as the one effect behind an FMU that passes its input on.
fn repaired(pieces: &[Piece], p: &[f64], step: f64) -> Option<Surround> {
    let variable = |reference| surround::Variable { reference, start: vec![0.0] };
    let port = |reference: u32| surround::Port {
        name: reference.to_string(),
        variable: variable(reference),
        element: 0,
        own: false,
        unit: "1".to_owned(),
        factor: 1.0,
        offset: 0.0,
    };
    let parameter = |(k, start): (usize, &f64)| surround::Parameter {
        name: format!("p{k}"),
        description: String::new(),
        unit: "1".to_owned(),
        factor: 1.0,
        start: *start,
        min: None,
        max: None,
        reference: 10 + k as u32,
    };
    let surrounding = |piece: &Piece| {
        let auxiliary = Some(usize::from(piece.aux != OWN_COMMAND));
        let (parameters, block) = (piece.takes.clone(), piece.block.effect()?.clone());
        let side = Side::Output;
        Some(Surrounding { side, port: 0, drive: 0, auxiliary, place: 0, parameters, block })
    };
    let blocks = pieces.iter().map(surrounding).collect::<Option<Vec<_>>>()?;
    let effect = surround::Effect {
        name: "effect".to_owned(),
        description: String::new(),
        enabled: true,
        reference: 4,
        parameters: p.iter().enumerate().map(parameter).collect(),
        blocks,
    };
    let text = || "1".to_owned();
    let (identifier, token, sha256) = (text(), text(), text());
    let original = surround::Original { fmi: text(), identifier, token, sha256 };
    let repair = Repair {
        format: surround::FORMAT,
        token: text(),
        step,
        divide: true,
        original,
        inputs: vec![port(1), port(2)],
        outputs: vec![port(3)],
        changes: Vec::new(),
        effects: vec![effect],
        sizes: Vec::new(),
        presets: Vec::new(),
    };
    Some(Surround::new(repair).expect("the numbers of parameters"))
}

#[test]
fn a_repaired_fmu_computes_the_very_numbers_of_the_diagnosis() {
    let data = data();
    let mut compared = 0;
    for is_white in [true, false] {
        let base = base(is_white);
        for family in families(&setting(&base, &data), &[]) {
            for formula in &family.formulas {
                if formula.pieces.is_empty() {
                    continue;
                }
                for start in &formula.starts {
                    compared += usize::from(compare(&base, &data, formula, start));
                }
            }
        }
    }
    assert!(compared > 150, "only {compared} settings of formulas");
}

/// Whether there is something to compare, which is then the same to the bits.
fn compare(base: &Base, data: &DataSet, formula: &Formula, start: &[f64]) -> bool {
    let chain = base.compose(&[formula]);
    let mut theta = vec![0.0; chain.parameters.len()];
    let first = chain.parameters.len() - formula.parameters.len();
    for (k, (free, value)) in formula.parameters.iter().zip(start).enumerate() {
        theta[first + k] = free.coordinate(*value);
    }
    let p: Vec<f64> =
        (first..chain.parameters.len()).map(|k| chain.parameters[k].value(theta[k])).collect();
    let Some(mut fmu) = repaired(&formula.pieces, &p, data.step) else { return false };
    let beside = formula.pieces.iter().map(|piece| piece.aux).find(|aux| *aux != OWN_COMMAND);
    let beside = beside.unwrap_or(0);
    let count = AtomicU64::new(0);
    let mut bench = Bench::new(&chain, data, Horizon::All, &count);
    let diagnosed = bench.keep(&theta).expect("a simulation");
    for record in &data.records {
        for hit in record.hits.clone() {
            fmu.take(1, &[data.command[hit]]);
            fmu.take(2, &[data.aux[beside].hits[hit]]);
            let is_rest = hit == record.hits.start;
            if is_rest {
                fmu.rest_inputs()
            } else {
                fmu.step_inputs(data.step)
            }
            fmu.outputs()[0].inner[0] = data.command[hit];
            if is_rest {
                fmu.rest_outputs()
            } else {
                fmu.step_outputs(data.step)
            }
            let (fmu, own) = (fmu.shown(3).unwrap()[0], diagnosed[hit]);
            assert_eq!(fmu.to_bits(), own.to_bits(), "{} at {hit}: {fmu} and {own}", formula.name);
        }
    }
    true
}
