//! The machine: signals, baseline and records.

use std::f64::consts::TAU;

use components::COMPONENTS;
use data::{Blueprint, CheckedBlueprint, Log};

use super::truth::Effect;

/// Sample rate in Hz.
pub const RATE: f64 = 4000.0;
/// Full stroke in um.
pub const STROKE: f64 = 10.0;
const R: [f64; 8] = [0.0, 5.0, 10.0, 16.0, 24.0, 34.0, 46.0, 60.0];
const W: [f64; 8] = [0.058, 0.012, 0.009, 0.008, 0.007, 0.006, 0.005, 0.004];

/// The model that is diagnosed.
pub fn blueprint() -> CheckedBlueprint {
    let text = format!(
        "piezoloop = 1\nkind = \"plant\"\nname = \"stage\"\nstep = {}\n[[axis]]\nname = \"X\"\n\
         command = {{ name = \"u\", unit = \"V\", min = 0, max = 120, start = 0 }}\n\
         position = {{ name = \"y\", unit = \"um\" }}\n\
         [[axis.component]]\ntype = \"prandtl-ishlinskii\"\nr = {R:?}\nw = {W:?}\ntolerance = {{ w = 0.05 }}\n\
         [[axis.component]]\ntype = \"mode\"\nname = \"mechanics\"\nfrequency = 300\ndamping = 0.04\n\
         tolerance = {{ frequency = 0.01, damping = 0.15 }}\n",
        1.0 / RATE
    );
    Blueprint::parse(&text, "stage.toml").unwrap().check(COMPONENTS).unwrap()
}

/// Normal random numbers of a seed.
pub struct Normal(u64);

impl Normal {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678_9abc_def1)
    }
    pub fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn draw(&mut self) -> f64 {
        (-2.0 * self.uniform().max(1e-300).ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// What changes a mode: factors of its frequency and damping, hardening, friction.
type Forces = ((f64, f64), Option<f64>, Option<f64>);

/// What the stages of one machine gave for a record the last time: most strengths of an effect change one stage.
struct Known {
    hysteresis: Last<Option<f64>>,
    mode: Last<Forces>,
}

impl Known {
    const fn new() -> Self {
        Self { hysteresis: Last(None), mode: Last(None) }
    }
}

/// Input, parameters and output of a stage.
struct Last<P>(Option<(Vec<f64>, P, Vec<f64>)>);

impl<P: Copy + PartialEq> Last<P> {
    /// The output for an input and parameters, computed unless they are the last ones.
    fn of(&mut self, (input, parameters): (&[f64], P), new: impl FnOnce() -> Vec<f64>) -> Vec<f64> {
        match &self.0 {
            Some((u, p, output)) if u == input && *p == parameters => output.clone(),
            _ => {
                let output = new();
                self.0 = Some((input.to_vec(), parameters, output.clone()));
                output
            }
        }
    }
}

/// One machine: its parameters are drawn around the model's, within tolerance.
pub struct Machine {
    pub w: [f64; 8],
    pub frequency: f64,
    pub damping: f64,
    pub gain: f64,
    /// Noise in um.
    pub sigma: f64,
    pub effects: Vec<(Effect, f64)>,
    pub seed: u64,
}

impl Machine {
    /// Without effects; `spread` in units of the tolerances.
    pub fn new(seed: u64, spread: f64) -> Self {
        let mut random = Normal::new(seed);
        let mut w = W;
        for w in &mut w {
            *w *= 1.0 + 0.05 * spread * random.draw().clamp(-2.0, 2.0);
        }
        Self {
            w,
            frequency: 300.0 * (1.0 + 0.01 * spread * random.draw().clamp(-2.0, 2.0)),
            damping: 0.04 * (1.0 + 0.15 * spread * random.draw().clamp(-2.0, 2.0)),
            gain: 1.0 + 0.01 * spread * random.draw().clamp(-2.0, 2.0),
            sigma: 1e-3 * STROKE,
            effects: Vec::new(),
            seed,
        }
    }

    /// With an effect whose size makes `rms(change)/sigma` equal to `size`.
    pub fn with(mut self, effect: Effect, size: f64) -> Self {
        // Parameters are re-tuned before anything is an effect: these must leave their tolerance.
        let size = match effect {
            Effect::ActuatorGain | Effect::Hysteresis => size + 100.0,
            Effect::ResonanceShift | Effect::Damping => 4.0 * size,
            _ => size,
        };
        let records = self.commands();
        let positions = |machine: &Self, known: &mut [Known]| -> Vec<Vec<f64>> {
            let each = records.iter().zip(known).enumerate();
            each.map(|(k, (u, known))| machine.position_from(k, u, known)).collect()
        };
        let mut known = [const { Known::new() }; 4];
        let without = positions(&self, &mut known);
        let mut rms = |machine: &Self| {
            let (mut sum, mut count) = (0.0, 0.0);
            for (a, b) in positions(machine, &mut known).iter().zip(&without) {
                let mean = a.iter().zip(b).map(|(a, b)| a - b).sum::<f64>() / a.len() as f64;
                sum += a.iter().zip(b).map(|(a, b)| (a - b - mean).powi(2)).sum::<f64>();
                count += a.len() as f64;
            }
            (sum / count).sqrt() / machine.sigma
        };
        // Bisection on the logarithm of the strength.
        let (mut low, mut high) = (-12.0_f64, 3.0_f64);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let mut effects = self.effects.clone();
            effects.push((effect, middle.exp()));
            let trial = Self { effects, w: self.w, ..self };
            if rms(&trial) < size { low = middle } else { high = middle }
        }
        self.effects.push((effect, (0.5 * (low + high)).exp()));
        self
    }

    /// Commands of the records: multisine, triangle, staircase, sweep.
    pub fn commands(&self) -> Vec<Vec<f64>> {
        let mut random = Normal::new(self.seed ^ 0xabc);
        let n = 6000;
        let t = |k: usize| k as f64 / RATE;
        let lines: Vec<(f64, f64)> = (0..60)
            .map(|k| (2.0 * 300f64.powf(f64::from(k) / 59.0), TAU * random.uniform()))
            .collect();
        let sine = |k: usize| lines.iter().map(|(f, p)| (TAU * f * t(k) + p).sin()).sum::<f64>();
        let peak = (0..n).map(|k| sine(k).abs()).fold(0.0, f64::max);
        let multi = (0..n).map(|k| 60.0 + 50.0 * sine(k) / peak).collect();
        let triangle = (0..n)
            .map(|k| {
                let cycle = (t(k) * 4.0).fract();
                let size = 115.0 * (1.0 - 0.8 * t(k) / t(n));
                size * (1.0 - (2.0 * cycle - 1.0).abs())
            })
            .collect();
        let levels: Vec<f64> = (0..12).map(|_| 10.0 + 100.0 * random.uniform()).collect();
        let stairs = (0..n).map(|k| levels[k * 12 / n]).collect();
        let sweep = (0..n)
            .map(|k| {
                let (f0, f1, end) = (1.0_f64, 150.0_f64, t(n));
                let rate = (f1 / f0).ln() / end;
                60.0 + 40.0 * (TAU * f0 * ((rate * t(k)).exp() - 1.0) / rate).sin()
            })
            .collect();
        vec![multi, triangle, stairs, sweep]
    }

    /// Another axis' command.
    pub fn neighbour(&self, record: usize) -> Vec<f64> {
        let mut random = Normal::new(self.seed ^ (0x77 + record as u64));
        let lines: Vec<(f64, f64)> = (0..25)
            .map(|k| (1.0 * 200f64.powf(f64::from(k) / 24.0), TAU * random.uniform()))
            .collect();
        (0..6000)
            .map(|k| {
                let t = k as f64 / RATE;
                60.0 + 10.0 * lines.iter().map(|(f, p)| (TAU * f * t + p).sin()).sum::<f64>()
            })
            .collect()
    }

    /// Noise-free position at each row, in um.
    pub fn position(&self, record: usize, u: &[f64]) -> Vec<f64> {
        self.position_from(record, u, &mut Known::new())
    }

    /// Noise-free position, with what the last call for this record has computed already.
    fn position_from(&self, record: usize, u: &[f64], known: &mut Known) -> Vec<f64> {
        let h = 1.0 / RATE;
        let find = |e: Effect| self.effects.iter().find(|(x, _)| *x == e).map(|(_, s)| *s);
        let v = super::truth::input_side(self, u);
        // Actuator.
        let rate = find(Effect::RateDependence);
        let mut x = known.hysteresis.of((&v, rate), || self.hysteresis(&v, rate));
        super::truth::actuator(self, &v, || self.neighbour(record), &mut x);
        // Mechanics: the mode by exact steps.
        let forces = (self.changes(), find(Effect::Duffing), find(Effect::Friction));
        let x = known.mode.of((&x, forces), || self.mode(&x, forces));
        super::truth::output_side(self, record, u, x, h)
    }

    /// Rows see what acted before them.
    fn hysteresis(&self, v: &[f64], rate: Option<f64>) -> Vec<f64> {
        let mut plays: Vec<f64> = R.iter().map(|r| (v[0] - r).max((v[0] + r).min(0.0))).collect();
        let mut late = v[0];
        let mut out = Vec::with_capacity(v.len());
        for k in 0..v.len() {
            let u = if k == 0 { v[0] } else { v[k - 1] };
            // Another formula than the library's: the thresholds move with the filtered speed, and
            // saturate.
            let mut factor = 1.0;
            if let Some(s) = rate {
                let speed = (u - late).abs();
                late += 0.3 * (u - late);
                factor += s * (speed / 10.0).tanh();
            }
            let mut sum = 0.0;
            for ((p, r), w) in plays.iter_mut().zip(R).zip(self.w) {
                let r = r * factor;
                *p = (u - r).max((u + r).min(*p));
                sum += w * *p;
            }
            out.push(self.gain * sum);
        }
        out
    }

    /// Factors of frequency and damping.
    fn changes(&self) -> (f64, f64) {
        self.effects
            .iter()
            .map(|(e, s)| match e {
                Effect::ResonanceShift => (1.0 - 0.1 * s, 1.0),
                Effect::Damping => (1.0, 1.0 + s),
                _ => (1.0, 1.0),
            })
            .fold((1.0, 1.0), |a, b| (a.0 * b.0, a.1 * b.1))
    }

    fn mode(&self, u: &[f64], (shift, duffing, friction): Forces) -> Vec<f64> {
        // Twenty fine steps per row of the damped oscillator.
        let fine = 20;
        let w0 = TAU * self.frequency * shift.0;
        let zeta = self.damping * shift.1;
        let h = 1.0 / (RATE * f64::from(fine));
        let transition = components::linear::Transition::new(w0 / TAU, zeta, h);
        let (mut x, mut rate) = (u[0], 0.0);
        let mut out = vec![x];
        for k in 1..u.len() {
            for _ in 0..fine {
                let e = (x - 5.0) / 5.0;
                let mut pull = duffing.map_or(0.0, |s| 5.0 * s * (e * e * e + 0.1 * e.powi(5)));
                if let Some(s) = friction {
                    // Coulomb with a Stribeck rise, smoothed.
                    let v = rate * w0;
                    pull += s * (v / 20.0).tanh() * (1.0 + 0.3 * (-(v / 200.0).powi(2)).exp());
                }
                let target = u[k] - pull;
                let (e, r) = transition.apply(x - target, rate);
                (x, rate) = (target + e, r);
            }
            out.push(x);
        }
        out
    }

    /// A log under this command, of which nothing else is known.
    pub fn log(&self, number: u64, u: &[f64]) -> Log {
        let mut noise = Normal::new(self.seed ^ (0xabc + number));
        let y = self.position(0, u).into_iter().map(|y| y + self.sigma * noise.draw()).collect();
        let time = (0..u.len()).map(|k| k as f64 / RATE).collect();
        let mut log = Log::new(&format!("played{number}.csv"), time).unwrap();
        log.add_column("u", Some("V"), u.to_vec()).unwrap();
        log.add_column("y", Some("um"), y).unwrap();
        log
    }

    /// The logs, one per record.
    pub fn logs(&self) -> Vec<Log> {
        let mut noise = Normal::new(self.seed ^ 0x5eed);
        let commands = self.commands();
        commands
            .iter()
            .enumerate()
            .map(|(k, u)| {
                let y = self.position(k, u);
                let mut slow = 0.0;
                let y = y
                    .iter()
                    .map(|y| {
                        // White noise and a little of a slow one.
                        slow = 0.99 * slow + 0.14 * noise.draw();
                        y + self.sigma * (0.97 * noise.draw() + 0.22 * slow)
                    })
                    .collect();
                let time = (0..u.len()).map(|k| k as f64 / RATE).collect();
                let mut log = Log::new(&format!("record{k}.csv"), time).unwrap();
                log.add_column("u", Some("V"), u.clone()).unwrap();
                log.add_column("y", Some("um"), y).unwrap();
                log.add_column("u2", Some("V"), self.neighbour(k)).unwrap();
                log
            })
            .collect()
    }
}
