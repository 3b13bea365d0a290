//! Components as blocks: what a diagnosis finds, the blueprint that it writes and the repaired FMU step the same code.

use model::{Component, Tick};

use crate::kernel::{Law, Signals, Step, Stepped, Wires};
use crate::state::State;

/// A component without structure of P parameters, K coefficients and N states, on the path, or on the path and the
/// drive. No number comes out where it does not take the parameters.
pub(crate) struct Own<C: 'static, const P: usize, const K: usize, const N: usize> {
    component: &'static C,
    parameters: [f64; P],
    coefficients: [f64; K],
    is_taken: bool,
    reads_drive: bool,
    dt: f64,
}

impl<C: 'static, const P: usize, const K: usize, const N: usize> Clone for Own<C, P, K, N> {
    fn clone(&self) -> Self {
        Self { ..*self }
    }
}

impl<C: Component, const P: usize, const K: usize, const N: usize> Own<C, P, K, N> {
    /// With these values of its parameters in SI.
    pub(crate) fn new(component: &'static C, parameters: [f64; P]) -> Self {
        let sizes = component.sizes(&[], 1.0);
        debug_assert_eq!((sizes.coefficients, sizes.states), (K, N));
        let reads_drive = component.declaration().inputs.len() > 1;
        let coefficients = [0.0; K];
        Self { component, parameters, coefficients, is_taken: false, reads_drive, dt: 0.0 }
    }

    /// What comes out of a call of the component.
    #[inline]
    fn call(&self, w: Wires, with: impl FnOnce(&C, &[f64], &[f64], &mut [f64])) -> f64 {
        let mut y = [f64::NAN];
        let inputs = [w.x, w.drive];
        if self.is_taken {
            let count = if self.reads_drive { 2 } else { 1 };
            with(self.component, &self.coefficients, &inputs[..count], &mut y);
        }
        y[0]
    }
}

impl<C: Component, const P: usize, const K: usize, const N: usize> Step<N> for Own<C, P, K, N> {
    fn set_step(&mut self, dt: f64) {
        self.dt = dt;
        let Self { component, parameters, coefficients, .. } = self;
        self.is_taken = component.prepare(&[], parameters, dt, coefficients).is_ok();
    }

    #[inline]
    fn rest(&self, w: Wires) -> ([f64; N], f64) {
        let mut z = [0.0; N];
        let y = self.call(w, |component, coefficients, u, y| {
            component.rest(coefficients, u, &mut z, y);
        });
        (z, y)
    }

    #[inline]
    fn step(&self, w: Wires, t: f64, z: &mut [f64; N]) -> f64 {
        let tick = Tick { index: (t / self.dt).round() as u64, time: t, period: self.dt };
        self.call(w, |component, coefficients, u, y| component.step(coefficients, z, tick, u, y))
    }

    fn is_map(&self) -> bool {
        N == 0 && !self.reads_drive
    }

    fn components(&self) -> Vec<Stepped<'_>> {
        vec![Stepped { component: self.component, structure: &[], parameters: &self.parameters }]
    }
}

/// One law without memory behind another.
#[derive(Clone)]
pub(crate) struct Behind<A, B>(pub(crate) A, pub(crate) B);

impl<A: Step<0>, B: Step<0>> Step<0> for Behind<A, B> {
    fn set_step(&mut self, dt: f64) {
        self.0.set_step(dt);
        self.1.set_step(dt);
    }

    fn rest(&self, w: Wires) -> ([f64; 0], f64) {
        let ([], x) = self.0.rest(w);
        self.1.rest(Wires { x, ..w })
    }

    #[inline]
    fn step(&self, w: Wires, t: f64, z: &mut [f64; 0]) -> f64 {
        let x = self.0.step(w, t, z);
        self.1.step(Wires { x, ..w }, t, z)
    }

    fn components(&self) -> Vec<Stepped<'_>> {
        [self.0.components(), self.1.components()].concat()
    }
}

/// Equal laws in series, each with one number as its state.
#[derive(Clone)]
pub(crate) struct Series<L>(pub(crate) Vec<L>);

impl<C: Component, const P: usize, const K: usize> Law for Series<Own<C, P, K, 1>> {
    fn set_step(&mut self, dt: f64) {
        self.0.iter_mut().for_each(|law| law.set_step(dt));
    }

    fn rest(&self, w: Wires, state: &mut State) -> f64 {
        self.0.iter().fold(w.x, |x, law| {
            let (z, y) = law.rest(Wires { x, ..w });
            state.z.extend(z);
            y
        })
    }

    fn step(&self, w: Wires, t: f64, state: &mut State) -> f64 {
        let (z, _) = state.z.as_chunks_mut();
        self.0.iter().zip(z).fold(w.x, |x, (law, z)| law.step(Wires { x, ..w }, t, z))
    }

    fn run(&self, signals: Signals<'_>, dt: f64, out: &mut [f64]) {
        out.iter_mut().zip(signals.x).for_each(|(y, x)| *y = *x);
        for law in &self.0 {
            let Some((first, out)) = out.split_first_mut() else { return };
            let wires = |x| Wires { x, ..Wires::default() };
            let (mut z, y) = law.rest(wires(*first));
            *first = y;
            let mut t = 0.0;
            for y in out {
                t += dt;
                *y = law.step(wires(*y), t, &mut z);
            }
        }
    }

    fn states(&self) -> usize {
        self.0.len()
    }

    fn components(&self) -> Vec<Stepped<'_>> {
        self.0.iter().flat_map(Step::components).collect()
    }

    fn boxed(&self) -> Box<dyn Law> {
        Box::new(self.clone())
    }
}
