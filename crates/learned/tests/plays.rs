//! Plays between two curves with a network over their states: equation, bounds, inverse, what is refused.

use components::hysteresis::play::{Drive, Threshold, play};
use learned::COMPONENTS;
use learned::plays::{INPUTS, LearnedPlays, unit, unit_slope};
use model::{Component, Sizes, Tick, Violation};

fn inverse_plays() -> &'static dyn Component {
    let mut all = COMPONENTS.iter().copied();
    all.find(|c| c.declaration().kind == "inverse-learned-plays").expect("registered")
}

const PERIOD: f64 = 1e-3;
const STRUCTURE_OF_TWO: [f64; 5] = [5.0, 2.0, 2.0, 18.0, 1.0];

/// Five plays, two creeps, two units over a range of 0 to 100 V and 0 to 20 um.
fn parameters() -> Vec<f64> {
    let plays = [0.0, 8.0, 16.0, 24.0, 40.0, 0.1, 0.03, 0.02, 0.02, 0.03];
    let creeps = [0.02, 0.01, 0.05, 1.0];
    let network = [0.03, -0.02, 0.1, -0.4];
    let weight: Vec<f64> = (0..2 * INPUTS).map(|k| 1.5 * (1.7 * k as f64).sin()).collect();
    let scalars = [0.5, 0.1, 50.0, 50.0, -0.05, 0.02, 10.0, 10.0, 1.5];
    [&plays[..], &creeps, &network, &weight, &scalars].concat()
}

struct Instance {
    component: &'static dyn Component,
    coefficients: Vec<f64>,
    state: Vec<f64>,
    index: u64,
}

impl Instance {
    fn new(component: &'static dyn Component, parameters: &[f64]) -> Result<Self, Violation> {
        Self::with(component, &STRUCTURE_OF_TWO, parameters)
    }

    fn with(
        component: &'static dyn Component,
        structure: &[f64],
        parameters: &[f64],
    ) -> Result<Self, Violation> {
        let Sizes { coefficients, states } = component.sizes(structure, PERIOD);
        let mut coefficients = vec![0.0; coefficients];
        component.prepare(structure, parameters, PERIOD, &mut coefficients)?;
        Ok(Self { component, coefficients, state: vec![0.0; states], index: 0 })
    }

    fn rest(&mut self, u: f64) -> f64 {
        let mut y = [0.0];
        self.component.rest(&self.coefficients, &[u], &mut self.state, &mut y);
        y[0]
    }

    fn step(&mut self, u: f64) -> f64 {
        self.index += 1;
        let mut y = [0.0];
        let tick = Tick { index: self.index, time: PERIOD * self.index as f64, period: PERIOD };
        self.component.step(&self.coefficients, &mut self.state, tick, &[u], &mut y);
        y[0]
    }
}

/// Commands all over the range, some beyond it, each the more often the nearer to the one before.
fn commands(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(|k| {
        let t = k as f64;
        50.0 + 60.0 * (0.05 * t).sin() * (0.0131 * t).cos() + 8.0 * (0.71 * t).sin()
    })
}

#[test]
fn is_the_chain_of_its_parts_and_a_network_over_their_states() {
    is_the_chain(1.0, |a| {
        let c = (8.0 * a / 15.0).clamp(-1.0, 1.0);
        c * (15.0 - 10.0 * c.powi(2) + 3.0 * c.powi(4)) / 8.0
    });
}

/// Blueprints that do not name the activation.
#[test]
fn tanh_is_the_activation_where_none_is_given() {
    let declared = LearnedPlays.declaration().structure;
    let activation = declared.iter().find(|setting| setting.name == "activation").unwrap();
    is_the_chain(activation.start.unwrap(), f64::tanh);
}

fn is_the_chain(activation: f64, sigma: impl Fn(f64) -> f64) {
    let p = parameters();
    let structure = [5.0, 2.0, 2.0, 18.0, activation];
    let mut model = Instance::with(&LearnedPlays, &structure, &p).unwrap();
    let (r, w) = (&p[..5], &p[5..10]);
    let mut plays = [0.0_f64; 5];
    let mut creeps: Option<[f64; 2]> = None;
    for (k, u) in commands(3000).enumerate() {
        let y = if k == 0 { model.rest(u) } else { model.step(u) };
        let place = ((u - 50.0) / 50.0).clamp(-1.5, 1.5);
        let bent = 50.0 + 50.0 * place + 50.0 * 0.1 * place * place;
        plays.iter_mut().zip(r).for_each(|(p, r)| *p = play(Drive(bent), Threshold(*r), *p));
        let h = 0.5 + w.iter().zip(&plays).map(|(w, p)| w * p).sum::<f64>();
        let moved = |z: [f64; 2]| {
            let part = |time: f64| 1.0 - (-PERIOD / time).exp();
            [z[0] + part(0.05) * (h - z[0]), z[1] + part(1.0) * (h - z[1])]
        };
        let z = creeps.map_or([h; 2], moved);
        creeps = Some(z);
        let v = h + 0.02 * z[0] + 0.01 * z[1];
        let eta = (v - 10.0) / 10.0;
        // Five plays in four groups: two, one, one, one.
        let stop = |i: usize| (bent - plays[i]) * 4.0 / (5.0 * 50.0);
        let x = [
            place,
            eta,
            stop(0) + stop(1),
            stop(2),
            stop(3),
            stop(4),
            (h - z[0]) / 10.0,
            (h - z[1]) / 10.0,
            0.0,
        ];
        let unit = |n: usize| {
            let weights = &p[18 + INPUTS * n..18 + INPUTS * (n + 1)];
            let inside = weights.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
            p[14 + n] * sigma(p[16 + n] + inside)
        };
        let expected = v + 10.0 * ((-0.05 + 0.02 * eta) * eta * eta + unit(0) + unit(1));
        assert!((y - expected).abs() < 1e-11, "{k}: {y} {expected}");
    }
}

#[test]
fn whatever_the_command_the_position_is_bounded_and_comes_back() {
    let mut model = Instance::new(&LearnedPlays, &parameters()).unwrap();
    model.rest(0.0);
    let mut greatest = 0.0_f64;
    for k in 0..4000_u32 {
        let u = (f64::from(k) * 0.37).sin() * 10_f64.powi(k as i32 % 308);
        greatest = greatest.max(model.step(u).abs());
    }
    for u in [f64::MAX, f64::MIN, f64::INFINITY, f64::NEG_INFINITY] {
        greatest = greatest.max(model.step(u).abs());
    }
    assert!(greatest < 50.0, "{greatest}");
}

#[test]
fn the_network_adds_no_more_than_its_heights() {
    let mut p = parameters();
    p[18..18 + 2 * INPUTS].iter_mut().for_each(|weight| *weight *= 1e6);
    let mut wild = Instance::new(&LearnedPlays, &p).unwrap();
    p[14..16].fill(0.0);
    let mut plain = Instance::new(&LearnedPlays, &p).unwrap();
    wild.rest(0.0);
    plain.rest(0.0);
    let away = commands(2000).map(|u| (wild.step(u) - plain.step(u)).abs()).fold(0.0, f64::max);
    assert!(away > 0.1 && away <= 10.0 * (0.03 + 0.02) + 1e-12, "{away}");
}

#[test]
fn the_inverse_before_the_machine_gives_the_wanted_position() {
    let p = parameters();
    let limited = [&p[..], &[0.0, 100.0]].concat();
    let mut inverse = Instance::new(inverse_plays(), &limited).unwrap();
    let mut machine = Instance::new(&LearnedPlays, &p).unwrap();
    let expected = |k: usize| 9.0 + 5.0 * (0.02 * k as f64).sin() * (0.0031 * k as f64).cos();
    let first = machine.rest(inverse.rest(expected(0)));
    assert!((first - expected(0)).abs() < 1e-8, "{first}");
    for k in 1..3000 {
        let found = machine.step(inverse.step(expected(k)));
        assert!((found - expected(k)).abs() < 1e-8, "{k}: {found} {}", expected(k));
    }
    // What no command reaches gives the nearest limit.
    assert_eq!([inverse.step(1e6), inverse.step(-1e6)], [100.0, 0.0]);
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let refused = |change: &dyn Fn(&mut Vec<f64>)| {
        let mut p = parameters();
        change(&mut p);
        Instance::new(&LearnedPlays, &p).err().map(|violation| violation.quantity)
    };
    assert_eq!(refused(&|_| {}), None);
    assert_eq!(refused(&|p| p[2] = p[1]), Some("r"));
    assert_eq!(refused(&|p| p[5..10].fill(0.0)), Some("w"));
    assert_eq!(refused(&|p| p[37] = 0.4), Some("bend"));
    assert_eq!(refused(&|p| p[39] = 0.0), Some("half_range"));
    assert_eq!(refused(&|p| p[43] = 0.0), Some("position_half_range"));
    let inverse = |change: &dyn Fn(&mut Vec<f64>)| {
        let mut p = [&parameters()[..], &[0.0, 100.0]].concat();
        change(&mut p);
        Instance::new(inverse_plays(), &p).err().map(|violation| violation.quantity)
    };
    assert_eq!(inverse(&|_| {}), None);
    assert_eq!(inverse(&|p| p[0] = 1.0), Some("r"));
    assert_eq!(inverse(&|p| p[5] = 0.0), Some("w"));
    assert_eq!(inverse(&|p| p[46] = 126.0), Some("command_max"));
    let mut coefficients = vec![0.0; 100];
    let weights = LearnedPlays.prepare(&[5.0, 2.0, 2.0, 17.0, 1.0], &[], PERIOD, &mut coefficients);
    assert_eq!(weights.err().map(|violation| violation.quantity), Some("weight"));
}

#[test]
fn the_slope_of_a_unit_is_its_derivative_and_its_ends_are_1() {
    for k in -400..=400 {
        let a = 0.01 * f64::from(k);
        let difference = (unit(a + 1e-5) - unit(a - 1e-5)) / 2e-5;
        assert!((unit_slope(a) - difference).abs() < 1e-9, "{a}: {} {difference}", unit_slope(a));
    }
    assert_eq!([unit(1.875), unit(-1e300), unit(f64::INFINITY)], [1.0, -1.0, 1.0]);
}

/// Any number of plays, units and creeps against plays one by one.
#[test]
fn groups_that_are_filled_up_to_fours_add_nothing() {
    for (plays, units, creeps) in
        [(1, 0, 0), (2, 1, 3), (4, 4, 1), (7, 3, 0), (16, 5, 2), (33, 9, 3)]
    {
        let r: Vec<f64> = (0..plays).map(|i| 40.0 * i as f64 / plays as f64).collect();
        let w: Vec<f64> = (0..plays).map(|i| 0.2 / (1.0 + i as f64)).collect();
        let network: Vec<f64> = (0..(INPUTS + 2) * units).map(|k| (1.7 * k as f64).sin()).collect();
        let creep = [vec![0.01; creeps], vec![0.05; creeps]].concat();
        let scalars = [0.5, 0.1, 50.0, 50.0, -0.05, 0.02, 10.0, 10.0, 1.5];
        let p = [&r[..], &w, &creep, &network, &scalars].concat();
        let structure = [plays, creeps, units, INPUTS * units].map(|count| count as f64);
        let structure = [&structure[..], &[1.0]].concat();
        let mut model = Instance::with(&LearnedPlays, &structure, &p).unwrap();
        let (mut states, mut z) = (vec![0.0_f64; plays], vec![0.0; creeps]);
        for (k, u) in commands(500).enumerate() {
            let y = if k == 0 { model.rest(u) } else { model.step(u) };
            let place = ((u - 50.0) / 50.0).clamp(-1.5, 1.5);
            let bent = 50.0 + 50.0 * (place + 0.1 * place * place);
            states.iter_mut().zip(&r).for_each(|(p, r)| *p = play(Drive(bent), Threshold(*r), *p));
            let h = 0.5 + w.iter().zip(&states).map(|(w, p)| w * p).sum::<f64>();
            let part = if k == 0 { 1.0 } else { 1.0 - (-PERIOD / 0.05).exp() };
            z.iter_mut().for_each(|z| *z += part * (h - *z));
            let v = h + 0.01 * z.iter().sum::<f64>();
            let mut x = [0.0; INPUTS];
            (x[0], x[1]) = (place, (v - 10.0) / 10.0);
            for (i, state) in states.iter().enumerate() {
                let group = (0..4).find(|g| i < ((g + 1) * plays).div_ceil(4)).unwrap();
                x[2 + group] += (bent - state) * 4.0 / (50.0 * plays as f64);
            }
            z.iter().enumerate().for_each(|(j, z)| x[6 + j] = (h - z) / 10.0);
            let added = (0..units).map(|n| {
                let weights = &network[2 * units + INPUTS * n..][..INPUTS];
                let inside = weights.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
                network[n] * unit(network[units + n] + inside)
            });
            let expected = v + 10.0 * ((-0.05 + 0.02 * x[1]) * x[1] * x[1] + added.sum::<f64>());
            assert!((y - expected).abs() < 1e-11, "{plays} plays, {k}: {y} {expected}");
        }
    }
}
