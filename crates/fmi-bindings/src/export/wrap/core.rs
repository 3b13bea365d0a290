//! One instance of a repaired FMU, whatever the version of the standard.

use std::ffi::{CStr, CString, c_void};

use surround::Surround;

use crate::export::Phase;
use crate::export::guard::{self, Guarded};
use crate::export::log::Sink;
use crate::export::notice::{Notice, Status};

/// Status of a call as a number; both versions count alike, and the original may return others than [`Status`].
pub(super) type Code = u32;

pub(super) const OK: Code = Status::Ok as Code;
const WARNING: Code = Status::Warning as Code;
pub(super) const DISCARD: Code = Status::Discard as Code;

/// What comes of a call: the original's status, or why there is none.
pub(super) type Answer = Result<Code, Notice>;

/// The category of the repair's own messages.
pub(super) const CATEGORY: &CStr = c"repair";

/// The original, as far as effects need it.
pub(super) trait Original {
    /// Reads Real or Float64 variables.
    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Code;
    /// Sets Real or Float64 variables.
    fn set(&mut self, references: &[u32], values: &[f64]) -> Code;
    /// Does one step; says whether it went to its end.
    fn step(&mut self, time: f64, step: f64) -> (Code, bool);
}

/// An instance: the original with effects around it.
pub(super) struct Wrapped<O> {
    pub(super) original: O,
    pub(super) surround: Surround,
    sink: Sink,
    name: CString,
    /// One of [`PHASES`]; which call is allowed when, the original knows.
    pub(super) phase: Phase,
    /// A value was set in the initialization mode: the outputs do not follow it yet.
    stale: bool,
    /// One of the repair's own variables was set: the original has not got what follows from it yet.
    is_touched: bool,
    references: Vec<u32>,
    values: Vec<f64>,
    /// Status of giving the original its start values.
    preset: Code,
    /// Saved states that the host has not freed.
    pub(super) saved: Vec<*mut Saved>,
}

/// A saved state.
pub(super) struct Saved {
    pub(super) inner: *mut c_void,
    pub(super) effects: EffectState,
}

/// The part of a saved state that is not the original's.
#[derive(Clone)]
pub(super) struct EffectState {
    numbers: Vec<f64>,
    phase: Phase,
}

/// The phases of an instance; a serialised state holds the place of its own here.
const PHASES: [Phase; 3] = [Phase::Instantiated, Phase::Initialization, Phase::Step];

impl<O> Guarded for Wrapped<O> {
    fn send(&self, status: Status, message: &str) {
        self.sink.send(&self.name, status, CATEGORY, message);
    }
}

/// Carries out one call.
///
/// # Safety
/// The contract of [`guard::call`].
pub(super) unsafe fn call<O>(
    pointer: *mut c_void,
    function: &str,
    body: impl FnOnce(&mut Wrapped<O>) -> Answer,
) -> Code {
    // SAFETY: as the caller promises.
    unsafe { guard::call(pointer, function, body) }.unwrap_or_else(|status| status as Code)
}

/// Hands out the instance that `body` makes; null where it makes none, and the host has the reason.
pub(super) fn instantiate<O: Original>(
    function: &str,
    name: Option<&CStr>,
    sink: Sink,
    body: impl FnOnce() -> Result<(O, Surround), Notice>,
) -> *mut c_void {
    let name = name.unwrap_or(c"");
    let created = guard::caught(|| {
        let (original, surround) = body()?;
        Ok(Box::new(Wrapped::new(original, surround, sink, name.into())))
    });
    let refused = |notice: Notice| {
        let message = format!("{function}: {}", notice.message);
        sink.send(name, notice.status, CATEGORY, &message);
        std::ptr::null_mut()
    };
    created.map_or_else(refused, |instance| Box::into_raw(instance).cast())
}

impl<O: Original> Wrapped<O> {
    fn new(original: O, surround: Surround, sink: Sink, name: CString) -> Self {
        let mut wrapped = Self {
            original,
            surround,
            sink,
            name,
            phase: Phase::Instantiated,
            stale: true,
            is_touched: false,
            references: Vec::new(),
            values: Vec::new(),
            saved: Vec::new(),
            preset: OK,
        };
        wrapped.give_presets();
        wrapped
    }

    /// Gives the original the start values that it was packed with.
    fn give_presets(&mut self) {
        let presets = &self.surround.repair().presets;
        let codes = presets.iter().map(|v| self.original.set(&[v.reference], &v.start));
        self.preset = codes.max().unwrap_or(OK);
    }

    /// The error of an original that has not taken them.
    pub(super) fn preset(&self) -> Result<(), Notice> {
        if self.preset <= WARNING {
            return Ok(());
        }
        Err(Notice::error(
            "the original inside does not take the start values that it was packed with",
        ))
    }

    /// Whether a list of variables concerns the repair.
    pub(super) fn is_ours(&self, references: &[u32]) -> bool {
        references.iter().any(|r| self.surround.is_ours(*r))
    }

    /// Reads Real or Float64 variables of which some are the repair's business.
    pub(super) fn get(&mut self, references: &[u32], out: &mut [f64]) -> Answer {
        self.measure(references, out.len())?;
        let is_active = self.surround.is_active();
        if is_active && self.stale && self.phase == Phase::Initialization {
            let code = self.settle();
            if code > WARNING {
                return Ok(code);
            }
        }
        self.references.clear();
        self.references.extend(references.iter().filter(|r| !self.surround.is_own(**r)));
        let count = self.references.iter().map(|r| self.surround.size(*r)).sum();
        self.values.clear();
        self.values.resize(count, 0.0);
        let mut code = OK;
        if !self.references.is_empty() {
            code = self.original.get(&self.references, &mut self.values);
            if code > WARNING {
                return Ok(code);
            }
        }
        let (mut from, mut to) = (0, 0);
        for reference in references {
            if let Some(value) = self.surround.get(*reference) {
                out[to] = value;
                to += 1;
                continue;
            }
            let size = self.surround.size(*reference);
            let shown = if is_active { self.surround.shown(*reference) } else { None };
            let values = shown.unwrap_or(&self.values[from..from + size]);
            out[to..to + size].copy_from_slice(values);
            from += size;
            to += size;
        }
        Ok(code)
    }

    /// Sets Real or Float64 variables of which some are the repair's business.
    pub(super) fn set(&mut self, references: &[u32], values: &[f64]) -> Answer {
        self.measure(references, values.len())?;
        self.touch();
        self.references.clear();
        self.values.clear();
        let mut at = 0;
        let mut code = OK;
        for reference in references {
            let size = self.surround.size(*reference);
            let own = &values[at..at + size];
            at += size;
            if self.surround.is_own(*reference) {
                self.surround.set(*reference, own[0]).map_err(|e| Notice::error(e.to_string()))?;
                self.is_touched = true;
            } else if self.surround.is_ours(*reference) {
                if let Some(inner) = self.surround.take(*reference, own) {
                    code = code.max(self.original.set(&[*reference], inner));
                }
            } else {
                self.references.push(*reference);
                self.values.extend(own);
            }
        }
        if !self.references.is_empty() {
            code = code.max(self.original.set(&self.references, &self.values));
        }
        Ok(code)
    }

    /// A value is being set.
    pub(super) fn touch(&mut self) {
        if self.phase != Phase::Step {
            self.stale = true;
        }
    }

    /// Sets one of the repair's Booleans.
    pub(super) fn set_flag(&mut self, reference: u32, value: bool) -> Result<(), Notice> {
        self.touch();
        self.is_touched = true;
        let number = f64::from(u8::from(value));
        self.surround.set(reference, number).map_err(|e| Notice::error(e.to_string()))
    }

    /// Whether the variables have this number of values, and none is a Boolean.
    pub(super) fn measure(&self, references: &[u32], count: usize) -> Result<(), Notice> {
        if let Some(flag) = references.iter().find(|r| self.surround.is_flag(**r)) {
            return Err(Notice::error(format!(
                "value reference {flag} is a Boolean variable; use the functions for those"
            )));
        }
        let sum: usize = references.iter().map(|r| self.surround.size(*r)).sum();
        if sum == count {
            return Ok(());
        }
        Err(Notice::error(format!(
            "{count} values, but the variables have {sum} together; give exactly those"
        )))
    }

    /// Gives the original what it gets of inputs.
    fn push_inputs(&mut self) -> Code {
        let mut code = OK;
        for variable in self.surround.inputs().iter().filter(|v| !v.own) {
            code = code.max(self.original.set(&[variable.reference], &variable.inner));
        }
        code
    }

    /// Gives the original its changed parameters.
    fn push_changes(&mut self) -> Code {
        let mut code = OK;
        for variable in self.surround.changed() {
            code = code.max(self.original.set(&[variable.reference], &variable.inner));
        }
        self.is_touched = false;
        code
    }

    /// Reads the original's outputs that effects change.
    fn pull_outputs(&mut self) -> Code {
        let mut code = OK;
        for variable in self.surround.outputs() {
            code = code.max(self.original.get(&[variable.reference], &mut variable.inner));
        }
        code
    }

    /// Inputs to the original and its outputs back, at rest.
    fn settle(&mut self) -> Code {
        let mut code = OK;
        if self.is_touched {
            code = code.max(self.push_changes());
        }
        self.surround.rest_inputs();
        code = code.max(self.push_inputs());
        code = code.max(self.pull_outputs());
        if code <= WARNING {
            self.surround.rest_outputs();
            self.stale = false;
        }
        code
    }

    /// Brings inputs and outputs to rest, if a value was set since.
    pub(super) fn settle_if_stale(&mut self) -> Code {
        if self.stale { self.settle() } else { OK }
    }

    /// Before the original enters the initialization mode.
    pub(super) fn before_entering(&mut self) -> Code {
        if self.surround.is_active() { self.push_changes() } else { OK }
    }

    /// The original has entered the initialization mode.
    pub(super) fn entered(&mut self) {
        self.phase = Phase::Initialization;
        self.stale = true;
    }

    /// Before the original leaves the initialization mode.
    pub(super) fn before_leaving(&mut self) -> Code {
        if self.surround.is_active() { self.settle() } else { OK }
    }

    /// The original has left the initialization mode; some compute their outputs only now.
    pub(super) fn left(&mut self) -> Code {
        let mut code = OK;
        if self.surround.is_active() {
            code = self.pull_outputs();
            self.surround.rest_outputs();
        }
        self.surround.start();
        self.phase = Phase::Step;
        self.stale = false;
        code
    }

    /// The original was reset.
    pub(super) fn was_reset(&mut self) {
        self.surround.reset();
        self.phase = Phase::Instantiated;
        (self.stale, self.is_touched) = (true, false);
        self.give_presets();
    }

    /// Does a communication step, in parts no longer than the repair's step.
    pub(super) fn step(&mut self, time: f64, step: f64) -> Code {
        let is_usual = step > 0.0 && step.is_finite() && time.is_finite();
        if !self.surround.is_active() || self.phase != Phase::Step || !is_usual {
            return self.original.step(time, step).0;
        }
        let parts = self.surround.parts(step);
        self.surround.note_parts(parts);
        // The original's parts end where the step does; those of the effects are of one length.
        let at = |k: u32| time + step * (f64::from(k) / f64::from(parts));
        let dt = step / f64::from(parts);
        let mut code = OK;
        for k in 0..parts {
            self.surround.step_inputs(dt);
            code = code.max(self.push_inputs());
            if code > WARNING {
                self.surround.undo(dt);
                return code;
            }
            let part = if parts == 1 { step } else { at(k + 1) - at(k) };
            let (done, is_complete) = self.original.step(at(k), part);
            code = code.max(done);
            if code > WARNING {
                self.surround.undo(dt);
                return code;
            }
            code = code.max(self.pull_outputs());
            self.surround.step_outputs(dt);
            if code > WARNING || !is_complete {
                return code;
            }
        }
        code
    }

    /// What of a saved state is not the original's.
    pub(super) fn effects(&self) -> EffectState {
        EffectState { numbers: self.surround.save(), phase: self.phase }
    }

    /// Goes back to it.
    pub(super) fn restore(&mut self, effects: &EffectState) -> Result<(), Notice> {
        if !self.surround.load(&effects.numbers) {
            return Err(Notice::error("the saved state is not one of this FMU"));
        }
        self.phase = effects.phase;
        self.stale = self.phase != Phase::Step;
        Ok(())
    }
}

/// First bytes of a serialised state.
const MAGIC: [u8; 8] = *b"pzrepair";
/// Bytes before the numbers: magic, checksum, number of numbers, phase.
const HEAD: usize = 32;

impl EffectState {
    /// Number of bytes without the original's.
    pub(super) fn byte_len(&self) -> usize {
        HEAD + 8 * self.numbers.len()
    }

    /// Writes itself before the original's bytes, which are there already.
    pub(super) fn write(&self, token: &str, bytes: &mut [u8]) {
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[16..24].copy_from_slice(&(self.numbers.len() as u64).to_le_bytes());
        let phase = PHASES.iter().position(|phase| *phase == self.phase).unwrap_or_default();
        bytes[24..HEAD].copy_from_slice(&(phase as u64).to_le_bytes());
        let places = bytes[HEAD..].chunks_exact_mut(8);
        places.zip(&self.numbers).for_each(|(b, v)| b.copy_from_slice(&v.to_le_bytes()));
        let sum = sum(token, &bytes[16..]);
        bytes[8..16].copy_from_slice(&sum.to_le_bytes());
    }

    /// Reads itself; also the place where the original's bytes begin.
    pub(super) fn read(token: &str, bytes: &[u8]) -> Option<(Self, usize)> {
        let word = |at: usize| Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?));
        if bytes.get(..8)? != MAGIC || word(8)? != sum(token, bytes.get(16..)?) {
            return None;
        }
        let count = usize::try_from(word(16)?).ok()?;
        let phase = *PHASES.get(usize::try_from(word(24)?).ok()?)?;
        let end = HEAD.checked_add(count.checked_mul(8)?)?;
        let numbers = bytes.get(HEAD..end)?.chunks_exact(8);
        let numbers = numbers.filter_map(|b| Some(f64::from_le_bytes(b.try_into().ok()?)));
        Some((Self { numbers: numbers.collect(), phase }, end))
    }
}

/// Checksum of the FMU's token and the bytes.
fn sum(token: &str, bytes: &[u8]) -> u64 {
    model::fnv_64(token.bytes().chain(bytes.iter().copied()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_a_phase_in_a_serialised_state_stays() {
        for (number, phase) in PHASES.into_iter().enumerate() {
            let state = EffectState { numbers: vec![0.5, -1.0], phase };
            let mut bytes = vec![7; state.byte_len() + 3];
            state.write("token", &mut bytes);
            assert_eq!(bytes[24..HEAD], [number as u8, 0, 0, 0, 0, 0, 0, 0]);
            let (read, end) = EffectState::read("token", &bytes).unwrap();
            assert_eq!((read.phase, read.numbers, end), (phase, state.numbers, HEAD + 16));
        }
    }
}
