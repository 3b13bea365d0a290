//! Table II of the laser beam paper: four control systems at two rates.

mod printed;

use std::path::Path;

use control::{Calibration, CalibrationRecord, Gains};
use data::{AxisBlueprint, Blueprint, ComponentBlueprint, SignalBlueprint, Value};
use identify::learned::{Arx, Frame, Machine, Recipe, Run, Series, Span, Teaches, Turns};
use learned::features::{Features, Narx};
use learned::lssvm::{Pruning, Settings};
use model::Kind;

use self::printed::{beyond, kinematics, printed};
use super::bed::{Bed, Tracked};
use super::inverse::{Linear, arx_component, learned_inverse, linear};
use super::{Aim, Effort, Order, Reproduction, Row, rms_of};
use crate::Tool;
use crate::machines;
use crate::matching;
use crate::reproduce::figures::{Chapter, Runs, open_loop};
use crate::reproduce::p0::stops;

const ID: &str = "P0";
const PERIOD: f64 = 5e-3;
const AXES: usize = 4;
const NAMES: [&str; AXES] = ["M1x", "M1y", "M2x", "M2y"];
const GREATEST: f64 = 150.0;
/// Ranges on both detectors in um, to which the paper relates its errors.
const RANGES: [f64; 2] = [720.0, 495.0];
/// The rows of the pass, behind approach and rest.
const PASS_FROM: usize = 400;
/// Trainings of hysteresis and linear part in turn.
const TURNS: usize = 4;
/// Support vectors of the paper's inverse.
const CENTRES: usize = 350;
/// Feedforward gain of the paper's system 4.
const KFF: f64 = 0.9;
/// Greatest |1/(1 + L)| of the gains.
const SENSITIVITY: f64 = 1.6;
/// Support vectors of an inverse that is tried.
const MANY: usize = 1000;
/// Passes that learn.
const PASSES: usize = 8;

/// The inverse of one axis, in volts per normalised angle.
struct Inverse {
    machine: Machine,
    linear: Linear,
    /// Position at angle 0, and its change to angle 1.
    from: f64,
    span: f64,
}

/// Record H of one axis: commands, angles from the one before the first on, position at angle 0 and its change to 1.
fn record_h(bed: &mut Bed, axis: usize) -> anyhow::Result<(Vec<f64>, Vec<f64>, [f64; 2])> {
    let (u, _) = matching::signal("p0-train-h", &[])?;
    let d = bed.response(axis, &u, 0.0, PERIOD)?;
    let (low, high) = matching::extremes(&d);
    let rising = d[d.len() / 20] > d[0];
    let (from, span) = if rising { (low, high - low) } else { (high, low - high) };
    Ok((u, d.iter().map(|d| (d - from) / span).collect(), [from, span]))
}

/// σ² and N_h of the paper; γ is what the simulation of all of record H takes on this machine, that of the inverse is printed.
const OWN: (f64, usize) = (2.0, 2);
const GAMMA: [f64; 2] = [1e2, 1e6];

/// The paper's own inverse of one axis: NARX inputs, learned from the angles that the unpruned forward model simulates of record
/// H, pruned; what undoes the linear part by the frequency-varying signal.
fn own(bed: &mut Bed, axis: usize, centres: usize) -> anyhow::Result<Inverse> {
    let (u, theta, [from, span]) = record_h(bed, axis)?;
    let volts = Span { low: 0.0, high: GREATEST };
    let (sigma2, past) = OWN;
    let narx = || Features::Narx(Narx { commands: past, outputs: past });
    let pairs = [(&u[..], &theta[1..])];
    let frame = Frame::new(narx(), volts, Span::UNIT, Recipe::Plain, &pairs);
    let [gamma, of_inverse] = GAMMA;
    let (forward, _) = Machine::train(frame, &pairs, Settings { gamma, sigma2 })?;
    let clean = forward.simulate(&u, theta[0]);
    let pairs = [(&clean[..], &u[..])];
    let frame = Frame::new(narx(), Span::UNIT, volts, Recipe::Plain, &pairs);
    let pruning = Pruning { most_error: f64::INFINITY, least_count: centres, ..Pruning::default() };
    let settings = Settings { gamma: of_inverse, sigma2 };
    let (machine, _) = Machine::prune(frame, &pairs, settings, pruning)?;
    let (swept, _) = matching::signal("p0-train-d", &[])?;
    let answer: Vec<f64> =
        bed.response(axis, &swept, 0.0, PERIOD)?.into_iter().map(|d| (d - from) / span).collect();
    let h = forward.simulate(&swept, answer[0]);
    let linear = linear(&answer[1..], &h, PERIOD, 3).ok_or_else(|| {
        anyhow::anyhow!("no stable linear part of the paper's inverse of axis {}", axis + 1)
    })?;
    Ok(Inverse { machine, linear, from, span })
}

/// Learns our inverse of one axis: from samples that the forward model simulates, as the paper does, over stop operators.
fn learn(bed: &mut Bed, axis: usize) -> anyhow::Result<Inverse> {
    let (u, theta, [from, span]) = record_h(bed, axis)?;
    let angle = |d: &[f64]| -> Vec<f64> { d.iter().map(|d| (d - from) / span).collect() };
    let volts = Span { low: 0.0, high: GREATEST };
    let broad = broad()?;
    let answer = angle(&bed.response(axis, &broad, 0.0, PERIOD)?);
    // Hysteresis and linear part in turn, each trained with the other taken out.
    let (frame, settings) = stops(&[(&u[..], &theta[1..])], [volts, Span::UNIT])?;
    let pairs = [(&u, &theta, Teaches::Hysteresis), (&broad, &answer, Teaches::Linear)];
    let runs = pairs.map(|(command, angle, teaches)| Run {
        command,
        position: &angle[1..],
        start: angle[0],
        first: 0,
        teaches,
    });
    let first = (&Arx { b: vec![1.0], a: Vec::new() }, &[(2, 3)][..]);
    let forward = Series::train(&frame, settings, &runs, first, Turns::of(TURNS))?.machine;
    let clean = forward.simulate(&u, theta[0]);
    let pairs = [(&clean[..], &u[..])];
    let (frame, settings) = stops(&pairs, [Span::UNIT, volts])?;
    let (complete, _) = Machine::train(frame, &pairs, settings)?;
    let own = identify::learned::rms_difference(&complete.simulate(&clean, u[0]), &u);
    let machine = complete.compress(&pairs, CENTRES, 1.05 * own + 0.03).unwrap_or(complete);
    let h = forward.simulate(&broad, answer[0]);
    let linear = linear(&answer[1..], &h, PERIOD, 3).ok_or_else(|| {
        anyhow::anyhow!("no stable linear part of the inverse of axis {}", axis + 1)
    })?;
    Ok(Inverse { machine, linear, from, span })
}

/// The paper's signal for the linear part, and small steps behind it, as it ends at 2 Hz.
fn broad() -> anyhow::Result<Vec<f64>> {
    let (mut u, _) = matching::signal("p0-train-d", &[])?;
    let last = u[u.len() - 1];
    u.extend((1..=200).map(|k| last + (75.0 - last) * f64::from(k) / 200.0));
    let (mut seed, mut level) = (1_u32, 0.0);
    for k in 0..1500 {
        if k % 3 == 0 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            level = if seed >> 31 == 1 { 6.0 } else { -6.0 };
        }
        u.push(75.0 + level);
    }
    Ok(u)
}

/// A controller: which of its parts there are.
#[derive(Clone, Copy)]
struct Design<'a> {
    name: &'a str,
    /// Each mirror sees only its own detector.
    apart: bool,
    feedforward: Option<f64>,
    gains: Gains,
    /// Rows that the reference runs ahead.
    preview: usize,
}

impl Design<'_> {
    /// With the feedforward gain of the paper's systems: 1 alone, 0.9 beside a PID.
    fn as_printed(self, preview: usize) -> Self {
        let gain = |gain: f64| if self.gains.ki > 0.0 { KFF } else { gain };
        let preview = if self.feedforward.is_some() { preview } else { 0 };
        Self { preview, feedforward: self.feedforward.map(gain), ..self }
    }
}

fn controller(
    design: &Design<'_>,
    inverses: &[Inverse],
    calibration: &Calibration,
) -> anyhow::Result<Blueprint> {
    let mut blueprint = Blueprint::new(Kind::Controller, design.name, PERIOD);
    for ((axis, name), inverse) in NAMES.iter().enumerate().zip(inverses) {
        let mut own = AxisBlueprint::new(name, "V", "um");
        own.command = SignalBlueprint::of_unit("V").between(0.0, GREATEST);
        own.motion = SignalBlueprint::of_unit("1");
        own.reference.start = Some(Value::Number(calibration.coordinates[axis].offset));
        if design.preview > 0 {
            let preview = ComponentBlueprint::new("reference-preview");
            let ahead = design.preview as f64 * PERIOD;
            own = own.component(preview.value("longest", 0.1).value("preview", ahead));
        }
        if design.feedforward.is_some() {
            let late = design.preview - 1 - inverse.linear.ahead;
            let own_inverse =
                learned_inverse(&mut blueprint, &format!("inverse{axis}"), &inverse.machine)?;
            own = own.component(arx_component(&inverse.linear.arx, PERIOD)).component(own_inverse);
            if late > 0 {
                let delay = ComponentBlueprint::new("delay").named("align");
                let late = late as f64 * PERIOD;
                own = own.component(delay.value("longest", 0.1).value("delay", late));
            }
        }
        let Gains { kp, ki, kd, derivative_filter } = design.gains;
        let pid = ComponentBlueprint::new("pid")
            .value("kp", kp)
            .value("ki", ki)
            .value("kd", kd)
            .value("derivative_filter", derivative_filter)
            .value("output_min", 0.0)
            .value("output_max", GREATEST)
            .value("feedforward_gain", design.feedforward.unwrap_or(0.0));
        blueprint = blueprint.axis(own.component(pid));
    }
    let row = |axis: usize| {
        let row = calibration.coordinates[axis].row.iter().enumerate();
        let own =
            row.map(|(other, x)| if design.apart && axis / 2 != other / 2 { 0.0 } else { *x });
        Value::List(own.map(Value::Number).collect())
    };
    let offsets = calibration.coordinates.iter().map(|fit| Value::Number(fit.offset));
    let coordinator = ComponentBlueprint::new("jacobian-coordinator")
        .value("matrix", Value::List((0..AXES).map(row).collect()))
        .value("offset", Value::List(offsets.collect()));
    Ok(blueprint.coupling(&NAMES, coordinator))
}

/// Drives all axes at once through their inverses, and fits J and p0.
fn calibrate(bed: &mut Bed, inverses: &[Inverse]) -> anyhow::Result<Calibration> {
    let angles = signals::lookup("p0-calibration")?.generate(&[])?;
    let motions: Vec<Vec<f64>> = angles.channels.into_iter().map(|c| c.values).collect();
    let rows = motions[0].len();
    let mut commands = Vec::new();
    for (inverse, theta) in inverses.iter().zip(&motions) {
        // The command of a row leads to the angle at its end.
        let ahead = 1 + inverse.linear.ahead;
        let early: Vec<f64> = (0..rows).map(|k| theta[(k + ahead).min(rows - 1)]).collect();
        let h = inverse.linear.arx.simulate(&early, early[0]);
        let u = inverse.machine.simulate(&h, 0.0);
        commands.push(u.into_iter().map(|u| u.clamp(0.0, GREATEST)).collect::<Vec<_>>());
    }
    let first: Vec<f64> = commands.iter().map(|u| u[0]).collect();
    let mut positions = vec![Vec::new(); AXES];
    let mut now = bed.rest(&first, PERIOD)?;
    for k in 0..rows {
        for (all, p) in positions.iter_mut().zip(&now) {
            all.push(*p);
        }
        now = bed.step(&commands.iter().map(|u| u[k]).collect::<Vec<_>>())?;
    }
    let named = |stem: &str, lists: Vec<Vec<f64>>| {
        (1..).zip(lists).map(|(n, list)| (format!("{stem}{n}"), list)).collect()
    };
    let apart = |row: usize| (0..AXES).map(|axis| row < 2 && axis >= 2).collect();
    Ok(control::calibrate(&CalibrationRecord {
        motions: named("theta", motions),
        positions: named("p", positions),
        starts: vec![0],
        zeros: (0..AXES).map(apart).collect(),
        longest_delay: 3.0,
    })?)
}

/// Largest gains that keep a sensitivity on the axis, in V per normalised angle.
fn retuned(bed: &mut Bed, inverse: &Inverse, sensitivity: f64) -> anyhow::Result<Gains> {
    let middle = vec![75.0; AXES];
    bed.rest(&middle, PERIOD)?;
    let mut commands = middle;
    let mut machine = |u: f64| {
        commands[0] = u;
        let all = bed.step(&commands);
        let error = |e: cosim::Error| identify::Error::Tuning { message: e.to_string() };
        all.map(|p| (p[0] - inverse.from) / inverse.span).map_err(error)
    };
    let impulse = control::impulse_of(&mut machine, [75.0, 20.0], 60, 4)?;
    Ok(control::robust(&impulse, PERIOD, sensitivity, 20.0)?)
}

/// The trajectory at a rate.
fn trajectory(rate: usize) -> anyhow::Result<Vec<Vec<f64>>> {
    let signal = signals::lookup(&format!("p0-trajectory-{rate}"))?.generate(&[])?;
    Ok(signal.channels.into_iter().map(|c| c.values).collect())
}

/// Errors on both detectors in um, from a row on.
fn errors(run: &Tracked, from: usize) -> [f64; 2] {
    [rms_of(&run.error, &[0, 1], from), rms_of(&run.error, &[2, 3], from)]
}

pub(super) fn run(
    effort: Effort,
    tool: &Tool,
    say: &(dyn Fn(&str) + Sync),
) -> anyhow::Result<Reproduction> {
    let mut bed = Bed::open(tool, Path::new(machines::P0))?;
    let mut answer = Reproduction::default();
    answer.kept.rig("plant", machines::P0)?;
    let quick =
        answer.leaves_out(effort, "our inverses, trajectories at rate 2, learning over passes");
    let mut own_inverses = Vec::new();
    let mut our_inverses = Vec::new();
    for (axis, name) in NAMES.iter().enumerate() {
        say(&format!("inverse of axis {name}"));
        let inverse = own(&mut bed, axis, CENTRES)?;
        answer.remarks.push(described("the paper's", name, &inverse));
        own_inverses.push(inverse);
        if !quick {
            let inverse = learn(&mut bed, axis)?;
            answer.remarks.push(described("our", name, &inverse));
            our_inverses.push(inverse);
        }
    }
    let inverses = if quick { &own_inverses } else { &our_inverses };
    answer.chapters.push(machine(&mut bed)?);
    say("calibration of the Jacobian");
    // Each method moves the axes through its own inverses, as the paper does.
    let calibration = calibrate(&mut bed, &own_inverses)?;
    let our_calibration = calibrate(&mut bed, inverses)?;
    kinematics(&calibration, &mut answer);
    let gains = retuned(&mut bed, &own_inverses[0], SENSITIVITY)?;
    answer.remarks.push(format!(
        "re-tuned by loop shaping on a measured step, sensitivity 1.6: kp {:.1} V, ki {:.1} V/s, kd \
         {:.4} V·s per normalised angle",
        gains.kp, gains.ki, gains.kd
    ));
    let ahead =
        |inverses: &[Inverse]| 1 + inverses.iter().map(|i| i.linear.ahead).max().unwrap_or(0);
    let preview = ahead(inverses);
    let base = Design {
        name: "p0_control",
        apart: false,
        feedforward: None,
        gains: Gains::default(),
        preview: 0,
    };
    printed(&bed, &base, &own_inverses, &calibration, &mut answer, say)?;
    let both = Design { feedforward: Some(1.0), gains, preview, ..base };
    let designs = [
        ("1: two independent PIDs", Design { apart: true, gains, ..base }),
        ("2: coordinated PID", Design { gains, ..base }),
        ("3: coordinated feedforward", Design { feedforward: Some(1.0), preview, ..base }),
        ("4: feedforward and PID", both),
    ];
    let own_preview = ahead(&own_inverses);
    let mut many = Vec::new();
    if !quick {
        say("tried: inverses with more support vectors");
        for axis in 0..AXES {
            many.push(own(&mut bed, axis, MANY)?);
        }
    }
    let brisk = retuned(&mut bed, &own_inverses[0], 2.0)?;
    answer.kept.blueprint(
        "controller",
        controller(&both.as_printed(own_preview), &own_inverses, &calibration)?,
    );
    for rate in if quick { &[1][..] } else { &[1, 2] } {
        let rate = *rate;
        let references = trajectory(rate)?;
        let (mut found, mut ours) = (Vec::new(), Vec::new());
        let mut runs = Vec::new();
        for (name, design) in &designs {
            say(&format!("rate {rate}, system {name}"));
            let as_printed = design.as_printed(own_preview);
            let blueprint = controller(&as_printed, &own_inverses, &calibration)?;
            let run = bed.track(&blueprint, &references, PERIOD, as_printed.preview)?;
            answer.kept.run(&format!("rate-{rate}-system-{name}"), &run, PERIOD)?;
            let error = errors(&run, PASS_FROM);
            let mut beside = None;
            if design.feedforward.is_some() && !quick {
                let blueprint = controller(design, inverses, &our_calibration)?;
                let run = bed.track(&blueprint, &references, PERIOD, design.preview)?;
                let error = errors(&run, PASS_FROM);
                beside = Some(error);
                ours.push(error);
            }
            for (psd, (error, paper)) in error.iter().zip([0.3, 0.2]).enumerate() {
                let is_best = name.starts_with('4');
                let what = format!("rate {rate}, system {name}, PSD {}", psd + 1);
                let relative = 100.0 * error / RANGES[psd];
                let (paper, aim) =
                    if is_best { (paper, Aim::Reach) } else { (f64::NAN, Aim::ForComparison) };
                let row = Row::new(ID, what, "%", paper, relative, aim);
                let ours = beside.map(|beside| 100.0 * beside[psd] / RANGES[psd]);
                answer.rows.push(Row { ours, ..row });
            }
            found.push(error);
            runs.push((*name, run));
        }
        answer.chapters.push(tracked(rate, &runs));
        if !quick {
            let printed = both.as_printed(own_preview);
            let more = both.as_printed(ahead(&many));
            let tried = [
                ("feedforward gain 1", Design { feedforward: Some(1.0), ..printed }, &own_inverses),
                ("gains for a sensitivity of 2", Design { gains: brisk, ..printed }, &own_inverses),
                ("inverses of 1000 support vectors", more, &many),
            ];
            for (what, design, inverses) in tried {
                let blueprint = controller(&design, inverses, &calibration)?;
                let run = bed.track(&blueprint, &references, PERIOD, design.preview)?;
                let error = errors(&run, PASS_FROM);
                for (psd, (error, paper)) in error.iter().zip([0.3, 0.2]).enumerate() {
                    let what = format!("tried: rate {rate}, system 4, {what}, PSD {}", psd + 1);
                    let relative = 100.0 * error / RANGES[psd];
                    answer.rows.push(Row::new(ID, what, "%", paper, relative, Aim::ForComparison));
                }
            }
        }
        let mut order = |what: &str, holds: bool| {
            let what = format!("rate {rate}: {what}");
            answer.orders.push(Order { paper_id: ID, what, holds });
        };
        order("PSD 2: 4 < 2 < 1", found[3][1] < found[1][1] && found[1][1] < found[0][1]);
        order(
            "PSD 1: systems 1 and 2 are the same",
            (found[0][0] / found[1][0] - 1.0).abs() < 1e-9,
        );
        order("PSD 1: 4 < 2", found[3][0] < found[1][0]);
        if let [_, ours] = &ours[..] {
            order("ours, PSD 1 and 2: 4 < 2", (0..2).all(|psd| ours[psd] < found[1][psd]));
            beyond(&bed, (rate, *ours), &both, inverses, &our_calibration, &mut answer, say)?;
        }
    }
    Ok(answer)
}

fn described(whose: &str, name: &str, inverse: &Inverse) -> String {
    format!(
        "{whose} inverse of {name}: {} support vectors (the paper: 350), linear part of orders {}, {} with \
         {} rows of preview, {:.2} % of the angle's range on the frequency-varying signal{}",
        inverse.machine.machine.count(),
        inverse.linear.arx.b.len() - 1,
        inverse.linear.arx.a.len(),
        inverse.linear.ahead,
        100.0 * inverse.linear.error,
        if whose == "our" { " and small steps" } else { "" }
    )
}

/// The loops of all axes, each moved alone.
fn machine(bed: &mut Bed) -> anyhow::Result<Chapter> {
    let (u, _) = matching::signal("p0-train-h", &[])?;
    let mut chapter = Chapter::new(
        "the machine",
        "Each axis alone under the training signal: its coordinate on the detector over its command.",
    );
    for pair in [[0, 1], [2, 3]] {
        let answers = pair.map(|axis| bed.response(axis, &u, 0.0, PERIOD).map(|y| (axis, y)));
        let answers = answers.into_iter().collect::<Result<Vec<_>, cosim::Error>>()?;
        let named: Vec<_> =
            answers.iter().map(|(axis, y)| (NAMES[*axis], &u[..], &y[1..])).collect();
        let title = format!("Loops of mirror {}", pair[0] / 2 + 1);
        chapter = chapter.figure(open_loop(title, "um", &named));
    }
    Ok(chapter)
}

/// Trajectories on both detectors and the distances from them.
fn tracked(rate: usize, runs: &[(&str, Tracked)]) -> Chapter {
    let runs = Runs {
        runs: runs.iter().map(|(name, run)| (*name, run)).collect(),
        period: PERIOD,
        from: PASS_FROM,
        unit: "um",
    };
    let text = "The beam's path on both detectors under the four systems, and how far it is from where it should \
                be.";
    Chapter::new(format!("trajectory at rate {rate}"), text)
        .figure(runs.paths("Path on PSD 1", [(0, "x1"), (1, "y1")]))
        .figure(runs.paths("Path on PSD 2", [(2, "x2"), (3, "y2")]))
        .figure(runs.distances("Distance on PSD 1", [0, 1]))
        .figure(runs.distances("Distance on PSD 2", [2, 3]))
        .figure(runs.tracking("Coordinate x2 and the command of M2x", 2))
}

/// The library has what the controllers are made of.
#[cfg(test)]
mod tests {
    use components::COMPONENTS as LIBRARY;

    #[test]
    fn kinds_are_known() {
        for kind in
            ["jacobian-coordinator", "reference-preview", "arx", "repetitive", "pid", "delay"]
        {
            assert!(LIBRARY.iter().any(|c| c.declaration().kind == kind), "{kind}");
        }
    }
}
