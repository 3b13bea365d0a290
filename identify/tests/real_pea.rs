//! A measured piezo stack: 1 Hz sine, judged on its second half and on another record.

#![allow(clippy::print_stdout, reason = "figures and seeds are shown with --nocapture")]

mod common;

use piezoloop_identify::{Rows, Settings, Silent, compare, identify, simulate};

#[test]
fn measured_piezo_stack_is_met_within_the_target_on_data_it_never_saw() {
    let Some(folder) = common::data_folder("pea_p885_1hz_inverse_ff") else { return };
    let record = common::record(&folder.join("model_1hz_3v6.csv"), "u", "y");
    let settings = Settings { drop: 2.0, ..Settings::default() };
    let started = std::time::Instant::now();
    let found =
        identify(std::slice::from_ref(&record), &common::target("p885"), &settings, &mut Silent)
            .unwrap_or_else(|e| panic!("{e}"));
    let took = started.elapsed();
    let fit = &found.records[0];
    let line = &fit.baseline_held_out;
    println!(
        "linear baseline, held out: {:.3} % of {:.2} um, offset {:.3} um",
        100.0 * line.nrmse,
        line.range,
        line.offset
    );
    let (fitted, held_out) = (&fit.fitted, &fit.held_out);
    println!(
        "plant, fitted on rows {:?}: {:.3} %, offset {:.3} um",
        fitted.rows,
        100.0 * fitted.nrmse,
        fitted.offset
    );
    println!(
        "plant, held out rows {:?}: {:.3} %, offset {:.3} um",
        held_out.rows,
        100.0 * held_out.nrmse,
        held_out.offset
    );
    for candidate in &found.candidates {
        println!("  {candidate:?}");
    }
    for parameter in found.parameters.iter().take(6) {
        println!("  {parameter:?}");
    }

    let other = common::record(&folder.join("test_ff.csv"), "u1", "y");
    let simulation = simulate(&found.plant, &other).unwrap_or_else(|e| panic!("{e}"));
    // Data rows 5051 to 6050, counted from 1.
    let figures = compare(other.output(), &simulation, Rows { first: 5050, end: 6050 });
    println!(
        "plant on test_ff.csv, rows 5051-6050: {:.3} %, offset {:.3} um",
        100.0 * figures.nrmse,
        figures.offset
    );
    println!("identified in {took:.1?}");

    assert!(line.nrmse > 0.05, "the baseline is a straight line");
    assert!(held_out.nrmse <= 0.008, "{held_out:?}");
    assert!(figures.nrmse <= 0.008, "{figures:?}");
}
