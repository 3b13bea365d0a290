//! A small network over what plays remember: what it adds is what plays between two curves leave.
//!
//! The plays, curves and creep are those of `curved-prandtl-ishlinskii`, and stay as they are unless a fit of all together
//! ([`joint`]) is much better: what one loop leaves open about smaller ones, their smooth density says. In free run
//! the network feeds nothing back, so that its error is that of the simulation, and its gradient a product.
//!
//! ```text
//! Σ e² + N·(HEIGHT²·Σ height² + WEIGHT²·Σ (weight − first)²) is least,   e without its mean over each record
//! ```
//!
//! by Levenberg–Marquardt from [`STARTS`] networks of random first weights, which stay near them. The mean of these networks
//! is written, itself a network of all their units: where no record went each of them says something else, and their mean
//! errs less than most.

mod joint;

use components::random::normal;
use data::{ComponentBlueprint, Value};
use learned::plays::{INPUTS, inputs_of, unit, unit_slope};
use nalgebra::{DMatrix, DVector};
use numerics::levenberg_marquardt::damped_step;

use self::joint::Joint;
use crate::error::Error;
use crate::identify::SIGNIFICANT_FALL;
use crate::methods::Chain;
use crate::observer::Observer;

/// Units of each network.
const UNITS: usize = 8;
/// Numbers of one unit: weights, bias, height.
const EACH: usize = INPUTS + 2;
/// What a height costs, over half the position's range, and a weight that leaves its first value.
const HEIGHT: f64 = 0.1;
const WEIGHT: f64 = 5e-4;
/// Networks whose mean is taken.
const STARTS: usize = 3;
/// Most steps of each search, and the relative fall of the sum that ends it.
const STEPS: usize = 60;
const FALL: f64 = 1e-5;
/// Parts of [`HEIGHT`]'s cost that are tried where plays and network are fitted together, one after the other.
const PRICES: [f64; 3] = [1.0, 0.1, 0.01];
/// Most rows that are learned from.
const ROWS: usize = 20_000;
/// Name of the random numbers, for all to be the same in every run.
const SEED: f64 = 325.0;

/// One record: the signal that the hysteresis sees at each internal step, from rest on, and the positions to meet.
pub(crate) struct TrainingRecord {
    pub(crate) signal: Vec<f64>,
    /// Internal steps per row.
    pub(crate) substeps: usize,
    /// First row that is met.
    pub(crate) first: usize,
    pub(crate) position: Vec<f64>,
}

impl TrainingRecord {
    /// Internal step and position of every row of `every` that is met.
    fn rows(&self, every: usize) -> impl Iterator<Item = (usize, f64)> {
        let step = |k: usize| (self.first + k) * self.substeps;
        let rows = self.position.iter().enumerate().step_by(every);
        rows.map(move |(k, y)| (step(k), *y)).take_while(|(k, _)| *k < self.signal.len())
    }

    /// The first two thirds of the rows, and the others.
    fn parted(&self) -> (Self, Self) {
        let rows = 2 * self.position.len() / 3;
        let (begun, rest) = self.position.split_at(rows);
        let of = |first: usize, position: &[f64]| Self {
            signal: self.signal.clone(),
            substeps: self.substeps,
            first,
            position: position.to_vec(),
        };
        (of(self.first, begun), of(self.first + rows, rest))
    }
}

fn without_means(values: &mut [f64]) {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter_mut().for_each(|e| *e -= mean);
}

/// The plays of a chain `amplifier-nonlinearity, prandtl-ishlinskii, kelvin-voigt-creep` and `sensor-polynomial`.
#[derive(Clone)]
pub(crate) struct Plays {
    pub(crate) r: Vec<f64>,
    pub(crate) w: Vec<f64>,
    pub(crate) share: Vec<f64>,
    pub(crate) time_constant: Vec<f64>,
    /// offset, bend, centre, half_range, quadratic, cubic, position_centre, position_half_range.
    pub(crate) scalars: [f64; 8],
}

const SCALARS: [&str; 8] = [
    "offset",
    "bend",
    "centre",
    "half_range",
    "quadratic",
    "cubic",
    "position_centre",
    "position_half_range",
];
/// Half ranges beyond which the command counts as its limit.
const BEYOND: f64 = 1.5;

impl Plays {
    /// The plays of a chain of `curved-prandtl-ishlinskii`.
    pub(crate) fn of(chain: &Chain) -> Option<Self> {
        let [bend, plays, creep] = &chain.hysteresis[..] else { return None };
        let [curve] = &chain.reading[..] else { return None };
        let numbers = |of: &ComponentBlueprint, name: &str| -> Option<Vec<f64>> {
            let number = |value: &Value| match value {
                Value::Number(number) => Some(*number),
                _ => None,
            };
            match of.get(name)? {
                Value::List(items) => items.iter().map(number).collect(),
                one => number(one).map(|number| vec![number]),
            }
        };
        let one = |of: &ComponentBlueprint, name: &str| numbers(of, name)?.first().copied();
        Some(Self {
            r: numbers(plays, "r")?,
            w: numbers(plays, "w")?,
            share: numbers(creep, "share")?,
            time_constant: numbers(creep, "time_constant")?,
            scalars: [
                one(plays, "offset")?,
                one(bend, "quadratic")?,
                one(bend, "centre")?,
                one(bend, "half_range")?,
                one(curve, "quadratic")?,
                one(curve, "cubic")?,
                one(curve, "centre")?,
                one(curve, "half_range")?,
            ],
        })
    }

    /// What the network sees of a signal and the position with it, in the component's own code.
    fn simulated(
        &self,
        network: &[f64],
        signal: &[f64],
        step: f64,
    ) -> Result<Vec<([f64; INPUTS], f64)>, Error> {
        let units = network.len() / EACH;
        let structure =
            [self.r.len(), self.share.len(), units, units * INPUTS, 1].map(|count| count as f64);
        let of = |k: usize| network.chunks_exact(EACH).map(move |unit| unit[k]);
        let heights: Vec<f64> = of(INPUTS + 1).chain(of(INPUTS)).collect();
        let weights: Vec<f64> =
            network.chunks_exact(EACH).flat_map(|unit| &unit[..INPUTS]).copied().collect();
        let arrays = [
            &self.r[..],
            &self.w,
            &self.share,
            &self.time_constant,
            &heights,
            &weights,
            &self.scalars,
            &[BEYOND],
        ];
        inputs_of(&structure, &arrays.concat(), signal, step).map_err(|violation| Error::Model {
            name: "learned-plays".to_owned(),
            message: violation.to_string(),
        })
    }

    /// What the network sees at each row, and what the plays leave over half the position's range, without its mean.
    fn seen(
        &self,
        lessons: &[TrainingRecord],
        step: f64,
        every: usize,
    ) -> Result<(Vec<[f64; INPUTS]>, Vec<f64>), Error> {
        let half = self.scalars[7];
        let (mut inputs, mut left) = (Vec::new(), Vec::new());
        for lesson in lessons {
            let seen = self.simulated(&[], &lesson.signal, step)?;
            let from = left.len();
            for (k, measured) in lesson.rows(every) {
                let (x, y) = seen[k];
                inputs.push(x);
                left.push((measured - y) / half);
            }
            without_means(&mut left[from..]);
        }
        Ok((inputs, left))
    }

    /// The network over these plays, unit after unit.
    fn network(
        &self,
        lessons: &[TrainingRecord],
        step: f64,
        every: usize,
        observer: &mut dyn Observer,
    ) -> Result<Vec<f64>, Error> {
        let (inputs, left) = self.seen(lessons, step, every)?;
        let mut network = Vec::with_capacity(STARTS * UNITS * EACH);
        for start in 0..STARTS {
            observer.progress("network over plays", start, STARTS);
            if observer.stopped() {
                return Err(Error::Stopped);
            }
            network.extend(search(&inputs, &left, start).1);
        }
        let heights = network.iter_mut().skip(INPUTS + 1).step_by(EACH);
        heights.for_each(|height| *height /= STARTS as f64);
        Ok(network)
    }

    /// Root mean square error on these rows, over half the range.
    fn error(&self, network: &[f64], lessons: &[TrainingRecord], step: f64) -> Result<f64, Error> {
        let (mut sum, mut count) = (0.0, 0);
        for lesson in lessons {
            let seen = self.simulated(network, &lesson.signal, step)?;
            let mut error: Vec<f64> = lesson.rows(1).map(|(k, y)| seen[k].1 - y).collect();
            without_means(&mut error);
            sum += error.iter().map(|e| e * e).sum::<f64>();
            count += error.len();
        }
        Ok((sum / count.max(1) as f64).sqrt() / self.scalars[7])
    }

    /// The component with the network that was learned from these records, and how.
    ///
    /// Plays and network are fitted together too, with `bounds` of bend, quadratic, cubic and share, and with heights the cheaper
    /// the longer that helps on the last third of the rows. That is kept where it errs [`SIGNIFICANT_FALL`] less there:
    /// free weights of the plays follow one size of loops and fail on others.
    ///
    /// # Errors
    /// [`Error::Model`] where the component refuses the plays; [`Error::Stopped`].
    pub(crate) fn learn(
        &self,
        lessons: &[TrainingRecord],
        step: f64,
        bounds: &[(f64, f64)],
        observer: &mut dyn Observer,
    ) -> Result<(ComponentBlueprint, String), Error> {
        let rows: usize = lessons.iter().map(|lesson| lesson.position.len()).sum();
        let every = rows.div_ceil(ROWS).max(1);
        let joint = |lessons: &[TrainingRecord],
                     price: f64,
                     network: &[f64],
                     observer: &mut dyn Observer| {
            Joint { plays: self, lessons, step, bounds, price, every }.fit(network, observer)
        };
        let (begun, rest): (Vec<TrainingRecord>, Vec<TrainingRecord>) =
            lessons.iter().map(TrainingRecord::parted).unzip();
        let network = self.network(&begun, step, every, observer)?;
        let apart = self.error(&network, &rest, step)?;
        let mut best = (f64::INFINITY, 0.0);
        for price in PRICES {
            let (plays, network) = joint(&begun, price, &network, observer)?;
            let error = plays.error(&network, &rest, step)?;
            if error >= best.0 {
                break;
            }
            best = (error, price);
        }
        let (together, price) = best;
        let fall = 1.0 - together / apart;
        let network = self.network(lessons, step, every, observer)?;
        let training_note =
            format!("{:+.1} % error on the last third of the rows fitted", -100.0 * fall);
        if fall >= SIGNIFICANT_FALL {
            let (plays, network) = joint(lessons, price, &network, observer)?;
            return Ok((
                plays.component(&network),
                format!("plays fitted anew with it: {training_note}"),
            ));
        }
        let needed = 100.0 * SIGNIFICANT_FALL;
        let training_note = format!(
            "plays not fitted anew with it: {training_note} ({needed:.0} % less is needed)"
        );
        Ok((self.component(&network), training_note))
    }

    fn component(&self, network: &[f64]) -> ComponentBlueprint {
        let of = |k: usize| network.chunks_exact(EACH).map(move |unit| unit[k]);
        let weight: Vec<f64> =
            network.chunks_exact(EACH).flat_map(|unit| unit[..INPUTS].to_vec()).collect();
        let mut component = ComponentBlueprint::new("learned-plays")
            .value("r", &self.r[..])
            .value("w", &self.w[..])
            .value("share", &self.share[..])
            .value("time_constant", &self.time_constant[..])
            .value("height", of(INPUTS + 1).collect::<Vec<f64>>())
            .value("bias", of(INPUTS).collect::<Vec<f64>>())
            .value("weight", weight)
            .value("activation", 1.0);
        for (name, value) in SCALARS.into_iter().zip(self.scalars) {
            component = component.value(name, value);
        }
        component
    }

    /// Numbers of all that was fitted and learned: r is a grid of its count, centre and half ranges are the records'.
    pub(crate) fn numbers(&self) -> usize {
        self.w.len() + self.share.len() + 4 + STARTS * UNITS * EACH
    }
}

/// The first network of this number: weights and biases, heights of 0.
fn first(start: usize) -> Vec<f64> {
    let number = |k: usize| normal(SEED, start as u32, k as u64);
    let scale = |k: usize| match k % EACH {
        k if k < INPUTS => 1.0,
        INPUTS => 0.5,
        _ => 0.0,
    };
    (0..UNITS * EACH).map(|k| scale(k) * number(k)).collect()
}

/// Levenberg–Marquardt from the network of this number: the least sum, and the network.
fn search(inputs: &[[f64; INPUTS]], left: &[f64], start: usize) -> (f64, Vec<f64>) {
    let begin = first(start);
    let mut at = begin.clone();
    let mut cost = sum(inputs, left, &at, &begin);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let (normal, gradient) = equations(inputs, left, &at, &begin);
        let before = cost;
        while damping < 1e12 {
            let step = damped_step(normal.clone(), &gradient, damping);
            let next: Option<Vec<f64>> =
                step.map(|step| at.iter().zip(step.iter()).map(|(a, d)| a + d).collect());
            let tried = next.map(|next| (sum(inputs, left, &next, &begin), next));
            if let Some((less, next)) = tried.filter(|(tried, _)| *tried < cost) {
                (cost, at) = (less, next);
                damping = (0.1 * damping).max(1e-12);
                break;
            }
            damping *= 10.0;
        }
        if before - cost <= FALL * before {
            break;
        }
    }
    (cost, at)
}

/// What each unit sees.
fn insides(x: &[f64; INPUTS], network: &[f64]) -> [f64; UNITS] {
    let mut all = [0.0; UNITS];
    for (inside, numbers) in all.iter_mut().zip(network.chunks_exact(EACH)) {
        *inside = x.iter().zip(numbers).fold(numbers[INPUTS], |sum, (x, a)| sum + a * x);
    }
    all
}

/// Costs of each number: what it is compared with, and the square of its price.
fn prices<'a>(begin: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
    begin.iter().enumerate().map(|(k, first)| match k % EACH == INPUTS + 1 {
        true => (0.0, HEIGHT * HEIGHT),
        false => (*first, WEIGHT * WEIGHT),
    })
}

fn sum(inputs: &[[f64; INPUTS]], left: &[f64], network: &[f64], begin: &[f64]) -> f64 {
    let heights = network.iter().skip(INPUTS + 1).step_by(EACH);
    let add = |x: &[f64; INPUTS]| {
        let insides = insides(x, network);
        insides.iter().zip(heights.clone()).map(|(a, c)| unit(*a) * c).sum::<f64>()
    };
    let count = left.len().max(1) as f64;
    let errors = || inputs.iter().zip(left).map(|(x, left)| add(x) - left);
    let errors: Vec<f64> = errors().collect();
    let mean = errors.iter().sum::<f64>() / count;
    let price: f64 = network
        .iter()
        .zip(prices(begin))
        .map(|(p, (from, price))| price * (p - from).powi(2))
        .sum();
    errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() + count * price
}

/// JᵀJ and Jᵀe of that sum.
fn equations(
    inputs: &[[f64; INPUTS]],
    left: &[f64],
    network: &[f64],
    begin: &[f64],
) -> (DMatrix<f64>, DVector<f64>) {
    let (size, count) = (UNITS * EACH, left.len().max(1) as f64);
    let mut jacobian = DMatrix::zeros(left.len(), size);
    let mut error = DVector::zeros(left.len());
    for (row, (x, left)) in inputs.iter().zip(left).enumerate() {
        let mut added = 0.0;
        for (n, (inside, numbers)) in
            insides(x, network).into_iter().zip(network.chunks_exact(EACH)).enumerate()
        {
            let (height, active) = (numbers[INPUTS + 1], unit(inside));
            added += height * active;
            let slope = height * unit_slope(inside);
            for (k, x) in x.iter().enumerate() {
                jacobian[(row, EACH * n + k)] = slope * x;
            }
            jacobian[(row, EACH * n + INPUTS)] = slope;
            jacobian[(row, EACH * n + INPUTS + 1)] = active;
        }
        error[row] = added - left;
    }
    for mut column in jacobian.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
    let mean = error.mean();
    error.add_scalar_mut(-mean);
    let mut normal = jacobian.tr_mul(&jacobian);
    let mut gradient = jacobian.tr_mul(&error);
    for (k, (p, (from, price))) in network.iter().zip(prices(begin)).enumerate() {
        normal[(k, k)] += count * price;
        gradient[k] += count * price * (p - from);
    }
    (normal, gradient)
}
