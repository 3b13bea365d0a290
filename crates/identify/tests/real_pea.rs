//! A measured piezo stack: 1 Hz sine, judged on its second half and on another record.

#![allow(clippy::print_stdout, reason = "figures and seeds are shown with --nocapture")]

use crate::common;
use identify::{Figures, Methods, Rows, Settings, Silent, compare, identify, simulate};

/// The smooth model between two curves: what one large loop leaves open about smaller ones it fills
/// with a straight density of plays. The log starts with the machine's first move, from rest at 0 V.
#[test]
fn measured_piezo_stack_is_met_within_the_target_on_data_it_never_saw() {
    let Some(folder) = common::data_folder("pea_p885_1hz_inverse_ff") else { return };
    let record = common::record(&folder.join("model_1hz_3v6.csv"), "u", "y").rested_at(0.0);
    let methods = Methods::Named(vec!["curved-prandtl-ishlinskii".to_owned()]);
    let settings = Settings { drop: 2.0, methods, ..Settings::default() };
    let found =
        identify(std::slice::from_ref(&record), &common::target("p885"), &settings, &mut Silent)
            .unwrap_or_else(|e| panic!("{e}"));
    let fit = &found.records[0];
    let percent = |figures: &Figures| format!("{:.3} %", 100.0 * figures.nrmse);
    println!("linear baseline, held out: {}", percent(&fit.baseline_held_out));
    println!("plant: fitted {}, held out {}", percent(&fit.fitted), percent(&fit.held_out));
    for candidate in &found.candidates {
        println!("  {:?}: {:?}, {}", candidate.method, candidate.held_out_nrmse, candidate.reason);
    }
    for parameter in found.parameters.iter().filter(|p| !p.name.contains("w[")) {
        println!("  {parameter:?}");
    }

    let other = common::record(&folder.join("test_ff.csv"), "u1", "y");
    let simulation = simulate(&found.plant, &other).unwrap_or_else(|e| panic!("{e}"));
    // Data rows 5051 to 6050, counted from 1.
    let figures = compare(other.output(), &simulation, Rows { first: 5050, end: 6050 });
    println!("plant on test_ff.csv, rows 5051-6050: {}", percent(&figures));

    assert!(fit.baseline_held_out.nrmse > 0.05, "the baseline is a straight line");
    assert!(fit.held_out.nrmse <= 0.004, "{:?}", fit.held_out);
    assert!(figures.nrmse <= 0.0045, "{figures:?}");
}

/// Plays between two curves and a small network over them, trained on one large sine: the same and smaller loops.
#[test]
fn a_small_network_over_plays_follows_both_records_of_the_stack() {
    let Some(folder) = common::data_folder("pea_p885_1hz_inverse_ff") else { return };
    let record = common::record(&folder.join("model_1hz_3v6.csv"), "u", "y").rested_at(0.0);
    let methods = Methods::Named(vec!["learned-plays".to_owned()]);
    let settings = Settings { drop: 2.0, methods, ..Settings::default() };
    let found =
        identify(std::slice::from_ref(&record), &common::target("p885"), &settings, &mut Silent)
            .unwrap_or_else(|e| panic!("{e}"));
    let held_out = 100.0 * found.records[0].held_out.nrmse;
    let other = common::record(&folder.join("test_ff.csv"), "u1", "y");
    let simulation = simulate(&found.plant, &other).unwrap_or_else(|e| panic!("{e}"));
    let figures = compare(other.output(), &simulation, Rows { first: 5050, end: 6050 });
    let smaller = 100.0 * figures.nrmse;
    println!(
        "learned-plays: held out {held_out:.3} %, test_ff.csv, rows 5051-6050: {smaller:.3} %"
    );
    assert!(held_out <= 0.21 && smaller <= 0.45, "{held_out} {smaller}");
}
