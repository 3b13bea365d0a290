//! Time of one step: plays, their inverse, modes under a force, Preisach in constant time and relay by relay.
//!
//! Each sample runs 1000 steps over a sine with a slow change of amplitude (minor loops), or over
//! white noise; divan's item throughput is steps per second.

use components::find;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use model::{Component, Tick};
use numerics::random::SplitMix64;

const STEPS: usize = 1000;
const T: f64 = 2e-5;

fn main() {
    divan::main();
}

/// A component with its slices.
struct Instance {
    component: &'static dyn Component,
    coefficients: Vec<f64>,
    state: Vec<f64>,
    index: u64,
}

impl Instance {
    fn new(kind: &str, structure: &[f64], parameters: &[f64]) -> Self {
        let component = find(kind).expect("registered");
        let sizes = component.sizes(structure, T);
        let mut coefficients = vec![0.0; sizes.coefficients];
        component.prepare(structure, parameters, T, &mut coefficients).expect("valid");
        let mut state = vec![0.0; sizes.states];
        component.rest(&coefficients, &[0.0], &mut state, &mut [0.0]);
        Self { component, coefficients, state, index: 0 }
    }

    #[inline]
    fn step(&mut self, u: f64) -> f64 {
        self.index += 1;
        let tick = Tick { index: self.index, time: self.index as f64 * T, period: T };
        let mut y = [0.0];
        self.component.step(&self.coefficients, &mut self.state, tick, &[u], &mut y);
        y[0]
    }
}

/// Commands in 0 … 120 V.
fn sine() -> Vec<f64> {
    let wave = |n: usize| (0.02 * n as f64).sin() * (0.6 + 0.4 * (0.0031 * n as f64).cos());
    (0..STEPS).map(|n| 60.0 + 60.0 * wave(n)).collect()
}

fn noise() -> Vec<f64> {
    let mut random = SplitMix64::new(1);
    (0..STEPS).map(|_| 120.0 * random.uniform()).collect()
}

fn run(bencher: Bencher<'_, '_>, mut instance: Instance, signal: Vec<f64>) {
    bencher
        .counter(ItemsCount::new(STEPS))
        .bench_local(move || signal.iter().fold(0.0, |sum, u| sum + instance.step(black_box(*u))));
}

fn plays(count: usize, tail: &[f64]) -> Vec<f64> {
    let r = (0..count).map(|i| 6.0 * i as f64);
    let w = (0..count).map(|i| 0.03 / (i + 1) as f64);
    r.chain(w).chain(tail.iter().copied()).collect()
}

#[divan::bench]
fn prandtl_ishlinskii_10(bencher: Bencher<'_, '_>) {
    run(bencher, Instance::new("prandtl-ishlinskii", &[10.0], &plays(10, &[0.0])), sine());
}

#[divan::bench]
fn inverse_prandtl_ishlinskii_10(bencher: Bencher<'_, '_>) {
    let kind = "inverse-prandtl-ishlinskii";
    run(bencher, Instance::new(kind, &[10.0], &plays(10, &[0.0])), sine());
}

#[divan::bench]
fn inverse_rate_dependent_play_10(bencher: Bencher<'_, '_>) {
    let p = plays(10, &[0.0, 0.05, 1e-5, -20.0, 150.0]);
    run(bencher, Instance::new("inverse-rate-dependent-play", &[10.0], &p), sine());
}

#[divan::bench]
fn bouc_wen(bencher: Bencher<'_, '_>) {
    let p = [0.06, 0.2, 0.02, 0.01, 0.0, 1.0, 0.0];
    run(bencher, Instance::new("bouc-wen", &[], &p), sine());
}

/// A mode that hardens by 5 % over the range, 250, 50 and 25 steps per period.
#[divan::bench(args = [200.0, 1000.0, 2000.0])]
fn duffing(bencher: Bencher<'_, '_>, frequency: f64) {
    run(bencher, Instance::new("duffing", &[], &[frequency, 0.02, 0.05, 120.0]), sine());
}

/// Damping that grows with the speed, without Coulomb friction.
#[divan::bench]
fn nonlinear_damping(bencher: Bencher<'_, '_>) {
    let p = [1000.0, 0.02, 0.0, 1.0, 1e-8];
    run(bencher, Instance::new("nonlinear-damping", &[], &p), sine());
}

const LEVELS: usize = 120;

fn weights() -> Vec<f64> {
    (0..LEVELS * (LEVELS + 1) / 2).map(|k| 1e-3 * (1.0 + (k % 7) as f64)).collect()
}

fn preisach() -> Instance {
    let mu = weights();
    let p: Vec<f64> = mu.iter().copied().chain([0.0, 120.0, 0.0]).collect();
    Instance::new("preisach", &[mu.len() as f64], &p)
}

#[divan::bench]
fn preisach_120_levels_sine(bencher: Bencher<'_, '_>) {
    run(bencher, preisach(), sine());
}

#[divan::bench]
fn preisach_120_levels_noise(bencher: Bencher<'_, '_>) {
    run(bencher, preisach(), noise());
}

/// All 7260 relays one by one, in the plain form of the definition.
#[divan::bench]
fn preisach_120_levels_relay_by_relay(bencher: Bencher<'_, '_>) {
    let (mu, signal) = (weights(), sine());
    let mut on = vec![0.0f64; mu.len()];
    bencher.counter(ItemsCount::new(STEPS)).bench_local(move || {
        let mut total = 0.0;
        for u in &signal {
            let level = (black_box(*u).floor() as usize).min(LEVELS);
            let (mut sum, mut at) = (0.0, 0);
            for i in 1..=LEVELS {
                for j in 1..=i {
                    on[at] = if level >= i {
                        1.0
                    } else if level < j {
                        0.0
                    } else {
                        on[at]
                    };
                    sum += mu[at] * on[at];
                    at += 1;
                }
            }
            total += sum;
        }
        total
    });
}

/// 19 modes over three axes: a steering mirror.
#[divan::bench]
fn modal_matrix_19_of_3(bencher: Bencher<'_, '_>) {
    const MODES: usize = 19;
    let component = find("modal-matrix").expect("registered");
    let structure = [3.0, 9.0, MODES as f64, 9.0 * MODES as f64];
    let frequencies = (0..MODES).map(|k| 200.0 + 140.0 * k as f64);
    let residues = (0..18 * MODES).map(|k| (0.7 * k as f64).sin());
    let direct = (0..9).map(|k| 0.1 * f64::from(k));
    let dampings = [0.01; MODES];
    let parameters: Vec<f64> = direct.chain(frequencies).chain(dampings).chain(residues).collect();
    let sizes = component.sizes(&structure, T);
    let (mut coefficients, mut state) = (vec![0.0; sizes.coefficients], vec![0.0; sizes.states]);
    component.prepare(&structure, &parameters, T, &mut coefficients).expect("valid");
    let mut y = [0.0; 3];
    component.rest(&coefficients, &[0.0; 3], &mut state, &mut y);
    let signal = noise();
    bencher.counter(ItemsCount::new(STEPS)).bench_local(move || {
        for (index, u) in signal.iter().enumerate() {
            let tick = Tick { index: index as u64, time: index as f64 * T, period: T };
            let x = black_box([*u, -*u, 0.5 * u]);
            component.step(&coefficients, &mut state, tick, &x, &mut y);
        }
        y[0]
    });
}
