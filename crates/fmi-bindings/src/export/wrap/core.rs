//! One instance of a repaired FMU, whatever the version of the standard.

use std::any::Any;
use std::ffi::{CStr, CString, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

use surround::Surround;

use crate::export::guard::{self, Notice};
use crate::export::log::{Sink, finished};
use crate::fmi2::fmi2Status;
use crate::fmi3::fmi3Status;

/// Status of a call as a number; both versions count alike.
pub(super) type Code = u32;

pub(super) const OK: Code = 0;
const WARNING: Code = 1;
pub(super) const DISCARD: Code = 2;
pub(super) const ERROR: Code = 3;

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

/// Where an instance is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Phase {
    Instantiated = 0,
    Initialization = 1,
    Step = 2,
}

/// An instance: the original with effects around it.
pub(super) struct Wrapped<O> {
    pub(super) original: O,
    pub(super) surround: Surround,
    pub(super) sink: Sink,
    pub(super) name: CString,
    pub(super) phase: Phase,
    /// A value was set in the initialization mode: the outputs do not follow it yet.
    stale: bool,
    /// As `stale`, of one of the repair's own variables.
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

/// Carries out one call; what goes wrong is told to the host.
///
/// # Safety
/// `pointer` is null or an instance of this library that is not freed, and no other thread uses it.
pub(super) unsafe fn call<O>(
    pointer: *mut c_void,
    function: &str,
    body: impl FnOnce(&mut Wrapped<O>) -> Answer,
) -> Code {
    let wrapped = pointer.cast::<Wrapped<O>>();
    if wrapped.is_null() {
        return ERROR;
    }
    let answer = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: not null, alive and used by this thread only, as the caller promises.
        body(unsafe { &mut *wrapped })
    }));
    let notice = match answer {
        Ok(Ok(code)) => return code,
        Ok(Err(notice)) => notice,
        Err(payload) => panicked(payload),
    };
    // SAFETY: as above; the borrow of the body has ended.
    let (sink, name) = unsafe { ((*wrapped).sink, &(*wrapped).name) };
    send(sink, name, notice.status as Code, &format!("{function}: {}", notice.message));
    notice.status as Code
}

/// A panic as an error, by way of what the guard does.
fn panicked(payload: Box<dyn Any + Send>) -> Notice {
    match guard::without_instance::<()>(|| std::panic::resume_unwind(payload)) {
        Err(notice) => notice,
        Ok(()) => Notice::error("internal defect"),
    }
}

/// Sends a message of the repair.
pub(super) fn send(sink: Sink, name: &CStr, code: Code, message: &str) {
    match sink {
        Sink::None => {}
        Sink::V2 { callback, environment } => {
            let text = finished(message, true);
            // SAFETY: the importer's function with the signature of the standard; all texts end with
            // a zero byte and live until it returns; the format has no directives.
            unsafe {
                callback(
                    environment,
                    name.as_ptr(),
                    fmi2Status(code),
                    CATEGORY.as_ptr(),
                    text.as_ptr(),
                );
            }
        }
        Sink::V3 { callback, environment } => {
            let text = finished(message, false);
            // SAFETY: as above.
            unsafe { callback(environment, fmi3Status(code), CATEGORY.as_ptr(), text.as_ptr()) };
        }
    }
}

impl<O: Original> Wrapped<O> {
    pub(super) fn new(original: O, surround: Surround, sink: Sink, name: CString) -> Self {
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

    /// The same, if a value was set since.
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
            let (done, is_whole) = self.original.step(at(k), part);
            code = code.max(done);
            if code > WARNING {
                self.surround.undo(dt);
                return code;
            }
            code = code.max(self.pull_outputs());
            self.surround.step_outputs(dt);
            if code > WARNING || !is_whole {
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
        bytes[24..HEAD].copy_from_slice(&(self.phase as u64).to_le_bytes());
        let places = bytes[HEAD..].chunks_exact_mut(8);
        places.zip(&self.numbers).for_each(|(b, v)| b.copy_from_slice(&v.to_le_bytes()));
        let sum = checksum(token, &bytes[16..]);
        bytes[8..16].copy_from_slice(&sum.to_le_bytes());
    }

    /// Reads itself; also the place where the original's bytes begin.
    pub(super) fn read(token: &str, bytes: &[u8]) -> Option<(Self, usize)> {
        let word = |at: usize| Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?));
        if bytes.get(..8)? != MAGIC || word(8)? != checksum(token, bytes.get(16..)?) {
            return None;
        }
        let count = usize::try_from(word(16)?).ok()?;
        let phase = match word(24)? {
            0 => Phase::Instantiated,
            1 => Phase::Initialization,
            2 => Phase::Step,
            _ => return None,
        };
        let end = HEAD.checked_add(count.checked_mul(8)?)?;
        let numbers = bytes.get(HEAD..end)?.chunks_exact(8);
        let numbers = numbers.filter_map(|b| Some(f64::from_le_bytes(b.try_into().ok()?)));
        Some((Self { numbers: numbers.collect(), phase }, end))
    }
}

/// FNV-1a, 64 bit, of the FMU's token and the bytes.
fn checksum(token: &str, bytes: &[u8]) -> u64 {
    token.bytes().chain(bytes.iter().copied()).fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
