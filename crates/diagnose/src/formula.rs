//! How an effect may act: where on the path, by which block, with which free numbers.

use std::borrow::Cow;

use model::Effect;
use surround::Force;

use crate::nuisance::Nuisance;
use crate::parameter::Parameter;
use crate::path_block::PathBlock;

/// Where on the path a block goes in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Slot {
    /// First of all.
    Command,
    /// Behind the timing.
    Amplifier,
    /// Right before the actuator.
    BeforeActuator,
    /// Right behind the actuator.
    AfterActuator,
    /// Behind creep and whatever else belongs to the actuator.
    BeforeMechanics,
    /// Behind the mechanics.
    AfterMechanics,
    /// Last of all.
    Reading,
}

impl Slot {
    /// All, in the order of the path.
    pub(crate) const ALL: [Self; 7] = [
        Self::Command,
        Self::Amplifier,
        Self::BeforeActuator,
        Self::AfterActuator,
        Self::BeforeMechanics,
        Self::AfterMechanics,
        Self::Reading,
    ];
}

/// A block in its place.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) slot: Slot,
    pub(crate) block: PathBlock,
    /// Numbers of the formula's parameters that it takes, in its order.
    pub(crate) takes: Vec<usize>,
    /// Auxiliary column, or [`OWN_COMMAND`](crate::chain::OWN_COMMAND).
    pub(crate) aux: usize,
    /// Whether its drive is the command as it enters the model, and not what drives the actuator.
    pub(crate) of_command: bool,
}

/// A parameter of a formula.
#[derive(Clone, Debug)]
pub(crate) struct Free {
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    /// Bounds of the value.
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) log: bool,
    /// Step of the coordinate for finite differences.
    pub(crate) step: f64,
    /// Whether the output jumps where it moves.
    pub(crate) jumps: bool,
}

impl Free {
    /// A positive value over decades.
    pub(crate) fn log(name: &'static str, unit: &'static str, low: f64, high: f64) -> Self {
        Self { name, unit, low, high, log: true, step: 0.02, jumps: false }
    }

    /// A value of either sign, of about this size.
    pub(crate) fn linear(name: &'static str, unit: &'static str, low: f64, high: f64) -> Self {
        let step = 1e-3 * (high - low).min(1.0);
        Self { name, unit, low, high, log: false, step, jumps: false }
    }

    pub(crate) fn step(mut self, step: f64) -> Self {
        self.step = step;
        self
    }

    /// As one of steps over a range, or of their phase, of which the next parameter is.
    pub(crate) fn jumps(mut self) -> Self {
        self.jumps = true;
        self
    }

    /// The coordinate of a value.
    pub(crate) fn coordinate(&self, value: f64) -> f64 {
        if self.log { value.ln() } else { value }
    }

    pub(crate) fn to_parameter(&self) -> Parameter {
        Parameter {
            name: self.name.to_owned(),
            unit: self.unit.to_owned(),
            low: self.coordinate(self.low),
            high: self.coordinate(self.high),
            log: self.log,
            step: self.step,
            jumps: self.jumps,
            prior: 0.0,
            node: 0,
            is_base: false,
        }
    }
}

/// One way in which an effect may act.
#[derive(Clone, Debug)]
pub(crate) struct Formula {
    pub(crate) name: Cow<'static, str>,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) parameters: Vec<Free>,
    /// Values to start from.
    pub(crate) starts: Vec<Vec<f64>>,
    /// Number of leading parameters that the first-order test varies.
    pub(crate) screened: usize,
    /// Whether a fit starts where the first-order test takes these: weights, without which the others say nothing.
    pub(crate) starts_at_promise: bool,
    /// The parameter that is the frequency of a resonance, which may be seen in what is left.
    pub(crate) resonance: Option<usize>,
    pub(crate) nuisance: Option<Nuisance>,
    /// Parameters of the model that lose their tolerance.
    pub(crate) releases: Vec<usize>,
    /// Force on the mode, with centre and half range of its displacement.
    pub(crate) force: Option<(Force, f64, f64)>,
    /// Whether it changes what the model's own parameters do so much that their sensitivities without it lead
    /// nowhere, or its own change so much that a quick fit ends on the way.
    pub(crate) is_fitted_anew: bool,
    /// A further mode of the coupling of several axes: whether the own path moves it, too.
    pub(crate) joint_mode: Option<bool>,
    /// Whether it is no candidate and only stands in for one that no component of a blueprint can be.
    pub(crate) is_stand_in: bool,
    /// Whether the bounds of its parameters are those of the effect: a fit that ends at one imitates another effect.
    pub(crate) ends_inside: bool,
    /// Whether it is what another formula is, unless there is a further effect.
    pub(crate) is_beside_others: bool,
}

impl Formula {
    pub(crate) fn new(name: &'static str) -> Self {
        Self {
            name: name.into(),
            pieces: Vec::new(),
            parameters: Vec::new(),
            starts: Vec::new(),
            screened: usize::MAX,
            starts_at_promise: false,
            resonance: None,
            nuisance: None,
            releases: Vec::new(),
            force: None,
            is_fitted_anew: false,
            joint_mode: None,
            is_stand_in: false,
            ends_inside: false,
            is_beside_others: false,
        }
    }

    /// With a block that takes these parameters.
    pub(crate) fn block(
        mut self,
        slot: Slot,
        block: impl Into<PathBlock>,
        parameters: Vec<Free>,
    ) -> Self {
        let first = self.parameters.len();
        let takes = (first..first + parameters.len()).collect();
        self.parameters.extend(parameters);
        self.sharing(slot, block, takes)
    }

    /// With a block that takes these of the parameters that there are.
    pub(crate) fn sharing(
        mut self,
        slot: Slot,
        block: impl Into<PathBlock>,
        takes: Vec<usize>,
    ) -> Self {
        let block = block.into();
        self.pieces.push(Piece { slot, block, takes, aux: 0, of_command: false });
        self
    }

    /// With the auxiliary column of this number for the last block.
    pub(crate) fn aux(mut self, aux: usize) -> Self {
        if let Some(piece) = self.pieces.last_mut() {
            piece.aux = aux;
        }
        self
    }

    /// With the command as the drive of the last block.
    pub(crate) fn of_command(mut self) -> Self {
        if let Some(piece) = self.pieces.last_mut() {
            piece.of_command = true;
        }
        self
    }

    pub(crate) fn start(mut self, values: &[f64]) -> Self {
        self.starts.push(values.to_vec());
        self
    }

    pub(crate) fn starts(mut self, all: impl IntoIterator<Item = Vec<f64>>) -> Self {
        self.starts.extend(all);
        self
    }

    pub(crate) fn screened(mut self, count: usize) -> Self {
        self.screened = count;
        self
    }

    /// With the frequency of a resonance as parameter number `at`.
    pub(crate) fn resonates(mut self, at: usize) -> Self {
        self.resonance = Some(at);
        self
    }

    /// Values to start from, with these frequencies of resonances beside its own.
    pub(crate) fn starts_with(&self, frequencies: &[f64]) -> Vec<Vec<f64>> {
        let mut all = self.starts.clone();
        if let (Some(at), Some(first)) = (self.resonance, self.starts.first()) {
            let free = &self.parameters[at];
            let inside = frequencies.iter().filter(|f| **f > free.low && **f < free.high);
            all.extend(inside.map(|f| {
                let mut start = first.clone();
                start[at] = *f;
                start
            }));
        }
        all
    }

    /// As one whose fit must end inside the bounds of its parameters.
    pub(crate) fn inside(mut self) -> Self {
        self.ends_inside = true;
        self
    }

    /// As a formula that differs from another one only beside a further effect.
    pub(crate) fn beside_others(mut self) -> Self {
        self.is_beside_others = true;
        self
    }

    /// As a formula that only stands in for others.
    pub(crate) fn stand_in(mut self) -> Self {
        self.is_stand_in = true;
        self
    }

    /// Whether it is a line of a frequency that is its own, in every record by itself.
    pub(crate) fn is_of_its_own(&self) -> bool {
        match &self.nuisance {
            Some(Nuisance::Lines { .. }) => self.parameters.first().is_some_and(|p| p.log),
            other => other.as_ref().is_some_and(Nuisance::is_free_course),
        }
    }

    /// Coefficients that are fitted: parameters, released ones, and those of each record.
    pub(crate) fn freedom(&self, records: usize) -> usize {
        let per_record = self.nuisance.as_ref().map_or(0, Nuisance::count);
        self.parameters.len() + self.releases.len() + per_record * records
    }
}

/// Where the position of a range is farthest from zero: forces on a mode are given there.
pub(crate) fn far_end(centre: f64, half: f64) -> f64 {
    centre.abs() + half
}

/// All formulas of one effect.
#[derive(Clone, Debug)]
pub(crate) struct Family {
    pub(crate) effect: &'static Effect,
    pub(crate) formulas: Vec<Formula>,
    /// What the formulas become where nothing of the effect itself is in them; they must be better than each.
    pub(crate) nulls: Vec<Formula>,
}

impl Family {
    pub(crate) fn new(effect: &'static Effect, formulas: Vec<Formula>) -> Self {
        Self { effect, formulas, nulls: Vec::new() }
    }
}
