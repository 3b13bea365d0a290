//! A campaign of faults in virtual time: each ends in the state that is expected, within its
//! deadline in cycles, and with the machine at rest.
#![allow(clippy::print_stdout)]

mod common;

use common::{APPROACH, PERIOD, PERIOD_NS, ROWS, WATCH};
use common::{control_law, controller, cycle_with, emulator, limits, rehearsal};
use piezoloop_bench::cycle::Orders;
use piezoloop_bench::emulate::{Direction, Fault, FaultKind, Script};
use piezoloop_bench::rehearsal::Rehearsal;
use piezoloop_bench::safety::{AxisLimits, Reason, State};

const AXES: usize = 2;

/// What is injected at a cycle, and what must come of it.
struct Case {
    name: String,
    kind: FaultKind,
    direction: Direction,
    /// Cycle of the machine in which it begins, and how many it lasts.
    begin: u32,
    lasts: Option<u32>,
    seed: u64,
    state: State,
    reason: Reason,
    /// Greatest number of cycles from the begin to the last state.
    within: u32,
}

const ALL: u32 = 10 + APPROACH + ROWS + 10;

fn run(case: &Case) -> Result<(), String> {
    // Half a cycle early, so that rounding does not decide.
    let time = |cycle: u32| (f64::from(cycle) - 0.5) * PERIOD;
    let fault = Fault {
        kind: case.kind,
        direction: case.direction,
        from: time(case.begin),
        to: case.lasts.map(|cycles| time(case.begin + cycles)),
    };
    let script = Script { seed: case.seed, faults: vec![fault] };
    let mut bench = rehearsal(AXES, controller(AXES, control_law(AXES)), script);
    let mut wild = false;
    let mut before = vec![0.0; AXES];
    let most = limits().command_rate * PERIOD + 1e-9;
    let ended = bench
        .run(u64::from(ALL) + 400, |bench, _| {
            let commands = bench.cycle.commands();
            let [least, greatest] = limits().command;
            wild |= commands.iter().any(|u| !(least..=greatest).contains(u));
            wild |= commands.iter().zip(&before).any(|(now, then)| (now - then).abs() > most);
            before.copy_from_slice(commands);
            Orders { start: bench.next() >= 10, ..Orders::default() }
        })
        .map_err(|error| error.to_string())?;
    let found = (ended.memory.state, ended.memory.reason);
    if found != (case.state, case.reason) {
        return Err(format!("ended in {found:?}, expected {:?}", (case.state, case.reason)));
    }
    let took = ended.entered.saturating_sub(case.begin.into());
    if took > case.within.into() {
        return Err(format!("{took} cycles, at most {} allowed", case.within));
    }
    let ramp = (105.0 / (limits().safe_rate * PERIOD)) as u64 + 2;
    if ended.at_rest > ended.entered + ramp {
        return Err(format!("at rest only {} cycles later", ended.at_rest - ended.entered));
    }
    if wild { Err("a command left its limits".to_owned()) } else { Ok(()) }
}

/// Beginnings in the approach and at several phases of the motion.
const BEGINS: [u32; 6] = [30, 140, 333, 485, 620, 777];

fn add(
    cases: &mut Vec<Case>,
    kind: FaultKind,
    direction: Direction,
    lasts: Option<u32>,
    outcome: (State, Reason, u32),
) {
    for begin in BEGINS {
        let (state, reason, within) = outcome;
        let name = format!("{kind:?} {direction:?} from {begin} for {lasts:?}");
        let seed = u64::from(begin) * 31 + cases.len() as u64;
        cases.push(Case { name, kind, direction, begin, lasts, seed, state, reason, within });
    }
}

fn packets(cases: &mut Vec<Case>) {
    use Direction::{Both, Command, Measurement};
    let hold = WATCH.hold;
    let lost = (State::Safe, Reason::SampleLost, hold + 3);
    let late = (State::Safe, Reason::SampleLate, WATCH.max_age + hold + 4);
    let well = (State::Safe, Reason::Finished, ALL);
    let loss = FaultKind::Loss { probability: 1.0 };
    add(cases, loss, Measurement, None, lost);
    add(cases, loss, Both, None, lost);
    // Commands that do not arrive: the samples answer ever older ones.
    add(cases, loss, Command, None, late);
    add(cases, loss, Measurement, Some(hold), well);
    add(cases, loss, Measurement, Some(hold + 2), lost);
    add(cases, loss, Command, Some(WATCH.max_age), well);
    add(cases, FaultKind::Loss { probability: 0.05 }, Both, None, well);
    let cycles = |n: f64| n * PERIOD;
    add(cases, FaultKind::Delay { seconds: cycles(2.0) }, Measurement, None, well);
    add(cases, FaultKind::Delay { seconds: cycles(4.0) }, Measurement, None, late);
    add(cases, FaultKind::Delay { seconds: cycles(4.0) }, Command, None, late);
    add(cases, FaultKind::Jitter { seconds: cycles(2.0) }, Measurement, None, well);
    let corrupt = FaultKind::Corrupt { probability: 1.0 };
    add(cases, corrupt, Measurement, None, (State::Safe, Reason::SampleCorrupt, hold + 3));
    add(cases, corrupt, Command, None, late);
    add(cases, FaultKind::Corrupt { probability: 0.02 }, Both, None, well);
    add(cases, FaultKind::Duplicate { probability: 1.0 }, Both, None, well);
    let reorder = FaultKind::Reorder { probability: 0.05, seconds: cycles(1.5) };
    add(cases, reorder, Both, None, well);
}

fn sensors(cases: &mut Vec<Case>) {
    let here = Direction::Measurement;
    let hold = WATCH.hold;
    let well = (State::Safe, Reason::Finished, ALL);
    for axis in [Some(1), Some(2), None] {
        let nan = FaultKind::Nan { axis };
        add(cases, nan, here, None, (State::Safe, Reason::SampleNotFinite, hold + 3));
        add(cases, nan, here, Some(hold - 1), well);
        let stuck = (State::Fault, Reason::SensorStuck, WATCH.stuck + 4);
        add(cases, FaultKind::Stuck { axis }, here, None, stuck);
        let jump = FaultKind::Offset { axis, value: 2.0 };
        add(cases, jump, here, None, (State::Fault, Reason::PositionRate, 3));
        let out = FaultKind::Offset { axis, value: 20.0 };
        add(cases, out, here, None, (State::Fault, Reason::PositionLimit, 3));
        let fine = FaultKind::Quantisation { axis, step: 0.01 };
        add(cases, fine, here, None, well);
    }
    let invalid = (State::Safe, Reason::SampleInvalid, hold + 3);
    add(cases, FaultKind::Invalid, here, None, invalid);
    add(cases, FaultKind::Invalid, here, Some(hold), well);
    add(cases, FaultKind::PowerLoss, here, None, (State::Fault, Reason::PowerLost, 3));
    add(cases, FaultKind::PowerLoss, here, Some(1), (State::Fault, Reason::PowerLost, 3));
    add(cases, FaultKind::Restart, here, None, (State::Fault, Reason::MachineRestarted, 6));
}

#[test]
fn every_fault_ends_as_expected_within_its_deadline() {
    let mut cases = Vec::new();
    packets(&mut cases);
    sensors(&mut cases);
    assert!(cases.len() >= 200, "{}", cases.len());
    println!("{} faults in virtual time, cycles of {} ms", cases.len(), PERIOD_NS / 1_000_000);
    let failed: Vec<String> = cases
        .iter()
        .filter_map(|case| {
            run(case).err().map(|error| format!("{} (seed {}): {error}", case.name, case.seed))
        })
        .collect();
    assert!(failed.is_empty(), "{} of {}:\n{}", failed.len(), cases.len(), failed.join("\n"));
}

#[test]
fn a_sensor_that_saturates_is_found_stuck_at_its_end() {
    // It begins where the sine of 200 cycles is near its middle, between the sensor's ends.
    for begin in [165, 365, 665] {
        let case = Case {
            name: String::new(),
            kind: FaultKind::Saturation { axis: Some(1), min: 3.5, max: 6.5 },
            direction: Direction::Measurement,
            begin,
            lasts: None,
            seed: 1,
            state: State::Fault,
            reason: Reason::SensorStuck,
            within: 200 + WATCH.stuck,
        };
        run(&case).unwrap();
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
        let law: common::Law = Box::new(move |step, inputs, state, outputs| {
            let answer = good(step, inputs, state, outputs);
            if step >= 300 {
                outputs[1] = broken;
            }
            answer && (step < 300 || reason != Reason::ControllerFailed)
        });
        let mut bench = rehearsal(AXES, controller(AXES, law), Script::default());
        let start =
            |bench: &Rehearsal, _| Orders { start: bench.next() >= 10, ..Orders::default() };
        let ended = bench.run(2000, start).unwrap();
        assert_eq!((ended.memory.state, ended.memory.reason), (State::Fault, reason));
        assert!((300..=303).contains(&ended.entered), "{ended:?}");
        assert_eq!(bench.cycle.failure().is_some(), reason == Reason::ControllerFailed);
    }
}

#[test]
fn a_command_that_stays_at_its_limit_is_a_fault() {
    let law: common::Law = Box::new(|step, inputs, _, outputs| {
        outputs.copy_from_slice(&inputs[..AXES]);
        outputs.iter_mut().for_each(|u| *u = if step > 200 { 1e9 } else { 10.0 * *u });
        true
    });
    let free = AxisLimits { tracking_error: f64::INFINITY, ..limits() };
    let cycle = cycle_with(AXES, controller(AXES, law), free);
    let mut bench = Rehearsal::new(cycle, emulator(AXES, Script::default()), PERIOD_NS);
    let ended = bench
        .run(2000, |bench, _| Orders { start: bench.next() >= 10, ..Orders::default() })
        .unwrap();
    assert_eq!((ended.memory.state, ended.memory.reason), (State::Fault, Reason::CommandSaturated));
    assert!(ended.entered < 200 + 30 + u64::from(WATCH.saturated));
}

#[test]
fn missed_cycles_beyond_the_limit_are_a_fault_and_fewer_are_not() {
    for (skipped, expected) in [(8, State::Running), (9, State::Fault)] {
        let mut bench = rehearsal(AXES, controller(AXES, control_law(AXES)), Script::default());
        let start = Orders { start: true, ..Orders::default() };
        for _ in 0..300 {
            bench.tick(&start, 0).unwrap();
        }
        let memory = bench.tick(&start, skipped).unwrap();
        assert_eq!(memory.state, expected, "{skipped} skipped: {memory:?}");
    }
}

#[test]
fn a_stop_ramps_down_and_a_reset_leads_back() {
    let mut bench = rehearsal(AXES, controller(AXES, control_law(AXES)), Script::default());
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
    let mut bench = rehearsal(AXES, controller(AXES, control_law(AXES)), Script::default());
    let start = Orders { start: true, ..Orders::default() };
    for _ in 0..300 {
        bench.tick(&start, 0).unwrap();
    }
    assert!(!bench.emulator.is_stopped() && bench.emulator.applied()[0] > 10.0);
    let mut silent = piezoloop_bench::gateway::pair().0;
    for k in 0..25 {
        bench.emulator.serve((301 + k) * PERIOD_NS + 1, &mut silent).unwrap();
    }
    assert!(bench.emulator.is_stopped());
    assert_eq!(bench.emulator.applied(), [0.0; AXES]);
}

#[test]
fn it_starts_without_a_bump_and_tracks() {
    let mut bench = rehearsal(AXES, controller(AXES, control_law(AXES)), Script::default());
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
