//! How often the diagnosis is right on machines of this folder: a table, on demand.
//!
//! `cargo test --release -p piezoloop-diagnose --test accuracy -- --ignored --nocapture`
#![allow(clippy::print_stdout)]

mod common;

use common::diagnose_machine;
use common::machine::Machine;
use common::truth::Effect;
use piezoloop_diagnose::{Gap, Verdict};

fn line(label: &str, gap: &Gap, truth: &str) -> bool {
    let named: Vec<String> = gap
        .effects
        .iter()
        .map(|e| format!("{} {:.2} {:?} expl {:.2}", e.effect, e.probability, e.set, e.explained))
        .collect();
    let right = if truth.is_empty() {
        gap.effects.is_empty()
    } else {
        gap.effects.first().is_some_and(|e| e.effect == truth)
    };
    let top: Vec<String> = gap
        .candidates
        .iter()
        .take(4)
        .map(|c| {
            format!(
                "{} tr {:.2} ho {:.2}",
                c.effect,
                c.training.unwrap_or(0.0),
                c.holdout.unwrap_or(0.0)
            )
        })
        .collect();
    println!(
        "{} {label}: {:?} {} | left {:.2} before {:.2} sims {} | {}",
        if right { "ok   " } else { "WRONG" },
        gap.verdict,
        named.join("; "),
        gap.leftover.over_noise,
        (gap.shrink.rms_before / gap.shrink.noise_floor).powi(2),
        gap.provenance.simulations,
        top.join(", ")
    );
    right
}

#[test]
#[ignore = "a measurement of minutes, not a check"]
fn single_effects() {
    let only = std::env::var("ONLY").unwrap_or_default();
    let sizes: Vec<f64> = std::env::var("SIZES")
        .unwrap_or_else(|_| "6".into())
        .split(',')
        .map(|s| s.parse().unwrap())
        .collect();
    for size in sizes {
        let (mut right, mut all) = (0, 0);
        for (k, (effect, name)) in Effect::NAMED.into_iter().enumerate() {
            if !only.is_empty() && !only.split(',').any(|o| o == name) {
                continue;
            }
            let machine = Machine::new(100 + k as u64 + 1000 * size as u64, 1.0).with(effect, size);
            let t = std::time::Instant::now();
            let gap = diagnose_machine(&machine, machine.logs(), &[]);
            let label = format!("{name} {size} {:.1}s", t.elapsed().as_secs_f64());
            right += usize::from(line(&label, &gap, name));
            all += 1;
        }
        println!("size {size}: {right} of {all}");
    }
}

#[test]
#[ignore = "a measurement of minutes, not a check"]
fn no_effect_and_unknown() {
    let (mut right, mut all) = (0, 0);
    for seed in 0..10 {
        let machine = Machine::new(500 + seed, 1.0);
        let gap = diagnose_machine(&machine, machine.logs(), &[]);
        right += usize::from(line("nothing", &gap, ""));
        all += 1;
    }
    for effect in Effect::UNKNOWN {
        for size in [6.0, 20.0] {
            let machine = Machine::new(600 + effect as u64, 1.0).with(effect, size);
            let gap = diagnose_machine(&machine, machine.logs(), &[]);
            right += usize::from(line(&format!("{effect:?} {size}"), &gap, ""));
            assert!(gap.verdict != Verdict::Adequate);
            all += 1;
        }
    }
    println!("{right} of {all}");
}

#[test]
#[ignore = "a measurement of minutes, not a check"]
fn withheld() {
    let (mut right, mut all) = (0, 0);
    for (k, (effect, name)) in Effect::NAMED.into_iter().enumerate() {
        let machine = Machine::new(700 + k as u64, 1.0).with(effect, 10.0);
        let gap = diagnose_machine(&machine, machine.logs(), &[name]);
        right += usize::from(line(&format!("{name} withheld"), &gap, ""));
        all += 1;
    }
    println!("{right} of {all} abstain");
}

#[test]
#[ignore = "a measurement of minutes, not a check"]
fn pairs() {
    let (mut right, mut all) = (0, 0);
    let n = Effect::NAMED.len();
    for k in 0..20 {
        let (a, b) = (Effect::NAMED[(k * 5) % n], Effect::NAMED[(k * 11 + 3) % n]);
        if a.0 == b.0 {
            continue;
        }
        let machine = Machine::new(800 + k as u64, 1.0).with(a.0, 10.0).with(b.0, 10.0);
        let gap = diagnose_machine(&machine, machine.logs(), &[]);
        line(&format!("{} + {}", a.1, b.1), &gap, a.1);
        let names: Vec<&str> = gap.effects.iter().map(|e| e.effect.as_str()).collect();
        right += usize::from(names.len() == 2 && names.contains(&a.1) && names.contains(&b.1));
        all += 1;
    }
    println!("both and nothing else: {right} of {all}");
}

/// 25 s at 10 kHz on a native model with ten plays, a mode and two lags.
#[test]
#[ignore = "a measurement of time, not a check"]
fn speed() {
    use data::{Blueprint, Log};
    use piezoloop_diagnose::{Model, Noise, Request, Silent};
    let text = |extra: &str| {
        format!(
            "piezoloop = 1\nkind = \"plant\"\nname = \"evc\"\nstep = 1e-4\n[[axis]]\nname = \"Y\"\n\
             command = {{ name = \"u\", unit = \"V\" }}\nposition = {{ name = \"y\", unit = \"um\" }}\n{extra}\
             [[axis.component]]\ntype = \"amplifier-lag\"\nbandwidth = 3000\ntolerance = {{ bandwidth = 0.1 }}\n\
             [[axis.component]]\ntype = \"prandtl-ishlinskii\"\nr = [0, 6, 12, 18, 24, 30, 36, 42, 48, 54]\n\
             w = [0.01354, 0.0279, 0.001, 0.004014, 0.007765, 0, 0, 0, 0, 0]\ntolerance = {{ w = 0.05 }}\n\
             [[axis.component]]\ntype = \"mode\"\nfrequency = 482.6\ndamping = 0.02\n\
             tolerance = {{ frequency = 0.01, damping = 0.15 }}\n\
             [[axis.component]]\ntype = \"sensor-lag\"\nbandwidth = 4000\ntolerance = {{ bandwidth = 0.1 }}\n"
        )
    };
    let build = |extra: &str| {
        Blueprint::parse(&text(extra), "evc").unwrap().check(components::COMPONENTS).unwrap()
    };
    let truth = build(
        "[[axis.component]]\ntype = \"kelvin-voigt-creep\"\nshare = [0.01, 0.02]\ntime_constant = [0.2, 2]\n",
    );
    let mut system = truth.build();
    let n = 250_000;
    let u: Vec<f64> = (0..n)
        .map(|k| {
            let t = k as f64 * 1e-4;
            let slow = ((t * 0.7).floor() * 37.0) % 60.0;
            20.0 + slow + 20.0 * (t * t * 60.0).sin()
        })
        .collect();
    let mut noise = common::machine::Normal::new(1);
    system.set(0, u[0]).unwrap();
    system.initialise(0.0).unwrap();
    let mut y = Vec::with_capacity(n);
    for k in 0..n {
        y.push(system.get(1).unwrap() + 0.005 * noise.draw());
        system.set(0, u[k]).unwrap();
        system.advance((k + 1) as f64 * 1e-4).unwrap();
    }
    let mut log = Log::new("long.csv", (0..n).map(|k| k as f64 * 1e-4).collect()).unwrap();
    log.add_column("u", Some("V"), u).unwrap();
    log.add_column("y", Some("um"), y).unwrap();
    let mut request = Request::new(Model::Blueprint(Box::new(build(""))), vec![log]);
    request.noise = Noise::Given(vec![(None, 0.005)]);
    request.threads = 2;
    let begin = std::time::Instant::now();
    let gap = piezoloop_diagnose::diagnose(&request, &mut Silent).unwrap();
    line(&format!("25 s at 10 kHz: {:.1} s", begin.elapsed().as_secs_f64()), &gap, "creep");
}
