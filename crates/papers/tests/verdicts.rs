//! What the pages say of the papers' tables holds on any machine, and what they rest on stays.

use papers::machines;
use papers::matching::{Figure, TABLES};
use papers::reproduce::{self, Aim, Effort, Reproduction, Row, Verdict};
use sha2::{Digest, Sha256};

fn models(paper: &str) -> Reproduction {
    reproduce::run(paper, Effort::Full, &|_| ())
        .unwrap_or_else(|error| panic!("{paper}: {error:#}"))
}

fn refuted(answer: &Reproduction) -> Vec<&str> {
    answer.orders.iter().filter(|order| !order.holds).map(|order| order.what.as_str()).collect()
}

/// They were fixed before any model ran on them, like the machines' blueprints.
#[test]
fn waves_that_stand_in_are_frozen() {
    let mut hash = Sha256::new();
    for letter in ['c', 'f', 'g'] {
        let (name, given) = machines::p1(letter);
        let kind = signals::lookup(&name).unwrap_or_else(|error| panic!("{error}"));
        let signal = kind.generate(given).unwrap_or_else(|error| panic!("{name}: {error}"));
        let values = &signal.channels[0].values;
        assert_eq!(values.len(), 500);
        for value in values {
            hash.update(value.to_le_bytes());
        }
    }
    let hash: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hash, "bc3c0484db76c9e82f67d19e945c94de65dd7305157769602fe3dba67b4f77e0");
}

/// Ranges, strokes, widths and resonances are the papers'; what baselines leave is found out.
#[test]
fn machines_are_what_the_papers_say_of_their_rigs() {
    let tables = TABLES.map(|table| table().unwrap_or_else(|error| panic!("{error:#}")));
    for Figure { rig, what, paper, ours, within, of_rig, .. } in tables.iter().flatten() {
        assert!(ours.is_finite() && *ours > 0.0, "{rig}: {what} {ours}");
        assert!(*within || !of_rig, "{rig}: {what} {paper} {ours}");
    }
    for table in &tables {
        assert!(table.iter().any(|figure| figure.of_rig), "{}", table[0].rig);
    }
}

#[test]
fn model_iii_without_an_inverse_is_the_paper_s_on_the_tests() {
    let answer = models("p2");
    for name in ["test 1", "test 2"] {
        let third = |row: &&Row| row.what == format!("model III (u, y, h), {name}");
        let row = answer.rows.iter().find(third).expect("a row");
        assert_eq!(row.verdict, Verdict::Reached, "{name}: {}", row.own);
        assert!(row.own < 1.0 && row.ours.is_some_and(|ours| ours < 1.0), "{name}");
    }
    // Told the command alone a model is better than told the position alone, and no model of leave-one-out follows the
    // training signal. There models II and III leave more than 40 % of the range: by how much is rounding, as their γ of 5e8
    // is the largest that can be solved, so that their order says nothing.
    let diverged = |name: &str| {
        let what = format!("{name}, training");
        answer.rows.iter().any(|row| row.what == what && row.own > 40.0)
    };
    assert!(diverged("model II (y, h)") && diverged("model III (u, y, h)"));
    let by_rounding = "training: model III better than model II";
    let all: Vec<_> = refuted(&answer).into_iter().filter(|order| *order != by_rounding).collect();
    let expected = [
        "training: model III better than Bouc-Wen",
        "training: model II better than model I",
        "test 1: model II better than model I",
        "test 2: model II better than model I",
    ];
    assert_eq!(all, expected);
}

#[test]
fn the_order_of_dynamic_models_is_the_paper_s_but_for_generalised_plays_on_y_at_10_hz() {
    let answer = models("p4");
    assert_eq!(refuted(&answer), ["Y, 10 Hz: dynamic better than generalised plays"]);
    let judged: Vec<&Row> =
        answer.rows.iter().filter(|row| matches!(row.aim, Aim::Ratio { .. })).collect();
    assert_eq!(judged.len(), 4);
    for row in judged {
        let fast = row.what.contains("100 Hz");
        assert_eq!(row.verdict == Verdict::Reached, fast, "{}", row.what);
        // The modes of the finite elements raise Z at 100 Hz more than in the paper.
        let near = row.own <= 1.25 * row.paper;
        assert_eq!(near, row.what != "Z, 100 Hz, dynamic Prandtl-Ishlinskii", "{}", row.what);
        assert!(row.ours.is_some_and(|ours| ours < row.own), "{}", row.what);
    }
}
