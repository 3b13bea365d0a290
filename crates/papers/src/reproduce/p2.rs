//! Piezo bimorph: LS-SVM for the hysteresis term of a second-order model, with three sets of inputs.
//!
//! ```text
//! ÿ + 2ξω ẏ + ω² y = d·u + h,   ĥ_k = f(u_k … u_{k−2}, y_k … y_{k−2}, ĥ_{k−1}, ĥ_{k−2})
//! ```

use learned::lssvm::{LsSvm, Samples, Settings, leave_one_out};
use learned::tune::grid_then_simplex;

use super::figures::{self, Chapter};
use super::{Aim, Order, Reproduction, Row, response};

const ID: &str = "P2";
const RIG: &str = "p2-truth";
/// 2ξω, ω², d of the printed G(s), in um and V.
const DAMPING: f64 = 1.847;
const STIFFNESS: f64 = 6.477e6;
const GAIN: f64 = 1.247e8;
/// Past values m = n = l.
const PAST: usize = 2;

/// Which signals a model is told.
#[derive(Clone, Copy, PartialEq)]
struct Inputs {
    name: &'static str,
    command: bool,
    position: bool,
}

const MODELS: [Inputs; 3] = [
    Inputs { name: "model I (u, h)", command: true, position: false },
    Inputs { name: "model II (y, h)", command: false, position: true },
    Inputs { name: "model III (u, y, h)", command: true, position: true },
];

/// A record with its hysteresis term, all of order one.
struct Record {
    /// Sample time in s.
    period: f64,
    u: Vec<f64>,
    y: Vec<f64>,
    h: Vec<f64>,
    range: f64,
}

/// Scales that make u, y and h of order one: 10 V, 200 um, and ω² times 30 um.
const SCALES: [f64; 3] = [10.0, 200.0, 30.0 * STIFFNESS];

fn record(name: &str) -> anyhow::Result<Record> {
    let run = response(RIG, name, &[], 1.0)?;
    let y: Vec<f64> = run.after().iter().map(|y| y - run.position[0]).collect();
    let (u, t) = (run.command, run.period);
    let at = |k: isize| y[k.clamp(0, y.len() as isize - 1) as usize];
    let h = (0..y.len() as isize).map(|k| {
        let acceleration = (at(k + 1) - 2.0 * at(k) + at(k - 1)) / (t * t);
        let rate = (at(k + 1) - at(k - 1)) / (2.0 * t);
        let own = k as usize;
        (acceleration + DAMPING * rate + STIFFNESS * y[own] - GAIN * u[own]) / SCALES[2]
    });
    let range = y.iter().copied().fold(0.0, f64::max) - y.iter().copied().fold(0.0, f64::min);
    Ok(Record {
        period: t,
        h: h.collect(),
        u: u.iter().map(|u| u / SCALES[0]).collect(),
        y: y.iter().map(|y| y / SCALES[1]).collect(),
        range,
    })
}

impl Inputs {
    fn dimension(self) -> usize {
        (PAST + 1) * (usize::from(self.command) + usize::from(self.position)) + PAST
    }

    /// x_k with these past values of h.
    fn at(self, record: &Record, k: usize, h: [f64; PAST]) -> Vec<f64> {
        let mut x = Vec::with_capacity(self.dimension());
        for (told, signal) in [(self.command, &record.u), (self.position, &record.y)] {
            if told {
                x.extend((0..=PAST).map(|i| signal[k.saturating_sub(i)]));
            }
        }
        x.extend(h);
        x
    }

    fn samples(self, record: &Record) -> Result<Samples, learned::Error> {
        let h = &record.h;
        let x = (0..h.len())
            .flat_map(|k| self.at(record, k, [h[k.saturating_sub(1)], h[k.saturating_sub(2)]]));
        Samples::new(self.dimension(), x.collect(), h.clone())
    }

    /// ĥ with its own past values; u and y as measured.
    fn run(self, model: &LsSvm, record: &Record) -> Vec<f64> {
        let (f, mut room) = (model.kernel_sum(), vec![0.0; self.dimension()]);
        let mut past = [record.h[0]; PAST];
        let mut all = Vec::with_capacity(record.h.len());
        for k in 0..record.h.len() {
            let h = f.value(&self.at(record, k, past), &mut room).clamp(-1e3, 1e3);
            past = [h, past[0]];
            all.push(h);
        }
        all
    }
}

/// Settings of least leave-one-out error.
fn tuned(samples: &Samples) -> anyhow::Result<LsSvm> {
    let mut row = |s: f64, gammas: &[f64]| -> Vec<f64> {
        let error = |g: &f64| {
            let settings = Settings { gamma: g.exp(), sigma2: s.exp() };
            let squares = |errors: Vec<f64>| errors.iter().map(|e| e * e).sum::<f64>();
            leave_one_out(samples, settings).map_or(f64::INFINITY, squares)
        };
        gammas.iter().map(error).collect()
    };
    let bounds = [(-2.0, 6.0), (2.0, 20.0)];
    let best = grid_then_simplex(&bounds, &mut row, &mut |_, _| true);
    let settings = Settings { sigma2: best.point[0].exp(), gamma: best.point[1].exp() };
    Ok(LsSvm::train(samples, settings)?.0)
}

/// Errors of ĥ and of y in percent of their ranges. The derivatives of (5) are 2·10⁻⁵ of its other
/// terms, so that y is (d·u + ĥ)/ω².
fn errors(inputs: Inputs, model: &LsSvm, record: &Record) -> [f64; 2] {
    let h = inputs.run(model, record);
    let rms = identify::learned::rms_difference(&h, &record.h);
    let span = |x: &[f64]| {
        x.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - x.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let y = rms * SCALES[2] / STIFFNESS;
    [100.0 * rms / span(&record.h), 100.0 * y / record.range]
}

/// The hysteresis term, as it follows from the measured signals and as the models simulate it.
fn seen(records: &[Record; 3], models: &[(Inputs, LsSvm)]) -> Chapter {
    let text = "The hysteresis term h of the second-order model, as a displacement h/ω².";
    let mut chapter = Chapter::new("the hysteresis term", text);
    let scale = SCALES[2] / STIFFNESS;
    let displacement = |h: &[f64]| h.iter().map(|h| h * scale).collect::<Vec<f64>>();
    for (record, name) in records.iter().zip(["training", "test 1", "test 2"]) {
        let simulated: Vec<(&str, Vec<f64>)> = models
            .iter()
            .map(|(inputs, model)| (inputs.name, displacement(&inputs.run(model, record))))
            .collect();
        let models: Vec<(&str, &[f64])> = simulated.iter().map(|(n, h)| (*n, &h[..])).collect();
        let measured = displacement(&record.h);
        let title = format!("h, {name}");
        chapter = chapter.figure(figures::model(title, "um", record.period, &measured, &models));
    }
    chapter
}

pub(super) fn run(say: &dyn Fn(&str)) -> anyhow::Result<Reproduction> {
    let records = [record("p2-train")?, record("p2-test-1")?, record("p2-test-2")?];
    let mut answer = Reproduction::default();
    let mut all = Vec::new();
    let mut models = Vec::new();
    for inputs in MODELS {
        say(inputs.name);
        let model = tuned(&inputs.samples(&records[0])?)?;
        all.push(records.each_ref().map(|record| errors(inputs, &model, record)));
        models.push((inputs, model));
    }
    answer.chapters.push(seen(&records, &models));
    let names = ["training", "test 1", "test 2"];
    for ((name, paper), error) in names.iter().zip([1.05, 0.35, 0.50]).zip(all[2]) {
        let what = format!("model III, y, {name}");
        answer.rows.push(Row::new(ID, what, "%", paper, error[1], Aim::Reach));
    }
    for (inputs, errors) in MODELS.iter().zip(&all) {
        let told: Vec<String> = names
            .iter()
            .zip(errors)
            .map(|(name, [h, y])| format!("{name} h {h:.3} %, y {y:.3} %"))
            .collect();
        answer.remarks.push(format!("{}: {}", inputs.name, told.join("; ")));
    }
    for (k, name) in names.iter().enumerate() {
        let holds = all[2][k][1] <= all[0][k][1] && all[2][k][1] <= all[1][k][1];
        let what = format!("model III is the best of the three, {name}");
        answer.orders.push(Order { paper_id: ID, what, holds });
    }
    answer.remarks.push(
        "u and y are measured, past h the model's own, as in the paper's compensation; model I, \
         which is not told y, is a simulation. Test signals 1 and 2 stand in for figures"
            .into(),
    );
    Ok(answer)
}
