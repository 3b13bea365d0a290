//! What the plant itself says of a port: its static gain, and whether a force meets a passive structure.

use anyhow::{Context as _, anyhow};
use model::System;

/// A model of which motion and voltage of one axis are read.
pub(super) struct Probe {
    system: System,
    number: usize,
    tip: u32,
    voltage: u32,
}

/// Hits of the answer to a pulse of force: at the last of them the window is as low as `WINDOW`.
const HITS: usize = 1 << 14;
const WINDOW: f64 = 1e-8;
/// Part of the greatest answer from which a velocity against the force counts.
const LEAST: f64 = 1e-6;

impl Probe {
    pub(super) fn new(system: System, number: usize) -> anyhow::Result<Self> {
        let find = |name: &str| {
            let name = format!("{name}[{number}]");
            system.variables().find(&name).with_context(|| format!("there is no {name}"))
        };
        let (tip, voltage) = (find("tip")?, find("voltage")?);
        Ok(Self { system, number, tip, voltage })
    }

    /// Least and greatest command in its unit; 0 and 1 where the blueprint does not say.
    pub(super) fn commands(&self) -> (f64, f64) {
        let name = format!("command[{}]", self.number);
        let variables = self.system.variables();
        let command = variables.find(&name).and_then(|r| variables.get(r));
        match command {
            Some(v) if v.min.is_finite() && v.max.is_finite() && v.min < v.max => (v.min, v.max),
            _ => (0.0, 1.0),
        }
    }

    fn put(system: &mut System, name: &str, value: f64) -> anyhow::Result<()> {
        let Some(reference) = system.variables().find(name) else { return Ok(()) };
        let in_si = system.variables().get(reference).map_or(value, |v| v.si.from_si(value));
        let in_its_unit = if name.starts_with("force") { in_si } else { value };
        system.set(reference, in_its_unit).map_err(|e| anyhow!(system.explain_set(&e)))
    }

    fn si(system: &System, reference: u32) -> f64 {
        let variable = system.variables().get(reference);
        let value = system.get(reference).unwrap_or(f64::NAN);
        variable.map_or(value, |v| v.si.to_si(value))
    }

    /// Position of the tip and voltage at rest, in SI, under a command in its unit and a force in N.
    pub(super) fn at_rest(&self, command: Option<f64>, force: f64) -> anyhow::Result<(f64, f64)> {
        let mut system = self.system.clone();
        if let Some(command) = command {
            Self::put(&mut system, &format!("command[{}]", self.number), command)?;
        }
        Self::put(&mut system, &format!("force[{}]", self.number), force)?;
        system.initialise(0.0).map_err(|e| anyhow!(system.explain(&e)))?;
        Ok((Self::si(&system, self.tip), Self::si(&system, self.voltage)))
    }

    /// Where the tip is at each hit, after a force that acts for the first step.
    fn answer(&self, force: f64) -> anyhow::Result<Vec<f64>> {
        let mut system = self.system.clone();
        let name = format!("force[{}]", self.number);
        Self::put(&mut system, &name, 0.0)?;
        system.initialise(0.0).map_err(|e| anyhow!(system.explain(&e)))?;
        let mut positions = vec![Self::si(&system, self.tip)];
        let period = system.period();
        Self::put(&mut system, &name, force)?;
        for hit in 1..=HITS {
            system.advance(hit as f64 * period).map_err(|e| anyhow!(system.explain(&e)))?;
            if hit == 1 {
                Self::put(&mut system, &name, 0.0)?;
            }
            positions.push(Self::si(&system, self.tip));
        }
        Ok(positions)
    }

    /// Whether a force can get out more energy than it puts in, starting from rest: the work of a force that is
    /// held over each step is Σ Fₙ·(xₙ − xₙ₋₁), and never below zero exactly where the real part of the transform
    /// of the answer's increments is not. The window makes the transform one outside the unit circle, where the
    /// same holds. Greatest part of the answer against the force, and its frequency in Hz.
    pub(super) fn gives_back(&self) -> anyhow::Result<Option<(f64, f64)>> {
        // Two runs, so that what moves by itself cancels.
        let (with, without) = (self.answer(1e-3)?, self.answer(0.0)?);
        let moved: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a - b).collect();
        let decay = WINDOW.powf(1.0 / HITS as f64);
        let mut weight = 1.0;
        let mut increments = Vec::with_capacity(HITS);
        for pair in moved.windows(2) {
            increments.push(weight * (pair[1] - pair[0]));
            weight *= decay;
        }
        let transform = numerics::fft::Fft::forward(HITS).of_real(&increments);
        let half = &transform[..=HITS / 2];
        let greatest = half.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let Some((at, worst)) =
            half.iter().map(|z| z.re).enumerate().min_by(|a, b| a.1.total_cmp(&b.1))
        else {
            return Ok(None);
        };
        let is_back = greatest > 0.0 && worst < -LEAST * greatest;
        let frequency = at as f64 / (HITS as f64 * self.system.period());
        Ok(is_back.then(|| (-worst / greatest, frequency)))
    }
}
