//! The repair of a black box: effects around the FMU, as a [`Repair`] and as a package.

mod package;
mod preset;

use cosim::Fmu;
use data::NameMap;
use modeldescription::variable::Causality;
use surround::{Block, Change, Effect, Original, Parameter, Piece, Port, Repair, Side, Variable};

use crate::answer::scale_of;
use crate::base::compose::GAIN;
use crate::black_box::inner_step;
use crate::chain::OWN_COMMAND;
use crate::error::Error;
use crate::formula::{Formula, Slot, far_end};
use crate::left_out::{part_stays_out, stays_out};
use crate::outcome::Outcome;
pub use package::Repaired;
pub(crate) use package::pack;
pub use preset::preset;

/// Place of the re-tuned gain, behind everything.
const LAST: u32 = 1000;

/// Puts the repair together; beside it what stays out of it, one sentence each.
pub(crate) fn repair(
    outcomes: &[Outcome],
    fmu: &Fmu,
    names: &NameMap,
    sha256: &str,
) -> Result<(Repair, Vec<String>), Error> {
    let mut maker = Maker::new(outcomes, fmu, names, sha256)?;
    let mut order: Vec<usize> = (0..outcomes.len()).collect();
    let size = |k: &usize| outcomes[*k].found.base.judged.held_out;
    order.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.cmp(b)));
    for k in &order {
        maker.effects(&outcomes[*k])?;
    }
    for (rank, k) in order.iter().enumerate() {
        maker.retune(&outcomes[*k], rank == 0)?;
    }
    for k in &order {
        maker.steps(&outcomes[*k])?;
    }
    maker.finish()
}

struct Maker<'a> {
    outcomes: &'a [Outcome],
    fmu: &'a Fmu,
    names: &'a NameMap,
    repair: Repair,
    next: u32,
    notes: Vec<String>,
}

/// The FMU inside, with nothing changed yet.
fn unchanged(fmu: &Fmu, sha256: &str, step: f64, divide: bool) -> Repair {
    let description = fmu.description();
    let common = description.co_simulation.as_ref().map(|cs| &cs.common);
    let original = Original {
        fmi: description.fmi_version.text().to_owned(),
        identifier: common.map(|common| common.model_identifier.clone()).unwrap_or_default(),
        token: description.instantiation_token.clone(),
        sha256: sha256.to_owned(),
    };
    let sizes = [Causality::Input, Causality::Output, Causality::Parameter]
        .into_iter()
        .flat_map(|causality| fmu.names(causality))
        .filter_map(|name| fmu.place(&name).ok())
        .filter(|(_, index, size)| *index == 0 && *size > 1)
        .map(|(reference, _, size)| (reference, size))
        .collect();
    Repair {
        format: surround::FORMAT,
        token: String::new(),
        step,
        divide,
        original,
        inputs: Vec::new(),
        outputs: Vec::new(),
        changes: Vec::new(),
        effects: Vec::new(),
        sizes,
        presets: Vec::new(),
    }
}

impl<'a> Maker<'a> {
    fn new(
        outcomes: &'a [Outcome],
        fmu: &'a Fmu,
        names: &'a NameMap,
        sha256: &str,
    ) -> Result<Self, Error> {
        let description = fmu.description();
        let co_simulation = description.co_simulation.as_ref();
        let step = outcomes.iter().map(|o| o.task.data.sample_time).fold(f64::INFINITY, f64::min);
        let own_step = inner_step(description);
        let any_step =
            co_simulation.is_some_and(|cs| cs.can_handle_variable_communication_step_size);
        let divide = any_step || own_step.is_none_or(|own| own <= step * (1.0 + 1e-6));
        let repair = unchanged(fmu, sha256, step, divide);
        let last = description.variables.iter().map(|v| v.value_reference).max().unwrap_or(0);
        let next = last.checked_add(1).filter(|next| u32::MAX - next > 10_000);
        Ok(Self { outcomes, fmu, names, repair, next: next.unwrap_or(0), notes: Vec::new() })
    }

    /// A value reference that no variable has.
    fn reference(&mut self) -> u32 {
        let taken =
            |r: u32| self.fmu.description().variables.iter().any(|v| v.value_reference == r);
        while taken(self.next) {
            self.next += 1;
        }
        self.next += 1;
        self.next - 1
    }

    /// The number of an input or output, which is added where it is new.
    fn port(&mut self, name: &str, is_input: bool, unit: &str) -> Result<usize, Error> {
        let ports = if is_input { &self.repair.inputs } else { &self.repair.outputs };
        if let Some(at) = ports.iter().position(|p| p.name == name) {
            return Ok(at);
        }
        let (variable, element) = self.variable(name)?;
        let parsed = model::Unit::parse(unit).unwrap_or(model::Unit::ONE);
        let port = Port {
            name: name.to_owned(),
            variable,
            element,
            own: false,
            unit: unit.to_owned(),
            factor: parsed.factor,
            offset: parsed.offset,
        };
        let ports = if is_input { &mut self.repair.inputs } else { &mut self.repair.outputs };
        ports.push(port);
        Ok(ports.len() - 1)
    }

    /// The whole variable of a name, and the place of the name in it.
    fn variable(&self, name: &str) -> Result<(Variable, usize), Error> {
        let (reference, element, size) = self.fmu.place(name)?;
        let description = self.fmu.description();
        let described = description.variables.iter().find(|v| {
            v.value_reference == reference && (v.name == name || !v.dimensions.is_empty())
        });
        Ok((Variable { reference, start: starts(described, size) }, element))
    }

    /// The auxiliary signal of a column: another input of the FMU, or a new one.
    fn auxiliary(&mut self, o: &Outcome, number: usize) -> Result<usize, Error> {
        if number == OWN_COMMAND {
            return self.port(&o.task.input, true, &o.task.command_unit);
        }
        let aux = &o.task.data.aux[number];
        let inputs = self.fmu.names(Causality::Input);
        let column = |input: &str| self.names.column(input).unwrap_or(input) == aux.name;
        if let Some(name) = inputs.iter().find(|input| column(input)) {
            let variable = self.fmu.variable(name)?;
            let unit = self.fmu.description().properties(&variable).unit;
            return self.port(name, true, &unit.unwrap_or_else(|| "1".to_owned()));
        }
        let mut name = plain(&aux.name);
        while self.fmu.description().variable(&name).is_some() {
            name.push('_');
        }
        if let Some(at) = self.repair.inputs.iter().position(|p| p.name == name) {
            return Ok(at);
        }
        let start = if aux.is_command { 0.0 } else { aux.span.centre };
        let reference = self.reference();
        self.notes.push(format!(
            "the repaired FMU has one input more, {name}: the column {} in SI units, at rest {start}",
            aux.name
        ));
        self.repair.inputs.push(Port {
            name,
            variable: Variable { reference, start: vec![start] },
            element: 0,
            own: true,
            unit: "1".to_owned(),
            factor: 1.0,
            offset: 0.0,
        });
        Ok(self.repair.inputs.len() - 1)
    }

    /// A name for an effect's variables that neither the FMU nor the repair has.
    fn name(&self, wanted: &str, o: &Outcome) -> String {
        let is_taken = |name: &str| {
            let head = format!("{name}.");
            let variables = &self.fmu.description().variables;
            self.repair.effects.iter().any(|e| e.name == name)
                || variables.iter().any(|v| v.name.starts_with(&head))
        };
        let with_output = format!("{wanted}_{}", plain(&o.task.output));
        let mut tried = vec![wanted.to_owned()];
        if self.outcomes.len() > 1 {
            tried.push(with_output);
        }
        let numbered = (2..).map(|k| format!("{wanted}_{k}"));
        let all = tried.into_iter().chain(numbered);
        all.into_iter().find(|name| !is_taken(name)).unwrap_or_else(|| wanted.to_owned())
    }

    /// The named effects of one output.
    fn effects(&mut self, o: &Outcome) -> Result<(), Error> {
        for (name, formula, values) in o.effects(&o.found.last) {
            self.effect(o, name, formula, &values)?;
        }
        Ok(())
    }

    fn effect(
        &mut self,
        o: &Outcome,
        name: &str,
        formula: &Formula,
        values: &[f64],
    ) -> Result<(), Error> {
        let mut blocks = Vec::new();
        let base = &o.task.base;
        let mode = base.mode_in(&o.found.last.chain, &o.found.last.fit.theta);
        for piece in &formula.pieces {
            // Between two clocks, or of the start of a record.
            let Some(block) = piece.block.effect().cloned() else { continue };
            let slot = place_of(piece.slot);
            let at = base.slots.get(&piece.slot).copied();
            let drive = self.port(&o.task.input, true, &o.task.command_unit)?;
            let (side, port) = match at {
                Some(0) => (Side::Input, drive),
                _ => (Side::Output, self.port(&o.task.output, false, &o.task.unit)?),
            };
            let auxiliary =
                block.reads_auxiliary().then(|| self.auxiliary(o, piece.aux)).transpose()?;
            let parameters = piece.takes.clone();
            let piece = Piece { side, port, drive, auxiliary, place: slot, parameters, block };
            // Inside, between what enters the mode and the mode.
            let inside = at.filter(|at| *at > 0 && base.mode == Some(*at));
            match inside.and(mode) {
                Some((frequency, damping)) => {
                    let before = plain_piece(&piece, Block::BeforeMode { frequency, damping });
                    let behind = plain_piece(&piece, Block::Mode { frequency, damping });
                    blocks.extend([before, piece, behind]);
                }
                None => blocks.push(piece),
            }
        }
        if let (Some((force, centre, half)), Some((frequency, damping))) = (formula.force, mode) {
            let far = far_end(centre, half);
            let piece = Piece {
                side: Side::Output,
                port: self.port(&o.task.output, false, &o.task.unit)?,
                drive: self.port(&o.task.input, true, &o.task.command_unit)?,
                auxiliary: None,
                place: place_of(Slot::BeforeMechanics),
                parameters: (0..force.count()).collect(),
                block: Block::ForcedMode { frequency, damping, force, far },
            };
            blocks.extend([plain_piece(&piece, Block::BeforeMode { frequency, damping }), piece]);
        }
        if blocks.is_empty() && formula.releases.is_empty() {
            self.notes.push(stays_out(name, formula));
            return Ok(());
        }
        let is_before = |p: &Piece| p.side == Side::Input;
        let known = self.repair.effects.iter().any(|e| {
            e.name == name
                && e.blocks.iter().any(|b| {
                    blocks.iter().any(|p| p.port == b.port && is_before(b) && is_before(p))
                })
        });
        if known {
            self.notes.push(format!(
                "{name} before the FMU was found for {} as well; it is there once, as for the output with the larger gap",
                o.task.output
            ));
            return Ok(());
        }
        let mut is_there = !formula.releases.is_empty();
        for k in &formula.releases {
            is_there &= self.is_changed(&base.parameters[*k].name)?;
        }
        if is_there {
            self.notes.push(format!(
                "{name}, as the FMU's own parameters, was found for {} as well; it is there once, as for the output \
                 with the larger gap",
                o.task.output
            ));
            if blocks.is_empty() {
                return Ok(());
            }
        }
        self.notes.extend(part_stays_out(name, formula));
        let own = self.name(name, o);
        let mut effect = Effect {
            name: own,
            description: format!("{}: {}", name.replace('_', " "), formula.name),
            enabled: true,
            reference: self.reference(),
            parameters: Vec::new(),
            blocks,
        };
        for (free, value) in formula.parameters.iter().zip(values) {
            let factor = scale_of(o, free.unit);
            let start = value / factor;
            let min = free.log.then(|| start.min(free.low / factor));
            let unit = model::unit_on_axis(free.unit, &o.task.command_unit, &o.task.unit);
            let description = format!("{}: {}", effect.name, free.name);
            let own = self.parameter(&plain(free.name), description, &unit, start);
            effect.parameters.push(Parameter { factor, min, ..own });
        }
        let number = self.repair.effects.len();
        for k in &formula.releases {
            self.change(o, *k, number, &mut effect)?;
        }
        self.repair.effects.push(effect);
        Ok(())
    }

    /// A parameter of an effect without bounds, in SI.
    fn parameter(&mut self, name: &str, description: String, unit: &str, start: f64) -> Parameter {
        let (name, unit, reference) = (name.to_owned(), unit.to_owned(), self.reference());
        Parameter { name, description, unit, factor: 1.0, start, min: None, max: None, reference }
    }

    /// A block behind the output, in this place.
    fn at_output(
        &mut self,
        o: &Outcome,
        place: u32,
        parameters: Vec<usize>,
        block: Block,
    ) -> Result<Piece, Error> {
        let drive = self.port(&o.task.input, true, &o.task.command_unit)?;
        let port = self.port(&o.task.output, false, &o.task.unit)?;
        let side = Side::Output;
        Ok(Piece { side, port, drive, auxiliary: None, place, parameters, block })
    }

    /// Whether an effect changes this parameter of the FMU already.
    fn is_changed(&self, name: &str) -> Result<bool, Error> {
        let (variable, element) = self.variable(name)?;
        let is_same =
            |c: &Change| c.variable.reference == variable.reference && c.element == element;
        Ok(self.repair.changes.iter().any(is_same))
    }

    /// A parameter of the FMU that an effect, or the re-tune, changes.
    fn change(
        &mut self,
        o: &Outcome,
        base: usize,
        number: usize,
        effect: &mut Effect,
    ) -> Result<(), Error> {
        let described = &o.task.base.parameters[base];
        let last = &o.found.last;
        let Some(at) = last.chain.own(&described.name) else { return Ok(()) };
        // Several outputs may show it; a change of one is a change for all.
        if self.is_changed(&described.name)? {
            return Ok(());
        }
        let (variable, element) = self.variable(&described.name)?;
        let parameter = effect.parameters.len();
        let name = format!("change_of_{}", plain(&described.name));
        let description = format!("is added to {}", described.name);
        let start = described.deviation * last.fit.theta[at];
        effect.parameters.push(self.parameter(&name, description, &described.unit, start));
        self.repair.changes.push(Change { variable, element, effect: number, parameter });
        Ok(())
    }

    /// Parameters that were re-tuned under their tolerance; those of the FMU itself once.
    fn retune(&mut self, o: &Outcome, with_parameters: bool) -> Result<(), Error> {
        let last = &o.found.last;
        let name = self.name("retune", o);
        let mut effect = Effect {
            name,
            description: "Parameters of the original, re-tuned under their tolerance".to_owned(),
            enabled: true,
            reference: self.reference(),
            parameters: Vec::new(),
            blocks: Vec::new(),
        };
        let number = self.repair.effects.len();
        let released = o.released(last);
        for (k, p) in o.task.base.parameters.iter().enumerate() {
            if with_parameters && p.has_tolerance && !released.contains(&k) {
                self.change(o, k, number, &mut effect)?;
            }
        }
        if let Some(k) = last.chain.own(GAIN) {
            effect.blocks.push(self.at_output(
                o,
                LAST,
                vec![effect.parameters.len()],
                Block::Factor,
            )?);
            let start = 1.0 + o.task.base.gain_tolerance * last.fit.theta[k];
            let description = format!("factor of {}", o.task.output);
            effect.parameters.push(self.parameter("gain", description, "1", start));
        }
        self.offset(o, &mut effect)?;
        self.repair.effects.push(effect);
        Ok(())
    }

    /// The offset that all records share.
    fn offset(&mut self, o: &Outcome, effect: &mut Effect) -> Result<(), Error> {
        let shared = o.offset.map_or(0.0, |offset| offset.shared);
        if shared == 0.0 {
            return Ok(());
        }
        let factor = o.task.factor;
        effect.blocks.push(self.at_output(
            o,
            LAST,
            vec![effect.parameters.len()],
            Block::Offset,
        )?);
        let description =
            format!("is added to {}: the offset that all records share", o.task.output);
        let own = self.parameter("offset", description, &o.task.unit, shared / factor);
        effect.parameters.push(Parameter { factor, ..own });
        Ok(())
    }

    /// The steps of the reading that its values show, behind everything.
    fn steps(&mut self, o: &Outcome) -> Result<(), Error> {
        let Some(steps) = o.task.steps else { return Ok(()) };
        let half = o.task.data.output_span.half;
        let piece = self.at_output(o, LAST + 1, vec![0, 1], Block::Rounding { half })?;
        let name = self.name(components::effects::SENSOR_QUANTISATION.name, o);
        let mut effect = Effect {
            description: "sensor quantisation: rounding to the steps that the readings show"
                .to_owned(),
            name,
            enabled: true,
            reference: self.reference(),
            parameters: Vec::new(),
            blocks: vec![piece],
        };
        let values = [("steps_over_the_range", 2.0 * half / steps.size), ("phase", steps.phase)];
        for (name, start) in values {
            let description = format!("{}: {}", effect.name, name.replace('_', " "));
            effect.parameters.push(self.parameter(name, description, "1", start));
        }
        self.repair.effects.push(effect);
        Ok(())
    }

    fn finish(mut self) -> Result<(Repair, Vec<String>), Error> {
        let file = |repair: &Repair| {
            repair.check().and_then(|()| repair.to_toml()).map_err(|e| Error::Model {
                model: self.fmu.description().model_name.clone(),
                message: format!("cannot be repaired: {e}"),
            })
        };
        let text = file(&self.repair)?;
        let print = report::InputFile::of_bytes("repair", surround::FILE, text.as_bytes());
        self.repair.token = print.sha256[..32].to_owned();
        Ok((self.repair, self.notes))
    }
}

/// The start values of a variable of so many values; zeros where it has none.
fn starts(variable: Option<&modeldescription::variable::Variable>, size: usize) -> Vec<f64> {
    let start = variable.and_then(|v| v.start.as_ref()?.numbers());
    let start: Vec<f64> =
        start.into_iter().flatten().map(modeldescription::variable::Number::as_f64).collect();
    match start.as_slice() {
        all if all.len() == size => start,
        [one] => vec![*one; size],
        _ => vec![0.0; size],
    }
}

/// A slot as a place in the order of the blocks.
fn place_of(slot: Slot) -> u32 {
    Slot::ALL.iter().position(|s| *s == slot).unwrap_or(0) as u32
}

/// A block without parameters where another one is.
fn plain_piece(beside: &Piece, block: Block) -> Piece {
    Piece { parameters: Vec::new(), auxiliary: None, block, ..beside.clone() }
}

/// A text as a part of a structured name.
fn plain(text: &str) -> String {
    let mut name = String::new();
    for c in text.chars() {
        if c.is_ascii_alphanumeric() {
            name.push(c);
        } else if !name.ends_with('_') && c != '\'' {
            name.push('_');
        }
    }
    let name = name.trim_matches('_').to_owned();
    if name.starts_with(|c: char| c.is_ascii_digit()) || name.is_empty() {
        return format!("x{name}");
    }
    name
}
