//! From signals to the inputs of a model, step by step over borrowed memory: the same code makes the
//! samples of a training and runs in real time.

mod derivatives;
mod narx;
mod stops;
pub mod term;

pub use derivatives::Derivatives;
pub use narx::Narx;
pub use stops::StopOperators;

use crate::KernelSum;

/// A value in front of those that are remembered; the oldest is forgotten.
fn push(memory: &mut [f64], x: f64) {
    if let Some(last) = memory.len().checked_sub(1) {
        memory.copy_within(..last, 1);
        memory[0] = x;
    }
}

/// Which inputs a model takes.
#[derive(Clone, Debug, PartialEq)]
pub enum Features {
    /// Past commands and the model's own past outputs.
    Narx(Narx),
    /// Stop operators, the command and its rate.
    StopOperators(StopOperators),
    /// The command and its derivatives about one instant.
    Derivatives(Derivatives),
}

impl Features {
    /// Numbers of one input.
    #[must_use]
    pub fn dimension(&self) -> usize {
        match self {
            Self::Narx(narx) => narx.dimension(),
            Self::StopOperators(stops) => stops.dimension(),
            Self::Derivatives(derivatives) => derivatives.dimension(),
        }
    }

    /// Numbers of memory.
    #[must_use]
    pub fn memory(&self) -> usize {
        match self {
            Self::Narx(narx) => narx.memory(),
            Self::StopOperators(stops) => stops.memory(),
            Self::Derivatives(derivatives) => derivatives.memory(),
        }
    }

    /// Steps by which the model's output is late.
    #[must_use]
    pub fn delay(&self) -> usize {
        match self {
            Self::Derivatives(derivatives) => derivatives.delay(),
            Self::Narx(_) | Self::StopOperators(_) => 0,
        }
    }

    /// The memory of a system at rest under `u` with output `y`.
    pub fn rest(&self, u: f64, y: f64, memory: &mut [f64]) {
        match self {
            Self::Narx(narx) => narx.rest(u, y, memory),
            Self::StopOperators(stops) => stops.rest(u, memory),
            Self::Derivatives(derivatives) => derivatives.rest(u, memory),
        }
    }

    /// Takes the next command and writes the model's input.
    pub fn step(&self, u: f64, memory: &mut [f64], z: &mut [f64]) {
        match self {
            Self::Narx(narx) => narx.step(u, memory, z),
            Self::StopOperators(stops) => stops.step(u, memory, z),
            Self::Derivatives(derivatives) => derivatives.step(u, memory, z),
        }
    }

    /// Takes the output that belongs to the last step.
    pub fn output(&self, y: f64, memory: &mut [f64]) {
        if let Self::Narx(narx) = self {
            narx.output(y, memory);
        }
    }

    /// The inputs for a record, one after the other, with the measured outputs in the memory; the
    /// system rests at first under the record's first command.
    #[must_use]
    pub fn of_record(&self, u: &[f64], y: &[f64]) -> Vec<f64> {
        let mut memory = vec![0.0; self.memory()];
        let mut all = vec![0.0; self.dimension() * u.len()];
        let (Some(u0), Some(y0)) = (u.first(), y.first()) else { return all };
        self.rest(*u0, *y0, &mut memory);
        for ((u, y), z) in u.iter().zip(y).zip(all.chunks_exact_mut(self.dimension())) {
            self.step(*u, &mut memory, z);
            self.output(*y, &mut memory);
        }
        all
    }

    /// The model's own response to `u` from rest with output `y0`: simulation mode. Values beyond
    /// `limit` are cut there.
    #[must_use]
    pub fn simulate(&self, f: &KernelSum, u: &[f64], y0: f64, limit: f64) -> Vec<f64> {
        let mut memory = vec![0.0; self.memory()];
        self.rest(u.first().copied().unwrap_or(0.0), y0, &mut memory);
        self.continue_from(f, u, &mut memory, limit)
    }

    /// The model's own response to `u` from this memory on, which is moved along.
    pub fn continue_from(
        &self,
        f: &KernelSum,
        u: &[f64],
        memory: &mut [f64],
        limit: f64,
    ) -> Vec<f64> {
        let (mut z, mut room) = (vec![0.0; self.dimension()], vec![0.0; self.dimension()]);
        let respond = |u: &f64| {
            self.step(*u, memory, &mut z);
            let y = f.value(&z, &mut room).clamp(-limit, limit);
            self.output(y, memory);
            y
        };
        u.iter().map(respond).collect()
    }
}
