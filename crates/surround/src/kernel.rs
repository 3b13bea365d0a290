//! Kernels: a block with its coefficients for one step length.
//!
//! One formula serves both that step through time (a repaired FMU) and those that run whole signals (the
//! diagnosis): a [`Step`], a [`Bank`] or a [`Map`] is one effect, and the loops over it stand here. Which
//! effect it is, is asked once per call and not once per value.

use std::fmt;

use model::Component;

use crate::state::State;

/// What a block reads at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wires {
    /// The path before the block.
    pub x: f64,
    /// What drives the actuator; around an FMU its input.
    pub drive: f64,
    /// An auxiliary signal.
    pub aux: f64,
}

/// Whole signals, one value per step, of one length; the first value is that at rest.
#[derive(Clone, Copy, Debug)]
pub struct Signals<'a> {
    /// The path before the block.
    pub x: &'a [f64],
    /// What drives the actuator.
    pub drive: &'a [f64],
    /// An auxiliary signal.
    pub aux: &'a [f64],
}

impl<'a> Signals<'a> {
    /// For blocks that read nothing but the path.
    #[must_use]
    pub fn path(x: &'a [f64]) -> Self {
        Self { x, drive: x, aux: x }
    }

    pub(crate) fn wires(self) -> impl Iterator<Item = Wires> {
        let all = self.x.iter().zip(self.drive).zip(self.aux);
        all.map(|((x, drive), aux)| Wires { x: *x, drive: *drive, aux: *aux })
    }

    fn split_first(self) -> Option<(Wires, Self)> {
        let ((x, xs), (drive, drives)) = (self.x.split_first()?, self.drive.split_first()?);
        let (aux, auxs) = self.aux.split_first()?;
        Some((Wires { x: *x, drive: *drive, aux: *aux }, Self { x: xs, drive: drives, aux: auxs }))
    }

    /// The values from `from` on, at most `count`.
    fn part(self, from: usize, count: usize) -> Self {
        let of = |all: &'a [f64]| &all[from.min(all.len())..(from + count).min(all.len())];
        Self { x: of(self.x), drive: of(self.drive), aux: of(self.aux) }
    }
}

/// Another number of parameters than a block takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{given} parameters instead of {wanted}")]
pub struct WrongCount {
    /// How many were given.
    pub given: usize,
    /// How many it takes.
    pub wanted: Count,
}

/// How many parameters a block takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// This many.
    Exactly(usize),
    /// One or two.
    OneOrTwo,
    /// One or more.
    OneOrMore,
    /// Pairs, at least one.
    Pairs,
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exactly(count) => write!(f, "{count}"),
            Self::OneOrTwo => f.write_str("one or two"),
            Self::OneOrMore => f.write_str("one or more"),
            Self::Pairs => f.write_str("pairs"),
        }
    }
}

/// The parameters by place.
///
/// # Errors
/// [`WrongCount`] where there are not N of them.
pub fn exactly<const N: usize>(p: &[f64]) -> Result<[f64; N], WrongCount> {
    p.try_into().map_err(|_| WrongCount { given: p.len(), wanted: Count::Exactly(N) })
}

/// One parameter for each of `count` elements.
pub(crate) fn each(p: &[f64], count: usize) -> Result<&[f64], WrongCount> {
    if p.len() == count {
        Ok(p)
    } else {
        Err(WrongCount { given: p.len(), wanted: Count::Exactly(count) })
    }
}

/// A component with the values of its parameters in SI, as a kernel steps it.
#[derive(Clone, Copy)]
pub struct Stepped<'a> {
    /// The component.
    pub component: &'static dyn Component,
    /// Values of its structure.
    pub structure: &'a [f64],
    /// In the order of its declaration.
    pub parameters: &'a [f64],
}

/// A block with its coefficients for steps of one length. It holds nothing that changes from step to step: that
/// is the [`State`], which goes on where the length changes.
pub struct Kernel {
    law: Box<dyn Law>,
    dt: f64,
}

impl Kernel {
    pub(crate) fn new(law: impl Law + 'static, dt: f64) -> Self {
        let mut law: Box<dyn Law> = Box::new(law);
        law.set_step(dt);
        Self { law, dt }
    }

    /// Computes the coefficients for steps of another length in s, without allocation.
    pub fn set_step(&mut self, dt: f64) {
        if dt.to_bits() != self.dt.to_bits() {
            self.law.set_step(dt);
            self.dt = dt;
        }
    }

    /// The output at rest under these inputs, and the state that belongs to it.
    pub fn rest(&self, w: Wires, state: &mut State) -> f64 {
        state.z.clear();
        state.past.clear();
        self.law.rest(w, state)
    }

    /// The output at the end of a step that ends `t` (s) after the start; the inputs are those that are held
    /// over it. The state is one of [`rest`](Self::rest).
    pub fn step(&self, w: Wires, t: f64, state: &mut State) -> f64 {
        self.law.step(w, t, state)
    }

    /// The outputs under whole signals: rest under the first values, then step by step, to the same bits as
    /// [`rest`](Self::rest) and [`step`](Self::step) with times that add up.
    pub fn run(&self, signals: Signals<'_>, out: &mut [f64]) {
        self.law.run(signals, self.dt, out);
    }

    /// What a block without memory that reads nothing but the path makes of a value; none for others.
    #[must_use]
    pub fn map(&self, x: f64) -> Option<f64> {
        self.law.map(x)
    }

    /// The components that it steps one after the other; none where the block is none.
    #[must_use]
    pub fn components(&self) -> Vec<Stepped<'_>> {
        self.law.components()
    }

    /// Whether the state is one of this kernel.
    #[must_use]
    pub fn fits(&self, state: &State) -> bool {
        state.z.len() == self.law.states() && state.past.is_empty() != self.law.has_past()
    }
}

impl Clone for Kernel {
    fn clone(&self) -> Self {
        Self { law: self.law.boxed(), dt: self.dt }
    }
}

impl fmt::Debug for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Kernel").field("dt", &self.dt).finish_non_exhaustive()
    }
}

/// What a kernel does, whatever block it is of. States come from `rest` of the same law.
pub(crate) trait Law: Send + Sync {
    /// Takes over the length of the steps in s.
    fn set_step(&mut self, dt: f64);
    /// Output at rest; the state comes empty.
    fn rest(&self, w: Wires, state: &mut State) -> f64;
    fn step(&self, w: Wires, t: f64, state: &mut State) -> f64;
    fn run(&self, signals: Signals<'_>, dt: f64, out: &mut [f64]);
    /// Numbers of a state.
    fn states(&self) -> usize;
    /// Whether a state holds past values.
    fn has_past(&self) -> bool {
        false
    }
    fn map(&self, _x: f64) -> Option<f64> {
        None
    }
    /// Components that it consists of.
    fn components(&self) -> Vec<Stepped<'_>> {
        Vec::new()
    }
    fn boxed(&self) -> Box<dyn Law>;
}

/// A map without memory, value by value.
#[derive(Clone)]
pub(crate) struct Map<F>(pub(crate) F);

impl<F: Fn(f64) -> f64 + Clone + Send + Sync + 'static> Law for Map<F> {
    fn set_step(&mut self, _dt: f64) {}

    fn rest(&self, w: Wires, _state: &mut State) -> f64 {
        (self.0)(w.x)
    }

    fn step(&self, w: Wires, _t: f64, _state: &mut State) -> f64 {
        (self.0)(w.x)
    }

    fn run(&self, signals: Signals<'_>, _dt: f64, out: &mut [f64]) {
        out.iter_mut().zip(signals.x).for_each(|(y, x)| *y = (self.0)(*x));
    }

    fn states(&self) -> usize {
        0
    }

    fn map(&self, x: f64) -> Option<f64> {
        Some((self.0)(x))
    }

    fn boxed(&self) -> Box<dyn Law> {
        Box::new(self.clone())
    }
}

/// An effect with N numbers as its state.
pub(crate) trait Step<const N: usize>: Clone + Send + Sync + 'static {
    /// Takes over the length of the steps in s.
    fn set_step(&mut self, _dt: f64) {}
    /// State and output at rest.
    fn rest(&self, w: Wires) -> ([f64; N], f64);
    /// Output at the end of a step at the time `t` in s.
    fn step(&self, w: Wires, t: f64, z: &mut [f64; N]) -> f64;
    /// Whether it has no memory and reads nothing but the path.
    fn is_map(&self) -> bool {
        false
    }
    /// Components that it consists of.
    fn components(&self) -> Vec<Stepped<'_>> {
        Vec::new()
    }
}

/// A [`Step`] as a law.
#[derive(Clone)]
pub(crate) struct Stepping<K, const N: usize>(pub(crate) K);

impl<const N: usize, K: Step<N>> Law for Stepping<K, N> {
    fn set_step(&mut self, dt: f64) {
        self.0.set_step(dt);
    }

    fn rest(&self, w: Wires, state: &mut State) -> f64 {
        let (z, y) = self.0.rest(w);
        state.z.extend(z);
        y
    }

    fn step(&self, w: Wires, t: f64, state: &mut State) -> f64 {
        let z = state.z.first_chunk_mut().expect("a state of this kernel");
        self.0.step(w, t, z)
    }

    fn run(&self, signals: Signals<'_>, dt: f64, out: &mut [f64]) {
        let (Some((w, signals)), Some((first, out))) =
            (signals.split_first(), out.split_first_mut())
        else {
            return;
        };
        let (mut z, y) = self.0.rest(w);
        *first = y;
        let mut t = 0.0;
        for (y, w) in out.iter_mut().zip(signals.wires()) {
            t += dt;
            *y = self.0.step(w, t, &mut z);
        }
    }

    fn states(&self) -> usize {
        N
    }

    fn map(&self, x: f64) -> Option<f64> {
        self.0.is_map().then(|| self.0.rest(Wires { x, ..Wires::default() }).1)
    }

    fn components(&self) -> Vec<Stepped<'_>> {
        self.0.components()
    }

    fn boxed(&self) -> Box<dyn Law> {
        Box::new(self.clone())
    }
}

/// Elements side by side, none of which waits for another: `y = direct + Σ add(element)`. Each has S numbers as
/// its state; H numbers are the state of what they share.
pub(crate) trait Bank<const H: usize, const S: usize>:
    Clone + Send + Sync + 'static
{
    /// Coefficients of an element.
    type Element: Copy + Send + Sync;
    /// What all elements are given in a step.
    type Shared: Copy;

    /// Takes over the length of the steps in s.
    fn set_step(&mut self, _dt: f64, _elements: &mut [Self::Element]) {}
    /// The shared state at rest, and that of each element before its first step.
    fn rest(&self, _w: Wires) -> ([f64; H], [f64; S]) {
        ([0.0; H], [0.0; S])
    }
    /// Brings the shared state to the end of a step.
    fn advance(&self, _w: Wires, _head: &mut [f64; H]) {}
    fn shared(&self, w: Wires, head: &[f64; H]) -> Self::Shared;
    /// What comes out without elements.
    fn direct(&self, w: Wires) -> f64 {
        w.x
    }
    /// Moves an element and returns what it adds.
    fn add(element: &Self::Element, shared: Self::Shared, z: &mut [f64; S]) -> f64;
    /// The component that it is with all its elements.
    fn component(&self) -> Option<Stepped<'_>> {
        None
    }
}

/// Rows of which whole signals' shared numbers are kept at a time: they stay in the fastest memory.
const ROWS: usize = 64;

/// A [`Bank`] with its elements as a law.
#[derive(Clone)]
pub(crate) struct Banked<K: Bank<H, S>, const H: usize, const S: usize> {
    pub(crate) bank: K,
    pub(crate) elements: Vec<K::Element>,
}

impl<const H: usize, const S: usize, K: Bank<H, S>> Banked<K, H, S> {
    /// All elements, one after the other.
    fn sum(&self, w: Wires, head: &[f64; H], elements: &mut [[f64; S]]) -> f64 {
        let shared = self.bank.shared(w, head);
        let all = self.elements.iter().zip(elements);
        all.fold(self.bank.direct(w), |y, (element, z)| y + K::add(element, shared, z))
    }

    /// Moves N elements over rows and adds what they do, side by side in registers.
    fn add_all<const N: usize>(
        elements: &[K::Element; N],
        states: &mut [[f64; S]; N],
        shared: &[K::Shared],
        out: &mut [f64],
    ) {
        let mut z = *states;
        for (y, shared) in out.iter_mut().zip(shared) {
            for (element, z) in elements.iter().zip(&mut z) {
                *y += K::add(element, *shared, z);
            }
        }
        *states = z;
    }
}

impl<const H: usize, const S: usize, K: Bank<H, S>> Law for Banked<K, H, S> {
    fn set_step(&mut self, dt: f64) {
        self.bank.set_step(dt, &mut self.elements);
    }

    fn rest(&self, w: Wires, state: &mut State) -> f64 {
        let (head, element) = self.bank.rest(w);
        state.z.extend(head);
        self.elements.iter().for_each(|_| state.z.extend(element));
        self.sum(w, &head, state.z[H..].as_chunks_mut().0)
    }

    fn step(&self, w: Wires, _t: f64, state: &mut State) -> f64 {
        let (head, elements) = state.z.split_first_chunk_mut().expect("a state of this kernel");
        self.bank.advance(w, head);
        self.sum(w, head, elements.as_chunks_mut().0)
    }

    fn run(&self, signals: Signals<'_>, _dt: f64, out: &mut [f64]) {
        let (Some((w, signals)), Some((first, out))) =
            (signals.split_first(), out.split_first_mut())
        else {
            return;
        };
        let (mut head, element) = self.bank.rest(w);
        let mut states = vec![element; self.elements.len()];
        *first = self.sum(w, &head, &mut states);
        let mut shared = [self.bank.shared(w, &head); ROWS];
        for (k, out) in out.chunks_mut(ROWS).enumerate() {
            let part = signals.part(k * ROWS, out.len());
            for ((y, shared), w) in out.iter_mut().zip(&mut shared).zip(part.wires()) {
                self.bank.advance(w, &mut head);
                *shared = self.bank.shared(w, &head);
                *y = self.bank.direct(w);
            }
            let (fours, others) = self.elements.as_chunks::<4>();
            let (z_fours, z_others) = states.as_chunks_mut::<4>();
            for (four, z) in fours.iter().zip(z_fours) {
                Self::add_all(four, z, &shared, out);
            }
            for (one, z) in others.iter().zip(z_others) {
                Self::add_all(std::array::from_ref(one), std::array::from_mut(z), &shared, out);
            }
        }
    }

    fn states(&self) -> usize {
        H + S * self.elements.len()
    }

    fn components(&self) -> Vec<Stepped<'_>> {
        self.bank.component().into_iter().collect()
    }

    fn boxed(&self) -> Box<dyn Law> {
        Box::new(self.clone())
    }
}
