//! Time of training and of one step.

use divan::{Bencher, black_box};
use learned::KernelSum;
use learned::lssvm::{LsSvm, Samples, Settings};

fn main() {
    divan::main();
}

/// Numbers without structure, from −1 to 1.
fn wave(count: usize) -> Vec<f64> {
    (0..count).map(|i| (1.3 * (i as f64 + 1.0) * (i as f64 + 0.37)).sin()).collect()
}

/// Centres and coordinates: the laser beam paper's pruned model, the nanopositioning paper's, a
/// compressed process.
#[divan::bench(args = [(551, 6), (1500, 57), (250, 12)])]
fn one_step(bencher: Bencher, (count, dimension): (usize, usize)) {
    let sigma = [(dimension as f64).sqrt()];
    let f = KernelSum::new(dimension, &wave(count * dimension), &vec![0.1; count], &sigma, 0.0);
    let (z, mut room) = (vec![0.2; dimension], vec![0.0; dimension]);
    bencher.bench_local(|| f.value(black_box(&z), &mut room));
}

/// Number of samples of six coordinates; σ² that leaves a low rank, and one that does not.
#[divan::bench(args = [(1000, 2.0), (2000, 2.0), (4000, 2.0), (1000, 0.01)], sample_count = 5)]
fn training(bencher: Bencher, (count, sigma2): (usize, f64)) {
    let inputs = wave(count * 6);
    let outputs = inputs.chunks_exact(6).map(|x| x[0].sin() + 0.3 * x[1]).collect();
    let samples = Samples::new(6, inputs, outputs).expect("samples");
    let settings = Settings { gamma: 1e4, sigma2 };
    bencher.bench_local(|| LsSvm::train(black_box(&samples), settings).expect("a model"));
}
