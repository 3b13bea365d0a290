//! The reference state machine: what each call must answer, from the standard's tables and the rules
//! of the documentation, without the code under test.

use model::{Causality, DataType, VariableTable};

use super::components::PERIOD;

/// Numbers that arguments take.
pub const NUMBERS: [f64; 18] = [
    0.0,
    1.0,
    2.0,
    50.0,
    100.0,
    -0.0,
    -1.0,
    101.0,
    1e-3,
    0.5,
    5e-324,
    1e-310,
    1e300,
    f64::MAX,
    f64::MIN,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];
/// Sizes of steps: three good ones, two too small to reach the grid, and wrong ones.
pub const STEPS: [f64; 11] =
    [1e-3, 5e-4, 3.3e-3, 1e-12, 5e-324, 0.0, -1e-3, 1e300, f64::NAN, f64::INFINITY, -0.0];
/// Places for saved states.
pub const SLOTS: usize = 3;

/// A type of variables; there are none of type String.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Real,
    Integer,
    Boolean,
    String,
}

impl Kind {
    fn data_type(self) -> Option<DataType> {
        match self {
            Self::Real => Some(DataType::Real),
            Self::Integer => Some(DataType::Integer),
            Self::Boolean => Some(DataType::Boolean),
            Self::String => None,
        }
    }
}

/// A call with arguments good or bad. Numbers are indices of [`NUMBERS`] and [`STEPS`].
#[derive(Clone, Debug)]
pub enum Op {
    Debug { category: u8 },
    SetUp { start: usize, stop: Option<usize> },
    Enter { start: usize, stop: Option<usize> },
    Exit,
    Terminate,
    Reset,
    Get { kind: Kind, references: Vec<u32>, null: bool, excess: u8 },
    Set { kind: Kind, items: Vec<(u32, usize)>, null: bool, excess: u8 },
    Save { slot: usize, null: bool },
    Restore { slot: usize },
    Free { slot: usize },
    Size { slot: usize },
    Serialize { slot: usize, short: bool },
    Deserialize { slot: usize, damage: Option<usize> },
    Derivative { unknown: u32, known: u32, seed: usize },
    OutputSlope { reference: u32, order: i32 },
    Step { ahead: usize, size: usize },
    Never { which: usize },
    Inquiry { which: usize },
    Renew,
}

/// Where a life is (FMI 2.0.5 §4.2.4, FMI 3.0.2 §4.2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    Instantiated,
    Initialization,
    Step,
    Terminated,
    Error,
}

/// Answers that are right, as bits: 1 OK, 2 Warning, 4 Discard, 8 Error.
pub type Answers = u8;
pub const OK: Answers = 1;
pub const WARNING: Answers = 2;
pub const DISCARD: Answers = 4;
pub const ERROR: Answers = 8;

/// All of an instance that a saved state holds.
#[derive(Clone, Debug)]
struct Life {
    state: State,
    time: f64,
    start: f64,
    /// Whether a start time was given.
    defined: bool,
    /// Something was set since the outputs were computed, before the first step.
    stale: bool,
    index: u64,
    values: Vec<f64>,
}

/// The reference.
pub struct Reference<'a> {
    variables: &'a VariableTable,
    /// Elements by value reference, where the version has arrays.
    arrays: Option<Vec<(u32, Vec<u32>)>>,
    life: Life,
    stop: f64,
    slots: [Option<Life>; SLOTS],
    serialized: [Option<Life>; SLOTS],
}

impl<'a> Reference<'a> {
    pub fn new(variables: &'a VariableTable, has_arrays: bool) -> Self {
        let bundles = variables.bundles().into_iter().map(|b| (b.elements[0], b.elements));
        let life = Life {
            state: State::Instantiated,
            time: 0.0,
            start: 0.0,
            defined: false,
            stale: true,
            index: 0,
            values: variables.as_slice().iter().map(|row| row.start.unwrap_or(0.0)).collect(),
        };
        Self {
            variables,
            arrays: has_arrays.then(|| bundles.collect()),
            life,
            stop: f64::INFINITY,
            slots: Default::default(),
            serialized: Default::default(),
        }
    }

    pub fn time(&self) -> f64 {
        self.life.time
    }

    /// Number of elements of these variables together.
    pub fn count(&self, references: &[u32]) -> usize {
        references.iter().map(|one| self.elements(*one).len().max(1)).sum()
    }

    fn elements(&self, reference: u32) -> Vec<u32> {
        match &self.arrays {
            None => vec![reference],
            Some(arrays) => {
                let found = arrays.iter().find(|(first, _)| *first == reference);
                found.map(|(_, elements)| elements.clone()).unwrap_or_default()
            }
        }
    }

    /// What is allowed in the present state, by the standard's marks in the order of [`State`].
    fn allowed(&self, marks: &str) -> bool {
        marks.as_bytes()[self.life.state as usize] == b'x'
    }

    /// The answers that are right; the reference is then where the call leads if it succeeds.
    /// [`settle`](Self::settle) says what came.
    pub fn expect(&mut self, op: &Op) -> Answers {
        let v3 = self.arrays.is_some();
        match op {
            Op::Debug { category } => match category {
                0 | 1 => OK,
                2 => WARNING,
                _ => ERROR,
            },
            Op::SetUp { start, stop } if !v3 => {
                if !self.allowed("x....") || !self.experiment(*start, *stop) { ERROR } else { OK }
            }
            Op::SetUp { .. } => 0,
            Op::Enter { start, stop } => {
                if !self.allowed("x....") || (v3 && !self.experiment(*start, *stop)) {
                    return ERROR;
                }
                self.life.state = State::Initialization;
                (self.life.time, self.life.stale) = (self.life.start, true);
                if self.life.defined { OK } else { WARNING }
            }
            Op::Exit => {
                if !self.allowed(".x...") {
                    return ERROR;
                }
                let rest = self.rest();
                self.life.state = State::Step;
                rest
            }
            Op::Terminate => {
                if !self.allowed("..x..") {
                    return ERROR;
                }
                self.life.state = State::Terminated;
                OK
            }
            Op::Reset => {
                let (slots, serialized) = (self.slots.clone(), self.serialized.clone());
                *self = Self { slots, serialized, ..Self::new(self.variables, v3) };
                OK
            }
            Op::Get { kind, references, null, excess } => {
                if !self.allowed(if v3 { "xxxxx" } else { ".xxxx" }) {
                    return ERROR;
                }
                let time = self.variables.len() as u32;
                let known = |reference: &u32| {
                    let first = self.elements(*reference).first().copied();
                    let row = first.and_then(|first| self.variables.get(first));
                    row.is_some_and(|row| Some(row.data_type) == kind.data_type())
                        || (v3 && *kind == Kind::Real && *reference == time)
                };
                let wrong_count = v3 && *excess > 0 && *kind != Kind::String;
                let bad = (*null && !references.is_empty())
                    || !references.iter().all(known)
                    || wrong_count;
                let nothing = *kind == Kind::String;
                let rest = match self.life.state {
                    State::Initialization if !nothing => self.rest(),
                    _ => OK,
                };
                if bad { ERROR } else { rest }
            }
            Op::Set { kind, items, null, excess } => self.set(*kind, items, *null, *excess),
            Op::Save { slot, null } => {
                if *null {
                    return ERROR;
                }
                self.slots[*slot] = Some(self.life.clone());
                OK
            }
            Op::Restore { slot } => match &self.slots[*slot] {
                Some(life) => {
                    self.life = life.clone();
                    OK
                }
                None => ERROR,
            },
            Op::Free { slot } => {
                self.slots[*slot] = None;
                OK
            }
            Op::Size { slot } => {
                if self.slots[*slot].is_some() {
                    OK
                } else {
                    ERROR
                }
            }
            Op::Serialize { slot, short } => match (&self.slots[*slot], short) {
                (Some(life), false) => {
                    self.serialized[*slot] = Some(life.clone());
                    OK
                }
                _ => ERROR,
            },
            Op::Deserialize { slot, damage } => match (&self.serialized[*slot], damage) {
                (Some(life), None) => {
                    self.slots[*slot] = Some(life.clone());
                    OK
                }
                _ => ERROR,
            },
            Op::Derivative { .. } => {
                // Which variables are good is another test's matter.
                if self.allowed(".xxxx") { OK | DISCARD | ERROR } else { ERROR }
            }
            Op::OutputSlope { .. } => {
                if self.allowed("..xxx") {
                    OK | DISCARD | ERROR
                } else {
                    ERROR
                }
            }
            Op::Step { ahead, size } => self.step(*ahead, *size),
            Op::Never { .. } => ERROR,
            Op::Inquiry { .. } if v3 => 0,
            Op::Inquiry { which } => match (self.allowed("..xx."), which % 4) {
                (false, _) => ERROR,
                (true, 0 | 1) => OK,
                _ => DISCARD,
            },
            Op::Renew => {
                *self = Self::new(self.variables, v3);
                OK
            }
        }
    }

    /// What came: after an error the instance is in the state Error. Success where both were right
    /// leaves the reference where [`expect`](Self::expect) led it.
    pub fn settle(&mut self, came: Answers) {
        if came == ERROR {
            self.life.state = State::Error;
        }
    }

    fn experiment(&mut self, start: usize, stop: Option<usize>) -> bool {
        let (start, stop) = (NUMBERS[start], stop.map(|stop| NUMBERS[stop]));
        let sound = start.is_finite() && stop.is_none_or(|stop| stop.is_finite() && stop >= start);
        if sound {
            (self.life.start, self.life.defined) = (start, true);
            self.stop = stop.unwrap_or(f64::INFINITY);
        }
        sound
    }

    fn value(&self, name: &str) -> f64 {
        self.variables.find(name).map_or(0.0, |reference| self.life.values[reference as usize])
    }

    /// Answers of a computation with the present parameters: gains must not exceed their ceilings,
    /// and huge ones may lead to infinite outputs.
    fn computes(&self) -> Answers {
        let mut answers = OK;
        for axis in 1..=2 {
            let gain = self.value(&format!("axis[{axis}].lag.gain"));
            if gain > self.value(&format!("axis[{axis}].lag.ceiling")) {
                return ERROR;
            }
            if gain.abs().max(self.value(&format!("command[{axis}]")).abs()) > 1e290 {
                answers |= ERROR;
            }
        }
        answers
    }

    fn rest(&mut self) -> Answers {
        if !self.life.stale {
            return OK;
        }
        let answers = self.computes();
        (self.life.stale, self.life.index) = (false, 0);
        answers
    }

    fn set(&mut self, kind: Kind, items: &[(u32, usize)], null: bool, excess: u8) -> Answers {
        let v3 = self.arrays.is_some();
        let in_step = self.life.state == State::Step;
        if !self.allowed("xxx..") || (null && !items.is_empty()) {
            return ERROR;
        }
        if v3 && excess > 0 && kind != Kind::String {
            return ERROR;
        }
        let mut all = Vec::new();
        for (reference, number) in items {
            let elements = self.elements(*reference);
            if elements.is_empty() {
                return ERROR;
            }
            for element in elements {
                let Some(row) = self.variables.get(element) else { return ERROR };
                let value = match kind {
                    Kind::Real => NUMBERS[*number],
                    Kind::Integer => f64::from(*number as u32),
                    _ => f64::from(u8::from(number % 2 == 1)),
                };
                let settable = match row.causality {
                    Causality::Input | Causality::TunableParameter => true,
                    Causality::FixedParameter => !in_step,
                    _ => false,
                };
                // The bounds of an input tell what the machine is made for; they may be passed.
                let inside =
                    row.causality == Causality::Input || (value >= row.min && value <= row.max);
                if Some(row.data_type) != kind.data_type()
                    || !settable
                    || !value.is_finite()
                    || !inside
                {
                    return ERROR;
                }
                all.push((element, value));
            }
        }
        for (element, value) in all {
            self.life.values[element as usize] = value;
        }
        // A call without variables of a type that there is counts as a change, too.
        self.life.stale |= !in_step && kind != Kind::String;
        OK
    }

    fn step(&mut self, ahead: usize, size: usize) -> Answers {
        if !self.allowed("..x..") {
            return ERROR;
        }
        let time = self.life.time + [0.0, 1.0, f64::NAN, f64::NEG_INFINITY][ahead];
        let size = STEPS[size];
        let end = time + size;
        let near = |at: f64| 1e-9 * at.abs() + 1e-5 * size;
        let sound = size > 0.0
            && size.is_finite()
            && (time - self.life.time).abs() <= near(self.life.time)
            && (end <= self.stop || end <= self.stop + near(self.stop))
            && end.abs() <= 0.01 * PERIOD / f64::EPSILON;
        if !sound {
            return ERROR;
        }
        let limit = end + (1e-9 * PERIOD).max(4.0 * f64::EPSILON * end.abs());
        let mut hits = 0;
        while self.life.start + (self.life.index + 1) as f64 * PERIOD <= limit {
            self.life.index += 1;
            hits += 1;
        }
        self.life.time = end;
        if hits == 0 {
            return OK;
        }
        let faulty = (1..=2).any(|axis| self.value(&format!("axis[{axis}].lag.fault")) >= 1.0);
        // Between 1 and 2 the fault does nothing.
        let exact = (1..=2).any(|axis| {
            let fault = self.value(&format!("axis[{axis}].lag.fault"));
            fault == 1.0 || fault == 2.0
        });
        if faulty && exact { ERROR } else { self.computes() }
    }
}
