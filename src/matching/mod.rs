//! Whether the truth rigs behave as the papers' machines did: the papers' do-nothing errors and
//! baseline models, run on our rigs with the papers' signals.

use anyhow::{Context, anyhow};
use data::Blueprint;
use model::System;
use serde::Serialize;

/// Greatest relative difference of a matched figure.
const TOLERANCE: f64 = 0.25;

/// One figure of a paper beside ours.
#[derive(Serialize)]
pub(crate) struct Figure {
    pub(crate) rig: &'static str,
    pub(crate) what: String,
    pub(crate) unit: &'static str,
    pub(crate) paper: f64,
    /// `None` where the baseline method is not there.
    pub(crate) ours: Option<f64>,
    pub(crate) within: Option<bool>,
    pub(crate) note: &'static str,
}

impl Figure {
    fn new(
        rig: &'static str,
        what: impl Into<String>,
        unit: &'static str,
        paper: f64,
        ours: f64,
    ) -> Self {
        let within = Some((ours / paper - 1.0).abs() <= TOLERANCE);
        Self { rig, what: what.into(), unit, paper, ours: Some(ours), within, note: "" }
    }

    fn open(
        rig: &'static str,
        what: impl Into<String>,
        unit: &'static str,
        paper: f64,
        note: &'static str,
    ) -> Self {
        Self { rig, what: what.into(), unit, paper, ours: None, within: None, note }
    }

    fn note(mut self, note: &'static str) -> Self {
        self.note = note;
        self
    }
}

/// All figures, rig by rig.
pub(crate) fn figures() -> anyhow::Result<Vec<Figure>> {
    let mut all = Vec::new();
    for rig in [p0, p1, p2, p3, p4] {
        all.extend(rig()?);
    }
    Ok(all)
}

/// A built rig.
pub(crate) fn rig(name: &str) -> anyhow::Result<System> {
    let rig = rigs::find(name).with_context(|| format!("there is no rig {name}"))?;
    let blueprint = Blueprint::parse(rig.blueprint, rig.name)?;
    Ok(blueprint.check(learned::COMPONENTS)?.build())
}

/// Sets the command of an axis, from 1.
pub(crate) fn command(system: &mut System, axis: usize, value: f64) -> anyhow::Result<()> {
    let reference = variable(system, &format!("command[{axis}]"))?;
    system.set(reference, value).map_err(|error| anyhow!(system.explain_set(&error)))
}

fn variable(system: &System, name: &str) -> anyhow::Result<u32> {
    system.variables().find(name).with_context(|| format!("{} has no {name}", system.name()))
}

pub(crate) fn position(system: &System, axis: usize) -> anyhow::Result<f64> {
    let reference = variable(system, &format!("position[{axis}]"))?;
    system.get(reference).context("a variable of the table")
}

/// At rest under these commands: the positions of all axes.
pub(crate) fn rest(system: &mut System, commands: &[f64]) -> anyhow::Result<Vec<f64>> {
    for (axis, value) in (1..).zip(commands) {
        command(system, axis, *value)?;
    }
    system.initialise(0.0).map_err(|error| anyhow!(system.explain(&error)))?;
    (1..=commands.len()).map(|axis| position(system, axis)).collect()
}

/// The position of `axis` at t = n·period while its command is `u`; row n is read before u[n] acts.
pub(crate) fn response(
    system: &mut System,
    axis: usize,
    u: &[f64],
    period: f64,
) -> anyhow::Result<Vec<f64>> {
    system.reset();
    command(system, axis, u.first().copied().unwrap_or(0.0))?;
    system.initialise(0.0).map_err(|error| anyhow!(system.explain(&error)))?;
    let mut y = Vec::with_capacity(u.len());
    for (n, value) in u.iter().enumerate() {
        y.push(position(system, axis)?);
        command(system, axis, *value)?;
        let end = (n + 1) as f64 * period;
        system.advance(end).map_err(|error| anyhow!(system.explain(&error)))?;
    }
    Ok(y)
}

/// A paper's signal: its only channel and its sample time.
pub(crate) fn signal(name: &str, settings: &[(&str, f64)]) -> anyhow::Result<(Vec<f64>, f64)> {
    let signal = signals::lookup(name)?.generate(settings)?;
    let channel = signal.channels.first().context("a signal has a channel")?;
    Ok((channel.values.clone(), signal.period))
}

pub(crate) fn extremes(values: &[f64]) -> (f64, f64) {
    let fold = |start: f64, pick: fn(f64, f64) -> f64| values.iter().copied().fold(start, pick);
    (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max))
}

pub(crate) fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(|x| x * x).sum::<f64>() / count).sqrt()
}

/// P0: the greatest |u/150 V − θ| on the training signal, axis by axis, and the ranges on the PSDs.
fn p0() -> anyhow::Result<Vec<Figure>> {
    const RIG: &str = "p0-truth";
    let mut system = rig(RIG)?;
    let (u, period) = signal("p0-train-h", &[])?;
    let mut all = Vec::new();
    for axis in 1..=4 {
        let d = response(&mut system, axis, &u, period)?;
        let (min, max) = extremes(&d);
        let rising = d[d.len() / 20] > d[0];
        let angle = |d: f64| if rising { (d - min) / (max - min) } else { (max - d) / (max - min) };
        let error = u.iter().zip(&d).map(|(u, d)| (u / 150.0 - angle(*d)).abs());
        let error = 100.0 * error.fold(0.0, f64::max);
        let what = format!("axis {axis}: greatest |u − θ|, training signal H");
        let figure = Figure::new(RIG, what, "%", 19.6, error);
        all.push(if axis == 1 { figure } else { figure.note("the paper tells it of axis 1") });
    }
    system.reset();
    for (psd, paper, axes) in [("PSD 1", 720.0, [1, 2]), ("PSD 2", 495.0, [3, 4])] {
        let mut span = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        for corner in 0..16_u32 {
            let level = |axis: u32| if corner >> axis & 1 == 1 { 150.0 } else { 0.0 };
            let commands: Vec<f64> = (0..4).map(level).collect();
            let p = rest(&mut system, &commands)?;
            for (span, axis) in span.iter_mut().zip(axes) {
                let p: f64 = p[axis - 1];
                *span = (span.0.min(p), span.1.max(p));
            }
        }
        let range = (span[0].1 - span[0].0).hypot(span[1].1 - span[1].0);
        all.push(Figure::new(RIG, format!("range on {psd}, diagonal"), "um", paper, range));
    }
    for (what, paper) in [
        ("hysteresis model without D, frequency-varying signal", 2.25),
        ("LS-SVM with D, test 1", 0.925),
    ] {
        all.push(Figure::open(RIG, what, "%", paper, "piezoloop reproduce p0 shows it"));
    }
    Ok(all)
}

/// P1: range, and rms of the position about the straight line of the nominal gain, signals A to G.
fn p1() -> anyhow::Result<Vec<Figure>> {
    const RIG: &str = "p1-truth";
    let gain = rest(&mut rig("p1")?, &[1.0])?[0] - rest(&mut rig("p1")?, &[0.0])?[0];
    let mut system = rig(RIG)?;
    let paper = [1.747, 2.057, 0.862, 1.771, 0.714, 0.444, 5.801];
    let (low, high) = (rest(&mut system, &[0.0])?[0], rest(&mut system, &[10.0])?[0]);
    let mut all =
        vec![Figure::new(RIG, "range, 0 to 100 V at the actuator", "um", 35.0, high - low)];
    for (letter, paper) in "abcdefg".chars().zip(paper) {
        let (u, period) = signal(&format!("p1-{letter}"), &[])?;
        let y = response(&mut system, 1, &u, period)?;
        let error = rms(u.iter().zip(&y).map(|(u, y)| y - gain * u));
        let what = format!("do-nothing error, signal {}", letter.to_ascii_uppercase());
        let figure = Figure::new(RIG, what, "um", paper, error);
        all.push(match letter {
            'c' | 'f' | 'g' => {
                figure.note("the wave form stands in: the paper gives its band only")
            }
            _ => figure,
        });
    }
    for (what, paper) in [("Preisach, signal G", 1.337), ("LS-SVM NARX, signal G", 0.166)] {
        all.push(Figure::open(RIG, what, "um", paper, "piezoloop reproduce p1 shows it"));
    }
    Ok(all)
}

/// P2: range, resonance, and the Bouc–Wen model with the printed parameters beside the rig.
fn p2() -> anyhow::Result<Vec<Figure>> {
    const RIG: &str = "p2-truth";
    let mut system = rig(RIG)?;
    let mut all = Vec::new();
    for (name, paper, note) in [
        ("p2-train", 1.9, ""),
        ("p2-test-1", 2.8, "the signal stands in: the paper shows it as a figure only"),
        ("p2-test-2", 1.9, "the signal stands in: the paper shows it as a figure only"),
    ] {
        let (u, period) = signal(name, &[])?;
        let y = response(&mut system, 1, &u, period)?;
        let model = response(&mut rig("p2")?, 1, &u, period)?;
        let (min, max) = extremes(&y);
        if name == "p2-train" {
            all.push(Figure::new(RIG, "range, training signal", "um", 236.0, max - min));
        }
        let start = y[0] - model[0];
        let error = rms(y.iter().zip(&model).map(|(y, m)| y - m - start));
        let what = format!("Bouc-Wen with the printed parameters, {name}, rms of range");
        let figure = Figure::new(RIG, what, "%", paper, 100.0 * error / (max - min));
        all.push(figure.note(note));
    }
    all.insert(1, Figure::new(RIG, "resonance", "Hz", 404.0, ringing(&mut system)?));
    all.push(Figure::open(
        RIG,
        "LS-SVM model III, training",
        "%",
        1.05,
        "piezoloop reproduce p2 shows it",
    ));
    Ok(all)
}

/// The frequency at which a rig rings after a small jump, from crossings of its mean.
fn ringing(system: &mut System) -> anyhow::Result<f64> {
    const PERIOD: f64 = 1e-4;
    let u: Vec<f64> = (0..4000).map(|n| if n < 10 { 0.0 } else { 0.2 }).collect();
    let y = response(system, 1, &u, PERIOD)?;
    let tail = &y[200..2200];
    let mean = tail.iter().sum::<f64>() / tail.len() as f64;
    let crossings = tail.windows(2).filter(|w| (w[0] < mean) != (w[1] < mean)).count();
    Ok(0.5 * crossings as f64 / (tail.len() as f64 * PERIOD))
}

/// P3: the loop closed by the printed PI alone, rms of the error in percent of the reference's range.
fn p3() -> anyhow::Result<Vec<Figure>> {
    const RIG: &str = "p3-truth";
    let mut system = rig(RIG)?;
    let (low, high) = (rest(&mut system, &[0.0])?[0], rest(&mut system, &[10.0])?[0]);
    let mut all =
        vec![Figure::new(RIG, "range, 0 to 150 V at the actuator", "um", 26.52, high - low)];
    for (frequency, paper) in [(100.0, 1.10), (500.0, 5.39), (1000.0, 11.1)] {
        let error = pi_loop(&mut system, frequency)?;
        let what = format!("PI alone, sine of {frequency} Hz, rms of range");
        all.push(Figure::new(RIG, what, "%", paper, error));
    }
    for (what, paper) in
        [("MPI model, 100 Hz", 0.650), ("MPI model, 500 Hz", 3.27), ("MPI model, 1 kHz", 4.95)]
    {
        all.push(Figure::open(RIG, what, "%", paper, "needs the MPI identification by the chirp"));
    }
    Ok(all)
}

/// The printed PI (Kp = 0.3, Ki = 20000 1/s, 20 kHz) on a sine of 0 to 10 um; command and position
/// scaled equally, as the paper does it.
fn pi_loop(system: &mut System, frequency: f64) -> anyhow::Result<f64> {
    const PERIOD: f64 = 50e-6;
    const RANGE: f64 = 10.0;
    // V per um over the range of the references.
    let gain = {
        let low = rest(system, &[0.0])?[0];
        RANGE / ((rest(system, &[RANGE])?[0] - low).abs()).max(f64::MIN_POSITIVE)
    };
    system.reset();
    rest(system, &[0.0])?;
    let zero = position(system, 1)?;
    let (mut integral, mut errors) = (0.0, Vec::new());
    let periods = 20.0;
    let count = (periods / frequency / PERIOD).round() as usize;
    for n in 0..count {
        let t = n as f64 * PERIOD;
        let angle = std::f64::consts::TAU * frequency * t;
        let reference = 0.5 * RANGE * (1.0 - angle.cos());
        let error = reference - (position(system, 1)? - zero);
        if t > 0.5 * periods / frequency {
            errors.push(error);
        }
        integral += 20_000.0 * PERIOD * error;
        command(system, 1, gain * (0.3 * error + integral))?;
        let end = (n + 1) as f64 * PERIOD;
        system.advance(end).map_err(|error| anyhow!(system.explain(&error)))?;
    }
    Ok(100.0 * rms(errors.iter().copied()) / RANGE)
}

/// P4: stroke and loop width of the third 1 Hz loop of 0 to 120 V.
fn p4() -> anyhow::Result<Vec<Figure>> {
    const RIG: &str = "evc-truth";
    let mut system = rig(RIG)?;
    let mut all = Vec::new();
    for (axis, name, stroke, width) in [(1, "Y", 5.53, 15.4), (2, "Z", 8.47, 9.3)] {
        let (u, period) = signal("p4-loop-1hz", &[])?;
        let y = response(&mut system, axis, &u, period)?;
        // The last of three periods: the first starts from the virgin curve.
        let last = 2 * u.len() / 3;
        let (u, y) = (&u[last..], &y[last..]);
        let (min, max) = extremes(y);
        let what = format!("{name}: stroke, 0 to 120 V at 1 Hz");
        all.push(Figure::new(RIG, what, "um", stroke, max - min));
        let what = format!("{name}: greatest width of the loop");
        all.push(Figure::new(RIG, what, "%", width, 100.0 * loop_width(u, y) / (max - min)));
    }
    Ok(all)
}

/// The greatest difference between the falling and the rising branch of one period of a loop.
fn loop_width(u: &[f64], y: &[f64]) -> f64 {
    let top = (0..u.len()).max_by(|a, b| u[*a].total_cmp(&u[*b])).unwrap_or(0);
    let rising = |x: f64| {
        let at = u[..=top].partition_point(|u| *u < x).min(top);
        let (left, right) = (at.saturating_sub(1), at);
        let step = u[right] - u[left];
        let part = if step > 0.0 { (x - u[left]) / step } else { 0.0 };
        y[left] + part * (y[right] - y[left])
    };
    (top..u.len()).map(|n| (y[n] - rising(u[n])).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_rigs_stay_matched() {
        let figures = figures().unwrap_or_else(|error| panic!("{error:#}"));
        for figure in &figures {
            let (paper, ours) = (figure.paper, figure.ours);
            assert_ne!(
                figure.within,
                Some(false),
                "{}: {} {paper} {ours:?}",
                figure.rig,
                figure.what
            );
        }
        for rig in rigs::RIGS.iter().filter(|rig| rig.frozen.is_some()) {
            assert!(figures.iter().any(|f| f.rig == rig.name && f.ours.is_some()), "{}", rig.name);
        }
    }

    #[test]
    fn a_loop_s_width_is_the_distance_of_its_branches() {
        let u = [0.0, 1.0, 2.0, 1.0, 0.0];
        assert_eq!(loop_width(&u, &[0.0, 0.5, 2.0, 1.5, 0.0]), 1.0);
    }
}
