//! A campaign of faults in virtual time: each ends in the state that is expected, within its
//! deadline in cycles, and with the machine at rest.
#![allow(clippy::print_stdout)]

use crate::common::{APPROACH, Law, PERIOD, PERIOD_NS, ROWS, WATCH};
use crate::common::{control_law, controller, cycle_with, emulator, limits, virtual_run};
use bench::campaign::{Campaign, Trial};
use bench::cycle::Orders;
use bench::emulate::{PlantError, Script};
use bench::safety::{AxisLimits, Reason, State};
use bench::virtual_run::VirtualRun;

const AXES: usize = 2;

/// What the tool does with a campaign, with a plant and a controller in Rust.
fn tried(campaign: &Campaign) -> Vec<Trial> {
    let bench = |script| {
        Ok::<_, PlantError>(virtual_run(AXES, controller(AXES, control_law(AXES)), script))
    };
    campaign.run(10, bench, |_, _| Ok(())).unwrap()
}

#[test]
fn every_fault_ends_as_expected_within_its_deadline() {
    let campaign = Campaign::parse(include_str!("campaign.toml"), "campaign.toml").unwrap();
    let trials = tried(&campaign);
    assert!(trials.len() >= 200, "{}", trials.len());
    println!("{} faults in virtual time, cycles of {} ms", trials.len(), PERIOD_NS / 1_000_000);
    let failed: Vec<&Trial> = trials.iter().filter(|trial| !trial.problems.is_empty()).collect();
    assert!(failed.is_empty(), "{} of {}:\n{failed:#?}", failed.len(), trials.len());
}

#[test]
fn an_end_that_is_not_the_expected_one_is_reported() {
    let text = |expect: &str| {
        format!(
            "[[case]]\nname = \"lost\"\nat = [300]\nexpect = {{ {expect} }}\n\
                 [[case.fault]]\nkind = \"loss\"\nprobability = 1\n"
        )
    };
    for (expect, word) in [
        ("state = \"fault\", reason = \"sample-lost\"", "expected fault"),
        ("state = \"safe\", reason = \"sample-late\"", "samples came too late"),
        ("state = \"safe\", reason = \"sample-lost\", within = 2", "at most 2"),
    ] {
        let trials = tried(&Campaign::parse(&text(expect), "c.toml").unwrap());
        assert_eq!(trials.len(), 1);
        assert!(trials[0].problems.join("; ").contains(word), "{trials:?}");
    }
}

#[test]
fn a_sensor_that_saturates_is_found_stuck_at_its_end() {
    // It begins where the sine of 200 cycles is near its middle, between the sensor's ends.
    let text = format!(
        "[[case]]\nname = \"saturation\"\nat = [165, 365, 665]\n\
         expect = {{ state = \"fault\", reason = \"sensor-stuck\", within = {} }}\n\
         [[case.fault]]\nkind = \"saturation\"\naxis = 1\nmin = 3.5\nmax = 6.5\n",
        200 + WATCH.stuck
    );
    for trial in tried(&Campaign::parse(&text, "c.toml").unwrap()) {
        assert!(trial.problems.is_empty(), "{trial:?}");
    }
}

#[test]
fn a_controller_that_fails_or_speaks_nonsense_is_stopped() {
    for (broken, reason) in [
        (f64::NAN, Reason::CommandNotFinite),
        (f64::INFINITY, Reason::CommandNotFinite),
        (0.0, Reason::ControllerFailed),
    ] {
        let mut good = control_law(AXES);
        let law: Law = Box::new(move |step, inputs, state, outputs| {
            let answer = good(step, inputs, state, outputs);
            if step >= 300 {
                outputs[1] = broken;
            }
            answer && (step < 300 || reason != Reason::ControllerFailed)
        });
        let mut bench = virtual_run(AXES, controller(AXES, law), Script::default());
        let start =
            |bench: &VirtualRun, _| Orders { start: bench.next() >= 10, ..Orders::default() };
        let ended = bench.run(2000, start).unwrap();
        assert_eq!((ended.memory.state, ended.memory.reason), (State::Fault, reason));
        assert!((300..=303).contains(&ended.entered), "{ended:?}");
        assert_eq!(bench.cycle.failure().is_some(), reason == Reason::ControllerFailed);
    }
}

#[test]
fn a_command_that_stays_at_its_limit_is_a_fault() {
    let law: Law = Box::new(|step, inputs, _, outputs| {
        outputs.copy_from_slice(&inputs[..AXES]);
        outputs.iter_mut().for_each(|u| *u = if step > 200 { 1e9 } else { 10.0 * *u });
        true
    });
    let free = AxisLimits { tracking_error: f64::INFINITY, ..limits() };
    let cycle = cycle_with(AXES, controller(AXES, law), free);
    let mut bench = VirtualRun::new(cycle, emulator(AXES, Script::default()), PERIOD_NS);
    let ended = bench
        .run(2000, |bench, _| Orders { start: bench.next() >= 10, ..Orders::default() })
        .unwrap();
    assert_eq!((ended.memory.state, ended.memory.reason), (State::Fault, Reason::CommandSaturated));
    assert!(ended.entered < 200 + 30 + u64::from(WATCH.saturated));
}

#[test]
fn missed_cycles_beyond_the_limit_are_a_fault_and_fewer_are_not() {
    for (skipped, expected) in [(8, State::Running), (9, State::Fault)] {
        let mut bench = virtual_run(AXES, controller(AXES, control_law(AXES)), Script::default());
        let start = Orders { start: true, ..Orders::default() };
        for _ in 0..300 {
            bench.tick(&start, 0).unwrap();
        }
        let before = bench.cycle.row().to_vec();
        let memory = bench.tick(&start, skipped).unwrap();
        // In the record a missed deadline is a row that is not there: the next one says so.
        let (row, place) = (bench.cycle.row(), 1 + 3 * AXES + 7);
        let periods = (row[0] - before[0]) / PERIOD;
        assert!((periods - f64::from(1 + skipped)).abs() < 1e-6, "{periods} periods");
        assert_eq!((before[place], row[place]), (0.0, f64::from(skipped)));
        assert_eq!(memory.state, expected, "{skipped} skipped: {memory:?}");
    }
}

#[test]
fn a_stop_ramps_down_and_a_reset_leads_back() {
    let mut bench = virtual_run(AXES, controller(AXES, control_law(AXES)), Script::default());
    let ended = bench
        .run(5000, |bench, _| Orders {
            start: bench.next() >= 10,
            stop: bench.next() >= 400,
            reset: false,
        })
        .unwrap();
    assert_eq!((ended.memory.state, ended.memory.reason), (State::Safe, Reason::Stopped));
    assert_eq!(ended.entered, 400);
    assert_eq!(bench.emulator.applied().len(), AXES);
    for _ in 0..3 {
        bench.tick(&Orders::default(), 0).unwrap();
    }
    assert_eq!(bench.emulator.applied(), [0.0; AXES], "the machine got the last ramp");
    let reset = Orders { reset: true, ..Orders::default() };
    assert_eq!(bench.tick(&reset, 0).unwrap().state, State::Idle);
    assert_eq!(bench.tick(&Orders::default(), 0).unwrap().state, State::Ready);
    let again = bench.tick(&Orders { start: true, ..Orders::default() }, 0).unwrap();
    assert_eq!(again.state, State::Running);
}

#[test]
fn a_runner_that_dies_leaves_the_machine_to_its_heartbeat() {
    let mut bench = virtual_run(AXES, controller(AXES, control_law(AXES)), Script::default());
    let start = Orders { start: true, ..Orders::default() };
    for _ in 0..300 {
        bench.tick(&start, 0).unwrap();
    }
    assert!(!bench.emulator.is_stopped() && bench.emulator.applied()[0] > 10.0);
    let mut silent = bench::gateway::pair().0;
    for k in 0..25 {
        bench.emulator.serve((301 + k) * PERIOD_NS + 1, &mut silent).unwrap();
    }
    assert!(bench.emulator.is_stopped());
    assert_eq!(bench.emulator.applied(), [0.0; AXES]);
}

#[test]
fn it_starts_without_a_bump_and_tracks() {
    let mut bench = virtual_run(AXES, controller(AXES, control_law(AXES)), Script::default());
    let (mut greatest, mut before, mut error) = (0.0_f64, vec![0.0; AXES], 0.0_f64);
    let mut running = 0;
    bench
        .run(5000, |bench, memory| {
            running += u32::from(memory.state == State::Running);
            if running <= 5 {
                let jump = bench.cycle.commands().iter().zip(&before);
                greatest = jump.map(|(a, b): (&f64, &f64)| (a - b).abs()).fold(greatest, f64::max);
            }
            before.copy_from_slice(bench.cycle.commands());
            let row = bench.cycle.row();
            let (reference, position) = (row[1], row[1 + AXES]);
            // From the second period on the motion is steady.
            if memory.state == State::Running && bench.next() > 300 {
                error = error.max((reference - position).abs());
            }
            Orders { start: bench.next() >= 10, ..Orders::default() }
        })
        .unwrap();
    assert_eq!(running, APPROACH + ROWS, "every row has its cycle");
    assert!(greatest < 0.1, "largest step of a command in its first cycles: {greatest} V");
    assert!(error < 0.6, "{error} um");
    let counters = bench.cycle.counters();
    assert_eq!((counters.lost, counters.corrupt, counters.late), (0, 0, 0));
}
