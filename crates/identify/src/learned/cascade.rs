//! Projection, curve and linear part, fitted together to what records show in simulation.
//!
//! ```text
//! y = D·S(x),   x = u + Σ p_i z_i
//! D = L·(1 + Σ c_j C_j)/(1 + Σ c_j),   C_j = (1 − k_j)/(1 − k_j q⁻¹),   k_j = exp(−T/τ_j)
//! L = (b + (1 − k − b) q⁻¹)/(1 − k q⁻¹),   k = exp(−2π f T),   b = 1 − exp(−2π f (T − δ))
//! ```
//!
//! z are stop operators, S a cubic spline whose coefficients are the best for each D and p, L a lag of f Hz and a
//! delay of δ s under commands that are held over T s, C creep. Where curve and linear part are fitted in turn,
//! each keeps what the other left it: a lag that is a little too slow is balanced by loops that are a little
//! too narrow, at the rates of the records and at no other. Coefficients of q⁻¹ that are free lead into the same
//! valleys, as creep and lag are poles beside each other there; in Hz and s they are apart.
//!
//! Reference: G. Golub, V. Pereyra, Separable nonlinear least squares: the variable projection method and its
//! applications, Inverse Problems 19 (2003); H. Ang, F. Garmón, P. Khosla, C. Riviere, Modeling rate-dependent
//! hysteresis in piezoelectric actuators, IROS 2003.

use learned::features::{Features, StopOperators};
use nalgebra::{DMatrix, DVector};
use numerics::least_squares::NoSolution;
use numerics::levenberg_marquardt::{Ending, Unknown, minimise};

use super::projection::taken;
use super::series::{before, rows};
use super::spline::Knots;
use super::{
    Arx, EvidenceWeighted, Frame, Machine, Run, SEED, Series, Span, Waves, Widths, weigh_samples,
};

/// Intervals of the spline.
const INTERVALS: usize = 48;
/// Elements of creep, and the steps of the first and the last one's time at the start.
const CREEP: [f64; 2] = [25.0, 350.0];
/// Creep that each may have, in parts of the stroke.
const MOST_CREEP: f64 = 0.3;
/// Delay in parts of a step.
const DELAY: (f64, f64) = (-0.5, 0.95);
/// Weight of the curvature of S, and of p, over the mean square of the basis.
const RIDGE: (f64, f64) = (1e-6, 1e-9);
/// Most rows that are compared; those between are simulated.
const MOST: usize = 1500;
const ENDING: Ending = Ending { iterations: 40, tolerance: 1e-6 };

/// What H learns from beside the records, in their law's own time.
const WAVES: Waves =
    Waves { count: 16, rows: 500, period: 2e-3, band: [1.0, 20.0], range: [0.0, 1.0], seed: SEED };

/// What was found.
pub(super) struct Cascade {
    /// The frame that was given, its stops projected.
    pub(super) frame: Frame,
    /// D.
    pub(super) linear: Arx,
    knots: Knots,
    curve: DVector<f64>,
}

impl Cascade {
    /// S(x) in the output's unit, from rest under the first command.
    pub(super) fn simulate(&self, command: &[f64]) -> Vec<f64> {
        let value = |x: f64| {
            let (first, values, _) = self.knots.at(x);
            let terms = values.iter().zip(&self.curve.as_slice()[first..]).map(|(v, c)| v * c);
            self.frame.output.outward(terms.sum::<f64>())
        };
        self.frame.projected_command(command).into_iter().map(value).collect()
    }
}

/// Fits the stops of the frame, a curve and a linear part to runs of period `period` s, from a lag of `bandwidth` Hz;
/// `None` where the frame has no stops or the search finds nothing.
pub(super) fn fit(frame: &Frame, runs: &[Run<'_>], bandwidth: f64, period: f64) -> Option<Cascade> {
    let Features::StopOperators(stops) = &frame.features else { return None };
    let records: Vec<Record> = runs.iter().map(|run| Record::new(frame, stops, run)).collect();
    let count: usize = records.iter().map(|record| record.target.len() - record.first).sum();
    let scene = FitContext {
        knots: Knots::about(
            records.iter().flat_map(|record| record.command.iter().copied()),
            INTERVALS,
        ),
        every: count.div_ceil(MOST).max(1),
        records,
        period,
        stops: taken(stops.count).len(),
    };
    let start = scene.start(bandwidth);
    let mut best = (f64::INFINITY, Vec::new());
    let residuals = |p: &[f64]| {
        let Some((_, left)) = scene.curve(p) else {
            return Ok(vec![1e3; scene.rows() + scene.stops]);
        };
        let cost = (RIDGE.1 * scene.rows() as f64).sqrt();
        let weights = p[..scene.stops].iter().map(|p| cost * p);
        let all: Vec<f64> = left.iter().copied().chain(weights).collect();
        let squares = all.iter().map(|e| e * e).sum();
        if squares < best.0 {
            best = (squares, p.to_vec());
        }
        Ok(all)
    };
    // A search that is still creeping along when its time is over has a good place, too.
    drop(minimise::<NoSolution>(&start, ENDING, residuals, |_| ()));
    let found = best.1;
    if found.is_empty() {
        return None;
    }
    let (p, dynamics) = found.split_at(scene.stops);
    let linear = scene.linear(dynamics);
    let (curve, _) = scene.curve(&found)?;
    let mut projection = vec![0.0; stops.count];
    taken(stops.count).into_iter().zip(p).for_each(|(k, p)| projection[k] = *p);
    let mut frame = frame.clone();
    frame.features = Features::StopOperators(StopOperators { projection, ..stops.clone() });
    linear.is_stable().then_some(Cascade { frame, linear, knots: scene.knots, curve })
}

impl Series {
    /// Projection, curve and linear part fitted together from a lag of `bandwidth` Hz and sampled every `period` s,
    /// then H on what such a linear part leaves of the runs, its widths by the evidence. Where no record goes, H
    /// learns from the curve's own answers to waves that fill the range of the commands: a kernel narrow enough
    /// for what is bent falls to nothing between samples that are far apart. At most `most` samples of the
    /// runs. `None` where the frame has no stops, or the search finds nothing.
    ///
    /// # Errors
    /// [`learned::Error`] where samples are too few or not finite, or the training has no exact solution.
    pub fn train_cascade(
        frame: &Frame,
        widths: Widths<'_>,
        runs: &[Run<'_>],
        (bandwidth, period): (f64, f64),
        most: usize,
    ) -> Result<Option<(Self, EvidenceWeighted)>, learned::Error> {
        let Some(found) = fit(frame, runs, bandwidth, period) else { return Ok(None) };
        let waves = waves(runs);
        let answers: Vec<Vec<f64>> = waves.iter().map(|u| found.simulate(u)).collect();
        let inner: Vec<Vec<f64>> = runs.iter().map(|run| before_linear(&found, run)).collect();
        let own = runs.iter().zip(&inner).map(|(run, x)| (run.command, &x[..]));
        let theirs = waves.iter().zip(&answers).map(|(u, x)| (&u[..], &x[..]));
        let pairs: Vec<(&[f64], &[f64])> = own.chain(theirs).collect();
        let measured = rows(runs, most);
        let (begin, end) = (
            runs.iter().map(|run| run.command.len()).sum::<usize>(),
            pairs.iter().map(|(u, _)| u.len()).sum::<usize>(),
        );
        let every = (end - begin).div_ceil(measured.len().max(1)).max(1);
        let taken: Vec<usize> = measured.into_iter().chain((begin..end).step_by(every)).collect();
        let samples = found.frame.samples(&pairs)?.subset(&taken);
        let weighed = weigh_samples(
            &found.frame,
            &samples,
            widths.group,
            widths.stiff,
            widths.search,
            widths.greatest,
        );
        let samples = weighed.frame.samples(&pairs)?.subset(&taken);
        let (machine, _) = Machine::train_on(weighed.frame.clone(), &samples, weighed.settings)?;
        Ok(Some((Self { machine, linear: found.linear }, weighed)))
    }
}

/// What stands before the linear part for it to give these positions: by its inverse where that is stable,
/// or as the curve has it and the difference behind.
fn before_linear(found: &Cascade, run: &Run<'_>) -> Vec<f64> {
    let inverse = found.linear.inverse();
    if inverse.is_stable() {
        inverse.simulate(run.position, run.start)
    } else {
        before(&found.linear, run, &found.simulate(run.command))
    }
}

/// Waves over the range of the commands.
fn waves(runs: &[Run<'_>]) -> Vec<Vec<f64>> {
    let span = Span::of(&runs.iter().flat_map(|run| run.command).copied().collect::<Vec<_>>());
    let waves = WAVES.commands().unwrap_or_default();
    waves.into_iter().map(|wave| wave.into_iter().map(|x| span.outward(x)).collect()).collect()
}

/// Scaled command and position of a run, and the stops that take part.
struct Record {
    command: Vec<f64>,
    stops: Vec<Vec<f64>>,
    target: Vec<f64>,
    first: usize,
}

impl Record {
    fn new(frame: &Frame, stops: &StopOperators, run: &Run<'_>) -> Self {
        let bare = stops.bare();
        let (inputs, target) =
            frame.bare(&Features::StopOperators(bare), &[(run.command, run.position)]);
        let d = inputs.len() / target.len().max(1);
        let taken = taken(stops.count);
        let rows = || inputs.chunks_exact(d.max(1));
        Self {
            command: rows().map(|z| z[d - 2]).collect(),
            stops: rows().map(|z| taken.iter().map(|k| z[*k]).collect()).collect(),
            first: run.first.min(target.len()),
            target,
        }
    }
}

struct FitContext {
    records: Vec<Record>,
    knots: Knots,
    every: usize,
    period: f64,
    stops: usize,
}

impl FitContext {
    /// Weights of the stops, then ln f, δ/T, and c and ln τ of each element of creep.
    fn start(&self, bandwidth: f64) -> Vec<Unknown> {
        let unknown = |start, lower, upper| Unknown { start, lower, upper };
        let mut all = vec![unknown(0.0, -1.0, 1.0); self.stops];
        let fastest = 1.0 / self.period;
        let lag = bandwidth.min(fastest).ln();
        all.push(unknown(lag, lag - 4.0, fastest.ln() + 1.0));
        all.push(unknown(0.0, DELAY.0, DELAY.1));
        let longest = self.records.iter().map(|record| record.target.len()).max().unwrap_or(0);
        for steps in CREEP {
            all.push(unknown(0.005, -MOST_CREEP, MOST_CREEP));
            let (tau, end) =
                ((steps * self.period).ln(), (4.0 * longest as f64 * self.period).ln());
            all.push(unknown(tau.min(end), (3.0 * self.period).ln(), end.max(tau)));
        }
        all
    }

    fn linear(&self, dynamics: &[f64]) -> Arx {
        let [f, delay, creep @ ..] = dynamics else { return Arx { b: vec![1.0], a: vec![] } };
        let omega = core::f64::consts::TAU * f.exp();
        let keep = (-omega * self.period).exp();
        let now = 1.0 - (-omega * self.period * (1.0 - delay)).exp();
        let lag = Arx { b: vec![now, 1.0 - keep - now], a: vec![-keep] };
        // Numerator and denominator of 1 + Σ c (1 − k)/(1 − k q⁻¹), one element after the other.
        let (mut b, mut a) = (vec![1.0], vec![1.0]);
        let mut sum = 1.0;
        for element in creep.chunks_exact(2) {
            let k = (-self.period / element[1].exp()).exp();
            let times = |x: &[f64]| -> Vec<f64> {
                let at = |i: usize| x.get(i).copied().unwrap_or(0.0);
                (0..=x.len()).map(|i| at(i) - if i > 0 { k * at(i - 1) } else { 0.0 }).collect()
            };
            let beside = a.iter().chain(&[0.0]).map(|a| element[0] * (1.0 - k) * a);
            b = times(&b).into_iter().zip(beside).map(|(b, add)| b + add).collect();
            a = times(&a);
            sum += element[0];
        }
        b.iter_mut().for_each(|b| *b /= sum);
        lag.then(&Arx { b, a: a.split_off(1) })
    }

    fn compared(&self, record: &Record) -> impl Iterator<Item = usize> + use<> {
        (record.first..record.target.len()).step_by(self.every)
    }

    fn rows(&self) -> usize {
        self.records.iter().map(|record| self.compared(record).count()).sum()
    }

    /// The best curve, and what it leaves of each row.
    fn curve(&self, at: &[f64]) -> Option<(DVector<f64>, DVector<f64>)> {
        let (p, dynamics) = at.split_at(self.stops);
        let linear = self.linear(dynamics);
        let rows = self.rows();
        let mut basis = DMatrix::<f64>::zeros(rows, self.knots.count());
        let mut target = DVector::<f64>::zeros(rows);
        let mut begin = 0;
        for record in &self.records {
            let splines: Vec<(usize, [f64; 4])> = record
                .command
                .iter()
                .zip(&record.stops)
                .map(|(u, z)| {
                    let x = u + z.iter().zip(p).map(|(z, p)| z * p).sum::<f64>();
                    let (first, values, _) = self.knots.at(x);
                    (first, values)
                })
                .collect();
            let mut signal = vec![0.0; splines.len()];
            for column in 0..self.knots.count() {
                for (value, (first, values)) in signal.iter_mut().zip(&splines) {
                    *value = column
                        .checked_sub(*first)
                        .and_then(|k| values.get(k).copied())
                        .unwrap_or(0.0);
                }
                let behind = linear.simulate(&signal, signal.first().copied().unwrap_or(0.0));
                for (k, row) in self.compared(record).enumerate() {
                    basis[(begin + k, column)] = behind[row];
                }
            }
            for (k, row) in self.compared(record).enumerate() {
                target[begin + k] = record.target[row];
            }
            begin += self.compared(record).count();
        }
        let (mut normal, scale) = (basis.tr_mul(&basis), rows as f64);
        self.knots.stiffen(&mut normal, RIDGE.0 * scale, 1e-3 * RIDGE.1 * scale);
        let coefficients = normal.cholesky()?.solve(&basis.tr_mul(&target));
        let left = target - basis * &coefficients;
        Some((coefficients, left))
    }
}

#[cfg(test)]
mod tests {
    use components::hysteresis::play::Plays;

    use super::super::{Recipe, Teaches, rms_difference};
    use super::*;

    const PERIOD: f64 = 2e-3;

    /// Plays, a bend behind them, then creep of two times and a lag of 40 Hz.
    fn machine(u: &[f64]) -> Vec<f64> {
        let (plays, mut state) = (Plays { r: &[0.5, 1.0, 2.0], w: &[0.1; 3] }, [0.0; 3]);
        let bent: Vec<f64> = u
            .iter()
            .map(|u| {
                let x = u + plays.step(*u, &mut state);
                x + 0.3 * (x - 4.0).max(0.0)
            })
            .collect();
        let creep = |tau: f64| Arx::lag(1.0 / (core::f64::consts::TAU * tau), PERIOD);
        let (fast, slow) = (creep(0.05).simulate(&bent, 0.0), creep(0.8).simulate(&bent, 0.0));
        let crept: Vec<f64> = bent
            .iter()
            .zip(fast.iter().zip(slow))
            .map(|(x, (fast, slow))| (x + 0.01 * fast + 0.02 * slow) / 1.03)
            .collect();
        Arx::lag(40.0, PERIOD).simulate(&crept, 0.0)
    }

    fn wave(top: f64, hertz: f64, rows: usize) -> Vec<f64> {
        let at = |k: usize| {
            let t = core::f64::consts::TAU * hertz * PERIOD * k as f64;
            0.5 * top * (1.0 - t.cos()) * (0.7 + 0.3 * (0.37 * t).cos())
        };
        (0..rows).map(at).collect()
    }

    fn frame(pairs: &[(&[f64], &[f64])]) -> Frame {
        let stops = StopOperators::new(15, 8.0, PERIOD);
        Frame::new(Features::StopOperators(stops), Span::UNIT, Span::UNIT, Recipe::Plain, pairs)
            .on_a_line(pairs)
    }

    /// What is trained on these commands and the machine's positions, from a lag of `bandwidth` Hz.
    fn trained(commands: &[Vec<f64>], bandwidth: f64) -> Series {
        let positions: Vec<Vec<f64>> = commands.iter().map(|u| machine(u)).collect();
        let pairs: Vec<(&[f64], &[f64])> =
            commands.iter().zip(&positions).map(|(u, y)| (&u[..], &y[..])).collect();
        let run = |&(command, position): &(_, _)| {
            let teaches = Teaches::Both;
            Run { command, position, start: 0.0, first: 0, teaches }
        };
        let runs: Vec<Run<'_>> = pairs.iter().map(run).collect();
        let group = |input: usize| usize::from(input >= 15);
        let (stiff, search) = ((&[40.0, 0.1][..], 1e5), (40, 500));
        let widths = Widths { group: &group, stiff, search, greatest: f64::INFINITY };
        let found = Series::train_cascade(&frame(&pairs), widths, &runs, (bandwidth, PERIOD), 600);
        found.unwrap().unwrap().0
    }

    #[test]
    fn slow_records_separate_lag_creep_and_bent_loops() {
        let commands = [wave(8.0, 2.0, 700), wave(5.0, 5.0, 500), wave(8.0, 7.0, 500)];
        // From a lag that is half as fast, and from one that is twice as fast.
        for bandwidth in [20.0, 80.0] {
            let series = trained(&commands, bandwidth);
            let rates: Vec<f64> =
                series.linear.poles().iter().map(|pole| -pole.re.ln() / PERIOD).collect();
            for expected in [40.0 * core::f64::consts::TAU, 1.0 / 0.05, 1.0 / 0.8] {
                let found = rates.iter().any(|rate| (rate / expected - 1.0).abs() < 0.1);
                assert!(found, "{expected} 1/s from {bandwidth} Hz: {rates:?}");
            }
            // Three times as fast as any record, and loops that none has shown.
            let test = wave(7.0, 21.0, 400);
            let error = rms_difference(&series.simulate(&test, 0.0), &machine(&test));
            assert!(error < 0.01, "{error} from {bandwidth} Hz");
        }
    }

    #[test]
    fn where_no_record_goes_the_curve_stands_in() {
        // One record stays low, the other steps from there to the top and back in a few rows.
        let low = wave(4.0, 2.0, 500);
        let mut high = wave(8.0, 12.0, 500);
        high.iter_mut().for_each(|u| {
            if *u > 4.6 && *u < 6.4 {
                *u = if *u < 5.5 { 4.6 } else { 6.4 };
            }
        });
        let series = trained(&[low, high], 40.0);
        let test = wave(8.0, 3.0, 600);
        let error = rms_difference(&series.simulate(&test, 0.0), &machine(&test));
        // Without the waves 0.054, with them 0.012.
        assert!(error < 0.03, "{error}");
    }
}
