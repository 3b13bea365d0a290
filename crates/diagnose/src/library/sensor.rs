//! Environment and sensor.

use components::effects;
use surround::Block;

use super::Setting;
use crate::formula::{Family, Formula, Free, Slot};
use crate::nuisance::Nuisance;
use crate::path_block::RecordBlock;
use crate::thresholds::search::Thresholds;

pub(super) fn add(s: &Setting<'_>, all: &mut Vec<Family>) {
    let mut family = Family::new(&effects::THERMAL_DRIFT, drift(s));
    // What follows the position slowly, in every record by the same rule, is no drift.
    family.nulls = vec![droop(s)];
    all.push(family);
    all.push(Family::new(&effects::SENSOR_BANDWIDTH, super::input::lags(s, Slot::Reading)));
    all.push(Family::new(&effects::SENSOR_NONLINEARITY, nonlinearity(s)));
    let rounded =
        super::input::converter(Slot::Reading, s.position, &s.reading_steps, s.reading_gaps);
    all.push(Family::new(&effects::SENSOR_QUANTISATION, rounded));
    all.push(Family::new(&effects::MAINS_HUM, hum(s)));
    all.push(Family::new(&effects::CROSSTALK, crosstalk(s)));
}

fn drift(s: &Setting<'_>) -> Vec<Formula> {
    let with = |name, nuisance| {
        let mut f = Formula::new(name).start(&[]);
        f.nuisance = Some(nuisance);
        f
    };
    let mut settling = with("settling", Nuisance::Settling { parameter: 0 });
    settling.parameters = vec![Free::log("time constant", "s", 0.02 * s.length, 5.0 * s.length)];
    settling.starts = vec![vec![0.1 * s.length], vec![0.5 * s.length]];
    let mut all = vec![
        with("straight line", Nuisance::Drift { order: 1 }),
        with("parabola", Nuisance::Drift { order: 2 }),
        settling,
        with("walk", Nuisance::Knots { count: 8 }),
    ];
    for (k, aux) in s.data.aux.iter().enumerate().filter(|(_, a)| !a.is_command) {
        let (scale, zero) = (aux.span.half / s.position.half, aux.zero());
        let weight = Free::linear("weight", "1", -2.0, 2.0).step(1e-3);
        let block = Block::Auxiliary { scale, zero };
        all.push(
            Formula::new("with an auxiliary signal")
                .block(Slot::AfterMechanics, block, vec![weight])
                .aux(k)
                .start(&[0.0]),
        );
    }
    all
}

fn droop(s: &Setting<'_>) -> Formula {
    let corner = Free::log("corner", "Hz", 1e-3 / s.length, 10.0 / s.length);
    let part = Free::linear("part drooped at the start", "1", -1.0, 2.0).step(0.02);
    let starts = [0.02, 0.2].into_iter().flat_map(|k| [0.0, 1.0].map(|p| vec![k / s.length, p]));
    Formula::new("reading that droops")
        .block(Slot::Reading, RecordBlock::Droop, vec![corner, part])
        .starts(starts)
}

fn nonlinearity(s: &Setting<'_>) -> Vec<Formula> {
    const NAMES: [&str; 4] = ["a2", "a3", "a4", "a5"];
    let polynomial = |name, order: usize| {
        let parameters = (0..order - 1).map(|k| Free::linear(NAMES[k], "1", -1.0, 1.0).step(1e-3));
        Formula::new(name)
            .block(Slot::Reading, Block::Polynomial(s.position), parameters.collect())
            .start(&vec![0.0; order - 1])
    };
    let sine = vec![
        Free::linear("size", "1", -0.5, 0.5).step(1e-3),
        Free::linear("cycles over the range", "1", 0.2, 8.0).step(0.01),
        Free::linear("phase", "rad", -4.0, 4.0).step(0.01),
    ];
    let sines = [0.5, 1.0, 1.5, 2.0, 3.0].into_iter();
    vec![
        polynomial("second and third power", 3),
        polynomial("powers two to five", 5),
        Formula::new("periodic over the range")
            .block(Slot::Reading, Block::Sine(s.position), sine)
            .starts(sines.flat_map(|c| [0.0, 1.5].map(|p| vec![0.005, c, p])))
            .screened(1),
    ]
}

fn hum(s: &Setting<'_>) -> Vec<Formula> {
    let nyquist = 0.5 / s.sample;
    let formula = |name, mains: f64, harmonics: usize| {
        let width = (Thresholds::MAINS_OFF * mains)
            .max(Thresholds::MAINS_OFF_SHORT / s.length)
            .min(Thresholds::MAINS_OFF_MOST * mains);
        let frequency =
            Free::linear("frequency", "Hz", mains - width, mains + width).step(1e-3 / s.length);
        let mut f = Formula::new(name).start(&[mains]).screened(0);
        f.parameters = vec![frequency];
        f.nuisance = Some(Nuisance::Lines { parameter: 0, harmonics });
        f
    };
    let all = [
        ("50 Hz", 50.0, 1),
        ("50 Hz and harmonics", 50.0, 3),
        ("60 Hz", 60.0, 1),
        ("60 Hz and harmonics", 60.0, 3),
    ];
    all.into_iter()
        .filter(|(_, mains, harmonics)| mains * *harmonics as f64 <= nyquist)
        .map(|(name, mains, harmonics)| formula(name, mains, harmonics))
        .collect()
}

fn crosstalk(s: &Setting<'_>) -> Vec<Formula> {
    let weight = |name| Free::linear(name, "1", -2.0, 2.0).step(1e-3);
    let scale = s.command.half / s.position.half;
    let time = s.command.half / s.slope_power.sqrt().max(f64::MIN_POSITIVE);
    let formula = |name| {
        let (block, parameters) =
            (Block::FeedThrough { scale, time }, vec![weight("value"), weight("rate")]);
        Formula::new(name).block(Slot::Reading, block, parameters).start(&[0.0, 0.0])
    };
    let mut all = vec![formula("value and rate of the command").of_command()];
    // An FMU's command is all that is known of what is in front of its actuator.
    if s.base.is_white && s.base.actuator > 0 {
        all.push(formula("value and rate of the actuator's voltage"));
    }
    all
}
