//! Logs whose truth is known, for tests: tones over white noise of the size 1.
//!
//! Tone k has k periods in 40 rows and the power 1. Tones are orthogonal on the fitted rows of a record,
//! and on the held-out ones: what a set of effects explains follows from the powers by hand. The model
//! passes its command on; an effect adds an auxiliary column, which holds tones.

use std::collections::BTreeMap;
use std::f64::consts::{SQRT_2, TAU};

use components::effects;
use model::Effect;
use numerics::random::SplitMix64;
use surround::Block;

use super::*;
use crate::base::{BaseParameter, Part};
use crate::data_set::RecordRows;
use crate::formula::{Free, Slot};
use crate::noise::Shape;

/// Rows of each record, of which 280 are fitted.
const ROWS: usize = 400;
const RECORDS: usize = 2;
/// Tone of the command.
const COMMAND: usize = 19;

/// Effects of no group.
const EFFECTS: [&Effect; 12] = [
    &effects::CLOCK_OFFSET,
    &effects::DAC_QUANTISATION,
    &effects::AMPLIFIER_SLEW,
    &effects::HYSTERESIS,
    &effects::ASYMMETRY,
    &effects::RATE_DEPENDENCE,
    &effects::INITIAL_STATE,
    &effects::DAMPING,
    &effects::EXTRA_MODE,
    &effects::DUFFING,
    &effects::BACKLASH,
    &effects::FRICTION,
];

/// Tones with their amplitudes.
pub(super) type Tones<'a> = &'a [(usize, f64)];

/// What a search needs.
pub(super) struct Synthetic {
    pub(super) base: Base,
    pub(super) data: DataSet,
    pub(super) judge: Judge,
    pub(super) library: Vec<Family>,
    pub(super) count: AtomicU64,
    pub(super) max_effects: usize,
}

fn sum(tones: Tones<'_>, row: usize) -> f64 {
    let tone = |k: usize| SQRT_2 * (TAU * (k * row) as f64 / 40.0).sin();
    tones.iter().map(|(k, amplitude)| amplitude * tone(*k)).sum()
}

/// The formula that adds the auxiliary column of this number.
pub(super) fn adds(column: usize) -> Formula {
    let weight = Free::linear("weight", "1", -1e3, 1e3).step(1e-3);
    let block = Block::Auxiliary { scale: 1.0, zero: 0.0 };
    Formula::new("column").block(Slot::Reading, block, vec![weight]).aux(column).start(&[0.0])
}

impl Synthetic {
    /// A log of the command and these tones, in noise; one family for each of the columns.
    pub(super) fn new(truth: Tones<'_>, columns: &[Tones<'_>]) -> Self {
        Self::shown(truth, truth, columns)
    }

    /// A log whose held-out rows show other tones than the fitted ones.
    pub(super) fn shown(fitted: Tones<'_>, held_out: Tones<'_>, columns: &[Tones<'_>]) -> Self {
        let mut random = SplitMix64::new(3);
        let mut noise = || (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
        let over = |tones: Tones<'_>| (0..ROWS).map(|k| sum(tones, k)).collect::<Vec<_>>();
        let command = over(&[(COMMAND, 10.0)]);
        let record = |name: usize| {
            // A row is read before its command is given.
            let read = |k: usize| {
                let truth = if 10 * k < 7 * ROWS { fitted } else { held_out };
                command[k.saturating_sub(1)] + sum(truth, k.saturating_sub(1))
            };
            RecordRows {
                name: name.to_string(),
                command: command.clone(),
                y: (0..ROWS).map(|k| read(k) + noise()).collect(),
                aux: columns.iter().map(|tones| over(tones)).collect(),
                ..RecordRows::still(ROWS, 0.7)
            }
        };
        let names: Vec<_> = (0..columns.len()).map(|k| (k.to_string(), false)).collect();
        let data = DataSet::new((0..RECORDS).map(record).collect(), &names, None);
        let judge = Judge::new(&data, Shape::WHITE);
        let family = |k: usize| Family::new(EFFECTS[k], vec![adds(k)]);
        let library = (0..columns.len()).map(family).collect();
        let slots = BTreeMap::from([(Slot::Reading, 0)]);
        let base = Base { slots, is_white: true, ..Base::empty(Part::Axis, 0.01) };
        Self { base, data, judge, library, count: AtomicU64::new(0), max_effects: 3 }
    }

    /// With a parameter of the model that nothing depends on; with a tolerance, or free where an effect
    /// releases it.
    pub(super) fn parameter(&mut self, name: &str, has_tolerance: bool) {
        self.base.parameters.push(BaseParameter {
            name: name.to_owned(),
            unit: "1".to_owned(),
            node: 0,
            indices: Vec::new(),
            also: Vec::new(),
            value: 1.0,
            deviation: 0.1,
            has_tolerance,
            effect: None,
        });
    }

    pub(super) fn search(&self) -> Search<'_> {
        Search {
            base: &self.base,
            data: &self.data,
            judge: &self.judge,
            library: &self.library,
            sigma: 1.0,
            adequate: 1.3,
            fine: 0.0,
            count: &self.count,
            max_effects: self.max_effects,
            reading_is_known: true,
            memo: Box::leak(Box::default()),
        }
    }

    /// The re-tuned model.
    pub(super) fn retuned(&self) -> Candidate {
        self.search().retune().unwrap()
    }

    /// These formulas fitted together.
    pub(super) fn with(&self, picks: &[(usize, usize)]) -> Candidate {
        let search = self.search();
        let formulas = search.formulas(picks);
        let chain = self.base.compose(&formulas);
        let mut theta = vec![0.0; chain.parameters.len()];
        let own: Vec<f64> = formulas
            .iter()
            .flat_map(|f| f.parameters.iter().zip(&f.starts[0]).map(|(p, v)| p.coordinate(*v)))
            .collect();
        let base = theta.len() - own.len();
        theta[base..].copy_from_slice(&own);
        let fit = search.fitter().fit(&chain, &theta).unwrap();
        search.candidate(picks.to_vec(), chain, fit).unwrap()
    }

    /// The first formulas of these families fitted together.
    pub(super) fn families(&self, families: &[usize]) -> Candidate {
        self.with(&families.iter().map(|family| (*family, 0)).collect::<Vec<_>>())
    }
}

/// Families of a set, in its order.
pub(super) fn names(candidate: &Candidate) -> Vec<usize> {
    candidate.picks.iter().map(|(family, _)| *family).collect()
}

/// Families of a list, in its order.
pub(super) fn listed(looked: &[RankedFamily]) -> Vec<usize> {
    looked.iter().map(|l| l.family).collect()
}

#[track_caller]
pub(super) fn close(is: f64, wanted: f64, by: f64) {
    assert!((is - wanted).abs() <= by, "{is}, not {wanted}");
}
