//! The timed side of `dev/benches/peers.py`: reads a problem, then runs a job once per line of standard
//! input and answers with one line of JSON, the seconds first.
//!
//! `peer FILE` where FILE holds little-endian doubles: samples n, dimension d, then n × d inputs and
//! n outputs. Jobs: see `run`.

use std::io::{BufRead, Write};
use std::time::Instant;

use learned::features::{Features, Narx};
use learned::gp::{GaussianProcess, Hyperparameters, likelihood};
use learned::lssvm::{Folds, LsSvm, Pruning, Samples, Settings, Validation, prune};
use learned::tune::{Swarm, grid_then_simplex, particle_swarm};
use learned::{Compressor, KernelSum};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let file = std::env::args().nth(1).ok_or("usage: peer FILE < jobs")?;
    let numbers: Vec<f64> = std::fs::read(file)?
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]))
        .collect();
    let (n, d) = (numbers[0] as usize, numbers[1] as usize);
    let (inputs, outputs) = numbers[2..].split_at(n * d);
    let samples = Samples::new(d, inputs.to_vec(), outputs.to_vec())?;
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let numbers: Vec<f64> = words[1..].iter().filter_map(|w| w.parse().ok()).collect();
        let answer = run(words[0], &numbers, &samples)?;
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}

/// The orders that give this number of NARX inputs, half of the outputs less the present command.
fn narx(d: usize) -> Features {
    let past = (d - 1) / 2;
    Features::Narx(Narx { commands: d - 1 - past, outputs: past })
}

/// Root mean square error of a simulation over samples that follow each other.
fn simulate(features: &Features, f: &KernelSum, samples: &Samples, part: &[usize]) -> f64 {
    let Features::Narx(narx) = features else { return f64::NAN };
    let first = samples.input(part[0]);
    let mut memory = first[1..=narx.commands + narx.outputs].to_vec();
    let u: Vec<f64> = part.iter().map(|i| samples.input(*i)[0]).collect();
    let y = features.continue_from(f, &u, &mut memory, 1e3);
    let squares = y.iter().zip(part).map(|(y, i)| (y - samples.outputs()[*i]).powi(2));
    (squares.sum::<f64>() / part.len() as f64).sqrt()
}

/// One job; the seconds are those of the work alone.
fn run(job: &str, x: &[f64], samples: &Samples) -> Result<String, Failure> {
    let features = narx(samples.dimension());
    let all: Vec<usize> = (0..samples.count()).collect();
    let settings = || Settings { gamma: x[0], sigma2: x[1] };
    let start = Instant::now();
    let seconds = || start.elapsed().as_secs_f64();
    Ok(match job {
        "train" => {
            let (model, report) = LsSvm::train(samples, settings())?;
            let t = seconds();
            let sum: f64 = model.weights.iter().map(|a| a * a).sum();
            let text = format!("{:?}", report.route);
            format!(
                "{{\"seconds\":{t},\"residual\":{},\"norm\":{},\"bias\":{},\"route\":{text:?}}}",
                report.residual,
                sum.sqrt(),
                model.bias
            )
        }
        // gamma sigma2 folds: rms in simulation mode on held-out blocks.
        "cv" => {
            let folds = Folds::blocks(samples.count(), x[2] as usize);
            let mut validation = Validation::new(samples, &folds)?;
            let models = validation.models(x[1], &x[..1])?;
            let mut sum = 0.0;
            for (model, part) in &models[0] {
                let rms = simulate(&features, &model.kernel_sum(), samples, part);
                sum += rms * rms * part.len() as f64;
            }
            let rms = (sum / samples.count() as f64).sqrt();
            let centres = models[0][0].0.count();
            format!("{{\"seconds\":{},\"rmse\":{rms},\"centres\":{centres}}}", seconds())
        }
        // gamma sigma2 least: Algorithm 1 with a simulation of all samples in each round.
        "prune" => {
            let pruning = Pruning { least_count: x[2] as usize, ..Pruning::default() };
            let judge = |m: &LsSvm| simulate(&features, &m.kernel_sum(), samples, &all);
            let pruned = prune(samples, settings(), pruning, judge)?;
            let t = seconds();
            let kept: usize = pruned.kept.iter().enumerate().map(|(k, i)| (k + 1) * i % 9973).sum();
            format!(
                "{{\"seconds\":{t},\"count\":{},\"rounds\":{},\"kept\":{kept},\"rmse\":{}}}",
                pruned.kept.len(),
                pruned.rounds.len(),
                pruned.rounds.last().map_or(f64::NAN, |r| r.error)
            )
        }
        // gamma sigma2 count: projection onto pivots, judged by simulation.
        "compress" => {
            let (model, _) = LsSvm::train(samples, settings())?;
            let full = simulate(&features, &model.kernel_sum(), samples, &all);
            let small = Compressor::new(&model, x[2] as usize).to(x[2] as usize);
            let t = seconds();
            let rmse = simulate(&features, &small.kernel_sum(), samples, &all);
            format!(
                "{{\"seconds\":{t},\"full\":{full},\"rmse\":{rmse},\"count\":{}}}",
                small.count()
            )
        }
        // folds, then pairs of gamma and sigma2: mean squares one step ahead.
        "fitness" => {
            let folds = Folds::interleaved(samples.count(), x[0] as usize);
            let mut validation = Validation::new(samples, &folds)?;
            let mut errors = Vec::new();
            for pair in x[1..].chunks_exact(2) {
                errors.push(validation.one_step(pair[1], &pair[..1])?[0]);
            }
            format!("{{\"seconds\":{},\"mse\":{errors:?}}}", seconds())
        }
        // folds particles iterations seed: the swarm; folds alone: the default search.
        "swarm" | "search" => {
            let folds = Folds::interleaved(samples.count(), x[0] as usize);
            let mut validation = Validation::new(samples, &folds)?;
            let bounds = [(0.0_f64, 7.0_f64), (-2.0, 16.0)];
            let mut visited = Vec::new();
            // First ln σ², then ln γ: one factor serves all γ.
            let mut row = |s: f64, gammas: &[f64]| -> Vec<f64> {
                let gammas: Vec<f64> = gammas.iter().map(|g| g.exp()).collect();
                visited.extend(gammas.iter().map(|g| [*g, s.exp()]));
                let none = vec![f64::INFINITY; gammas.len()];
                validation.one_step(s.exp(), &gammas).unwrap_or(none)
            };
            let best = if job == "search" {
                grid_then_simplex(&bounds, &mut row, &mut |_, _| true)
            } else {
                let [particles, iterations] = [x[1] as usize, x[2] as usize];
                let swarm = Swarm { particles, iterations, seed: x[3] as u64, ..Swarm::default() };
                let mut one = |p: &[f64]| row(p[0], &p[1..])[0];
                particle_swarm(&bounds, swarm, &mut one, &mut |_, _| true)
            };
            let t = seconds();
            format!(
                "{{\"seconds\":{t},\"mse\":{},\"evaluations\":{},\"sigma2\":{},\"gamma\":{},\"visited\":{visited:?}}}",
                best.value,
                best.evaluations,
                best.point[0].exp(),
                best.point[1].exp()
            )
        }
        // signal noise length…
        "likelihood" => {
            let (signal, noise, lengths) = (x[0], x[1], x[2..].to_vec());
            let found = likelihood(samples, &Hyperparameters { signal, noise, lengths })?;
            format!(
                "{{\"seconds\":{},\"value\":{},\"gradient\":{:?}}}",
                seconds(),
                found.value,
                found.gradient
            )
        }
        // repeats: one evaluation of a sum of all samples as centres, in s.
        "step" => {
            let weights = vec![0.1; samples.count()];
            let sigma = [(samples.dimension() as f64).sqrt()];
            let f = KernelSum::new(samples.dimension(), samples.inputs(), &weights, &sigma, 0.0);
            let (mut z, mut room) = (samples.input(0).to_vec(), samples.input(0).to_vec());
            let mut sum = 0.0;
            let start = Instant::now();
            for k in 0..x[0] as usize {
                z[0] += 1e-9 * k as f64;
                sum += f.value(&z, &mut room);
            }
            let each = start.elapsed().as_secs_f64() / x[0];
            format!("{{\"seconds\":{each},\"sum\":{sum}}}")
        }
        // signal noise length centres repeats: a process compressed, then one evaluation, in s.
        "compressed-gp" => {
            let (signal, noise, lengths) = (x[0], x[1], vec![x[2]]);
            let gp = GaussianProcess::train(samples, &Hyperparameters { signal, noise, lengths })?;
            let small = gp.compressor(x[3] as usize).to(x[3] as usize);
            let (f, full) = (small.kernel_sum(), gp.kernel_sum());
            let (scales, mut room) = (gp.scales(), vec![0.0; samples.dimension()]);
            let scaled = |i: usize| -> Vec<f64> {
                samples.input(i).iter().zip(&scales).map(|(x, s)| x * s).collect()
            };
            let worst = all.iter().map(|i| {
                let a = f.value(&scaled(*i), &mut room);
                (a - full.value(samples.input(*i), &mut room)).abs()
            });
            let worst = worst.fold(0.0, f64::max);
            let (mut z, mut sum) = (scaled(0), 0.0);
            let start = Instant::now();
            for k in 0..x[4] as usize {
                z[0] += 1e-9 * k as f64;
                sum += f.value(&z, &mut room);
            }
            let each = start.elapsed().as_secs_f64() / x[4];
            format!("{{\"seconds\":{each},\"worst\":{worst},\"sum\":{sum}}}")
        }
        other => return Err(format!("no job {other}").into()),
    })
}
