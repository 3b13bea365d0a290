//! Measured data: a piezo stack that a straight line cannot describe.
#![allow(clippy::print_stdout)]

use std::path::Path;

use components::COMPONENTS;
use data::{Blueprint, Log, NameMap, ReadOptions};
use diagnose::{Model, Request, Silent, Verdict, diagnose};

const LINE: &str = r#"
piezoloop = 1
kind = "plant"
name = "line"
step = 0.005
[[axis]]
name = "X"
command = { name = "u", unit = "V", min = 0, max = 3.6 }
position = { name = "y", unit = "um" }
[[axis.component]]
type = "actuator-gain"
gain = 12.0
tolerance = { gain = 0.05 }
"#;

#[test]
fn a_straight_line_through_a_piezo_stack_lacks_hysteresis() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/pea_p885_1hz_inverse_ff/test_ff.csv");
    if !path.exists() {
        println!("{}: not there, the test is skipped", path.display());
        return;
    }
    let mut options = ReadOptions::default();
    for unit in ["u1=V", "u2=V", "u3=V", "y=um"] {
        options.add_unit(unit).unwrap();
    }
    let log = Log::read(&path, &options).unwrap();
    let model = Blueprint::parse(LINE, "line.toml").unwrap().check(COMPONENTS).unwrap();
    let mut request = Request::new(Model::Blueprint(Box::new(model)), vec![log]);
    request.names = NameMap::parse(&["u=u1", "y=y"]).unwrap();
    let gap = diagnose(&request, &mut Silent).unwrap();
    println!("{}", gap.sentence);
    for e in &gap.effects {
        println!("  {} {:.2} {:?} explains {:.3}", e.effect, e.probability, e.set, e.explained);
    }
    for c in gap.candidates.iter().take(6) {
        println!("  {} {:?} {:?} {:?}", c.effect, c.score, c.training, c.holdout);
    }
    assert_eq!(gap.verdict, Verdict::Effects, "{}", gap.sentence);
    assert!(gap.effects.iter().any(|e| e.effect == "hysteresis"), "{}", gap.sentence);
}
