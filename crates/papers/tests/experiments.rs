//! What the control experiments are made of, on packed machines. They are packed by the tool that was built last (`cargo
//! test` at the root builds it before).

use std::path::Path;

use data::Blueprint;
use papers::reproduce::control::learning::{Learning, learn};
use papers::reproduce::control::single::{Notch, impulse, ringing};
use papers::{Bed, Tool};

fn open(rig: &str) -> anyhow::Result<Bed> {
    Bed::open(&Tool::find(None)?, Path::new(rig))
}

#[test]
fn the_ringing_of_the_bimorph_is_found_and_taken_out() -> anyhow::Result<()> {
    let mut bed = open("p2-truth")?;
    let (point, period) = ([5.0, 0.3], 4e-3);
    let found = ringing(&mut bed, point, period)?;
    // 404 Hz at 250 Hz: 2·250 − 404.
    assert!((found - 96.0).abs() < 1.5, "{found}");
    let notch = Some(Notch { frequency: found, damping: 0.1 });
    let with = impulse(&mut bed, point, period, 300, notch)?;
    let without = impulse(&mut bed, point, period, 300, None)?;
    // At least ten times less of it is left behind the notch.
    let late = |h: &[f64]| h[150..].iter().map(|h| h * h).sum::<f64>().sqrt();
    assert!(late(&with) < 0.1 * late(&without), "{} {}", late(&with), late(&without));
    Ok(())
}

#[test]
fn learning_ends_far_below_the_loop_s_own_error_and_never_above_it() -> anyhow::Result<()> {
    use data::{AxisBlueprint, ComponentBlueprint, SignalBlueprint};
    use model::Kind;
    let bed = open("p1-truth")?;
    let period = 2e-3;
    let mut axis = AxisBlueprint::new("x", "V", "um");
    axis.command = SignalBlueprint::of_unit("V").between(-2.0, 12.0);
    let law = ComponentBlueprint::new("pid").value("kp", 0.05).value("ki", 30.0);
    let law = law.value("kd", 0.0).value("output_min", -2.0).value("output_max", 12.0);
    let controller = Blueprint::new(Kind::Controller, "control", period).axis(axis.component(law));
    let turn: Vec<f64> = (0..100)
        .map(|k| 5.0 - 4.0 * (std::f64::consts::TAU * f64::from(k) / 100.0).cos())
        .collect();
    let lead: Vec<f64> = (0..100).map(|k| f64::from(k) / 100.0).collect();
    let learning = Learning {
        lead: &[lead],
        pass: &[turn],
        turns: 1,
        judged: 100,
        period,
        preview: 0,
        passes: 8,
        probe: 0.01,
        band: 60.0,
    };
    let learned = learn(&bed, &controller, &learning)?;
    let (first, last) = (learned.errors[0], learned.errors[learned.errors.len() - 1]);
    assert!(last < 0.05 * first, "{:?}", learned.errors);
    Ok(())
}
