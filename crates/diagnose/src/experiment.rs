//! What to measure next: the signal of a menu that separates two rivals best (T-optimal).

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use numerics::random::SplitMix64;
use surround::Span;

use crate::base::Part;
use crate::belief;
use crate::candidate::Candidate;
use crate::data_set::{DataSet, RecordRows};
use crate::fit::{Fitter, Linear};
use crate::gap::NextExperiment;
use crate::outcome::Outcome;
use crate::thresholds::answer::Thresholds;

/// One signal of the menu.
struct Item {
    name: String,
    command: Vec<f64>,
}

/// The experiment that separates the most probable name of the most doubtful slot from its rivals; for an unknown
/// effect a record at rest and a rich one.
pub(crate) fn next(o: &Outcome) -> Option<NextExperiment> {
    // No command moves a reading under positions of the model alone.
    if matches!(o.task.base.part, Part::Reading(_)) {
        return None;
    }
    let last = &o.found.last;
    for slot in 0..last.picks.len() {
        let looked = o.found.rivals.get(slot)?;
        let beliefs = belief::beliefs(&o.sight(), looked, last);
        let of = |family: usize| {
            let best = looked.iter().find(|l| l.family == family)?.best.as_ref()?;
            Some((family, best))
        };
        let set: Vec<(usize, &Candidate)> =
            belief::set(&beliefs).into_iter().filter_map(of).collect();
        if let [first, rivals @ ..] = &set[..]
            && !rivals.is_empty()
        {
            // Rivals are told apart by how many times more one leaves, the mean over all rows.
            let best = beliefs.first().map_or(f64::INFINITY, |b| b.left);
            return separate(o, *first, rivals, (Thresholds::EXPERIMENT_APART - 1.0) * best);
        }
    }
    use crate::gap::Verdict;
    let sentence = match o.verdict {
        Verdict::Unknown => {
            "Record the machine at rest (for --rest), then a multisine over the whole band and range: the first tells disturbance from effect, the second where the effect lies"
        }
        Verdict::InsufficientExcitation => {
            "Record a multisine over the whole band at a tenth of the range or more, and a staircase"
        }
        _ => return None,
    };
    let steep = steepest(&o.task.data);
    let item = menu(o, longest(o), (steep, steep)).into_iter().next()?;
    Some(experiment(o, item, sentence.to_owned(), Vec::new(), None))
}

/// Rows of the longest log, within bounds.
fn longest(o: &Outcome) -> usize {
    let rows = o.task.data.records.iter().map(|r| r.rows.len()).max().unwrap_or(0);
    rows.clamp(256, Thresholds::EXPERIMENT_ROWS)
}

fn experiment(
    o: &Outcome,
    item: Item,
    sentence: String,
    separates: Vec<String>,
    predicted_gain: Option<f64>,
) -> NextExperiment {
    let scale = o.task.command_factor;
    let n = item.command.len();
    let values = item.command.iter().map(|u| u / scale).collect();
    let mut columns = BTreeMap::from([(o.task.input.clone(), values)]);
    let neighbours = o.task.data.aux.iter().enumerate().filter(|(_, aux)| aux.is_command);
    columns.extend(neighbours.map(|(k, aux)| (aux.name.clone(), beside(o, k, n))));
    NextExperiment {
        sentence,
        separates,
        signal: item.name,
        predicted_gain,
        period: Some(o.task.data.sample_time),
        columns,
    }
}

/// The mildest signal that excludes all rivals and the re-tuned model: formulas are nearest to the truth where the
/// machine is driven as in the logs. Where none does, the one that excludes most. `wanted` is the mean over all rows, in
/// noise variances, by which a rival must be off.
fn separate(
    o: &Outcome,
    (fa, a): (usize, &Candidate),
    rivals: &[(usize, &Candidate)],
    wanted: f64,
) -> Option<NextExperiment> {
    let known: usize = o.task.data.records.iter().map(|r| r.rows.len()).sum();
    let (mut best, mut highest): (Option<(Vec<f64>, Item)>, _) = (None, (f64::NEG_INFINITY, 0.0));
    // A longer signal where the logs' length is too short, and a steeper one where only speed tells them apart.
    let steep = steepest(&o.task.data);
    let limits = Thresholds::EXPERIMENT_STEEPER.map(|steeper| steeper * steep);
    let tried = [None].into_iter().chain(limits.map(Some));
    let all = tried.zip(limits).flat_map(|(tried, limit)| {
        [longest(o), Thresholds::EXPERIMENT_ROWS].map(move |rows| (rows, tried, limit))
    });
    for (rows, tried, limit) in all {
        if highest.0 >= 0.0 {
            break;
        }
        let enough = wanted * (known + rows) as f64;
        for item in menu(o, rows, (steep, limit)) {
            // A signal that the last limit did not change is the same again.
            if tried.is_some_and(|tried| item.steepest(o.task.data.sample_time) <= tried) {
                continue;
            }
            let Some((gains, gap)) = gains(o, a, rivals, &item) else { continue };
            let seen = gap * (wanted / (o.adequate - 1.0)).min(1.0);
            // The product: one that is far off makes up for none that is near.
            let all = gains.iter().chain([&seen]);
            let excluded: f64 =
                all.map(|g| (g / enough).clamp(Thresholds::EXPERIMENT_FAINTEST, 1.0).ln()).sum();
            if (excluded, -gap) > highest {
                (highest, best) = ((excluded, -gap), Some((gains, item)));
            }
        }
    }
    let (gains, item) = best?;
    // What is said is about the rival that it separates best.
    let (at, gain) =
        gains.iter().copied().enumerate().max_by(|x, y| x.1.total_cmp(&y.1).then(y.0.cmp(&x.0)))?;
    let (ea, eb) = (o.library[fa].effect, o.library[rivals[at].0].effect);
    let separates = vec![ea.name.to_owned(), eb.name.to_owned()];
    let advice = if gain < Thresholds::EXPERIMENT_LEAST {
        format!(
            "No signal within the command's range separates {} from {}; beyond it: {}",
            ea.name, eb.name, ea.experiment
        )
    } else {
        format!(
            "Play {}: it separates {} from {}, the wrong one would be off by {:.0} noise variances in sum",
            item.name, ea.name, eb.name, gain
        )
    };
    Some(experiment(o, item, advice, separates, Some(gain)))
}

/// The misfit that a signal gives each rival of `a`, and the re-tuned model.
fn gains(
    o: &Outcome,
    a: &Candidate,
    rivals: &[(usize, &Candidate)],
    item: &Item,
) -> Option<(Vec<f64>, f64)> {
    let data = record(o, item);
    let count = std::sync::atomic::AtomicU64::new(0);
    let fitter = Fitter { data: &data, sigma: o.sigma, count: &count, weights: None };
    let played = |of: &Candidate| fitter.linearise(&of.chain.over(&data), &of.fit.theta).ok();
    let left = played(a)?;
    let base = (&played(&o.found.base)?, &o.found.base);
    // Whichever of two is true, the other must be off, and the gap itself must not vanish among rows that do not show it.
    let (mut gains, mut gap) = (Vec::with_capacity(rivals.len()), misfit(&data, &left, base)?);
    for (_, b) in rivals {
        let right = played(b)?;
        gains.push(misfit(&data, &left, (&right, b))?.min(misfit(&data, &right, (&left, a))?));
        gap = gap.min(misfit(&data, &right, base)?);
    }
    Some((gains, gap))
}

/// Expected misfit of the rival `b`, played as `right`, on a record that another makes, played as `left`, with b's
/// parameters profiled under what the training rows say about them.
fn misfit(data: &DataSet, left: &Linear, (right, b): (&Linear, &Candidate)) -> Option<f64> {
    // Both residuals are of the same measured zeros: their difference is that of the models.
    let apart: Vec<f64> = right.residual.iter().zip(&left.residual).map(|(x, y)| x - y).collect();
    let thinned = data.time.len() as f64 / apart.len().max(1) as f64;
    let n = right.columns.len();
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() * thinned;
    let mut normal = DMatrix::zeros(n, n);
    let mut gradient = DVector::zeros(n);
    for i in 0..n {
        gradient[i] = dot(&right.columns[i], &apart);
        for j in 0..n {
            normal[(i, j)] = dot(&right.columns[i], &right.columns[j]);
        }
        let known = b.fit.deviations.get(i).copied().flatten();
        normal[(i, i)] += known.map_or(1e-12, |d| 1.0 / (d * d).max(1e-300));
        normal[(i, i)] *= 1.0 + 1e-12;
    }
    let step = normal.cholesky()?.solve(&gradient);
    Some((dot(&apart, &apart) - gradient.dot(&step)).max(0.0))
}

/// What is played on a neighbour's command; anything else stays where it was in the middle.
fn beside(o: &Outcome, number: usize, n: usize) -> Vec<f64> {
    let (aux, sample) = (&o.task.data.aux[number], o.task.data.sample_time);
    let Span { centre, half } = aux.span;
    if !aux.is_command {
        return vec![centre; n];
    }
    let (from, to) = (1.0 / (n as f64 * sample), 0.2 / sample);
    multisine(n, sample, (from, to), (centre, 0.9 * half), 77 + number as u64)
}

/// A record of the signal with a measured output of zero.
fn record(o: &Outcome, item: &Item) -> DataSet {
    let source = &o.task.data;
    let sample = source.sample_time;
    let n = item.command.len();
    let aux = (0..source.aux.len()).map(|k| beside(o, k, n));
    // Inputs that are not looked at stay where the logs had them: zero may be far from any log.
    let mean = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let others = source.records.first().map_or_else(Vec::new, |first| {
        first.others.iter().map(|values| vec![mean(values); n]).collect()
    });
    let rows = RecordRows {
        name: item.name.clone(),
        time: (0..n).map(|k| k as f64 * sample).collect(),
        command: item.command.clone(),
        y: vec![0.0; n],
        aux: aux.collect(),
        others,
        run_in: 0,
        training: 1.0,
    };
    let names: Vec<(String, bool)> =
        source.aux.iter().map(|a| (a.name.clone(), a.is_command)).collect();
    DataSet::new(vec![rows], &names, o.task.base.is_white.then_some(source.step))
}

/// The signal as a log without readings: time, command, and what is played beside it (in SI units).
pub(crate) fn csv(o: &Outcome, next: &NextExperiment) -> Option<String> {
    let period = next.period?;
    let quoted = |name: &str| format!("\"{}\"", name.replace('"', "\"\""));
    let unit = |name: &str| match name == o.task.input {
        true => format!(" [{}]", o.task.command_unit),
        false => String::new(),
    };
    let names = next.columns.keys().map(|name| quoted(&format!("{name}{}", unit(name))));
    let mut text =
        std::iter::once("time [s]".to_owned()).chain(names).collect::<Vec<_>>().join(",");
    text.push('\n');
    let rows = next.columns.values().map(Vec::len).max()?;
    for row in 0..rows {
        text += &(row as f64 * period).to_string();
        for values in next.columns.values() {
            text.push(',');
            text += &values.get(row).map_or_else(String::new, f64::to_string);
        }
        text.push('\n');
    }
    Some(text)
}

/// Signals within the range of the command that the logs used, and of the machine, of the steepness of the logs and the
/// greatest that may be, per second.
fn menu(o: &Outcome, n: usize, (known, steepest): (f64, f64)) -> Vec<Item> {
    let data = &o.task.data;
    let sample = data.sample_time;
    let (min, max) = o.task.command_range;
    let (u, s) = (o.task.command_factor, data.command_span);
    let low = (s.centre - s.half).max(min * u);
    let high = (s.centre + s.half).min(max * u);
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    let length = n as f64 * sample;
    let nyquist = 0.5 / sample;
    let mut all = Vec::new();
    for (part, band) in [
        (0.9, (0.0, 0.4)),
        (0.2, (0.0, 0.4)),
        (0.9, (0.0, 0.05)),
        (0.2, (0.2, 0.8)),
        (0.9, (0.2, 0.8)),
    ] {
        let (from, to) = ((band.0 * nyquist).max(1.0 / length), band.1 * nyquist);
        let name =
            format!("multisine {from:.3} to {to:.3} Hz at {:.0} % of the range", 100.0 * part);
        let command = multisine(n, sample, (from, to), (centre, part * half), 2024);
        all.push(Item { name, command });
    }
    // Triangles as steep as may be: much speed and many turns.
    let steep = [0.95, 0.5, 0.2, 0.05, 0.02].map(|part| {
        let periods = (steepest * length / (4.0 * part * half.max(f64::MIN_POSITIVE))).floor();
        (part, periods.clamp(1.0, (Thresholds::EXPERIMENT_TURNS * nyquist * length).max(1.0)))
    });
    let slow = [(0.95, 2.0), (0.3, 2.0), (0.95, 20.0), (0.95, 200.0)];
    for (part, periods) in slow.into_iter().chain(steep) {
        let name =
            format!("triangle of {:.3} Hz at {} % of the range", periods / length, 100.0 * part);
        let wave = |k: usize| {
            let phase = (k as f64 / n as f64 * periods).fract();
            centre + part * half * (1.0 - 4.0 * (phase - 0.5).abs())
        };
        if periods / length < Thresholds::EXPERIMENT_TRIANGLE * nyquist {
            all.push(Item { name, command: (0..n).map(wave).collect() });
        }
    }
    let steps = [0.0, 0.5, -0.3, 0.8, 0.1, -0.8, -0.1, 0.4];
    let stairs = |k: usize| centre + half * steps[k * steps.len() / n];
    all.push(Item { name: "staircase with holds".into(), command: (0..n).map(stairs).collect() });
    all.push(Item { name: "hold in the middle".into(), command: vec![centre; n] });
    all.into_iter()
        .map(|item| item.no_steeper(steepest, sample, centre).of_steepness(known, sample))
        .collect()
}

/// Steepest command of the logs, per second.
fn steepest(data: &DataSet) -> f64 {
    let of = |rows: Range<usize>| {
        let at = |k: usize| data.command[data.row_hit[k] as usize];
        let slope = move |k: usize| (at(k) - at(k - 1)).abs() / (data.time[k] - data.time[k - 1]);
        (rows.start + 1..rows.end).map(slope).fold(0.0, f64::max)
    };
    data.records.iter().map(|r| of(r.rows.clone())).fold(0.0, f64::max)
}

impl Item {
    /// Steepest part, per second.
    fn steepest(&self, sample: f64) -> f64 {
        self.command.windows(2).map(|w| (w[1] - w[0]).abs() / sample).fold(0.0, f64::max)
    }

    /// The signal, made smaller about the middle where it is steeper than that.
    fn no_steeper(mut self, most: f64, sample: f64, centre: f64) -> Self {
        let own = self.steepest(sample);
        if own > most && most > 0.0 {
            let part = most / own;
            self.command.iter_mut().for_each(|u| *u = centre + part * (*u - centre));
            if part < Thresholds::EXPERIMENT_SMALLER {
                self.name += &format!(", made smaller to {:.0} %", 100.0 * part);
            }
        }
        self
    }

    /// The signal, whose name says where it asks for more speed than the machine had in the logs.
    fn of_steepness(mut self, known: f64, sample: f64) -> Self {
        let times = self.steepest(sample) / known;
        if known > 0.0 && times > Thresholds::EXPERIMENT_STATED {
            self.name += &format!(
                " (up to {times:.1} times as steep as the logs: check that the machine may)"
            );
        }
        self
    }
}

/// Random phases, crest factor as it comes, scaled to the half width.
fn multisine(
    n: usize,
    sample: f64,
    (from, to): (f64, f64),
    (centre, half): (f64, f64),
    seed: u64,
) -> Vec<f64> {
    let mut random = SplitMix64::new(seed);
    let length = n as f64 * sample;
    let lines: Vec<(f64, f64)> = (0..Thresholds::EXPERIMENT_LINES)
        .map(|k| {
            let f = from
                * (to / from)
                    .powf((k as f64 + random.uniform()) / Thresholds::EXPERIMENT_LINES as f64);
            let integer = (f * length).round().max(1.0) / length;
            (integer, std::f64::consts::TAU * random.uniform())
        })
        .collect();
    let wave: Vec<f64> = (0..n)
        .map(|k| {
            let t = k as f64 * sample;
            lines.iter().map(|(f, p)| (std::f64::consts::TAU * f * t + p).sin()).sum()
        })
        .collect();
    let peak = wave.iter().fold(1e-12_f64, |m, v| m.max(v.abs()));
    wave.iter().map(|v| centre + half * v / peak).collect()
}
