//! The state machine.

use std::fmt;

/// What the bench does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[repr(u8)]
pub enum State {
    /// No machine is heard. The safe value is sent, without ENABLE.
    #[default]
    Idle = 0,
    /// The machine answers and is ready. The command rests at the safe value.
    Ready = 1,
    /// The controller drives.
    Running = 2,
    /// The controller drives on with the last good sample, for a few cycles.
    Hold = 3,
    /// Stopped, finished, or without samples: the command goes to the safe value and stays.
    Safe = 4,
    /// A limit was broken: the command goes to the safe value and stays. Latched.
    Fault = 5,
}

/// Why the bench is in its state. The numbers are those of the packet and of the record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[repr(u8)]
pub enum Reason {
    /// All is as it should be.
    #[default]
    None = 0,
    /// Somebody stopped it.
    Stopped = 1,
    /// The plan has ended.
    Finished = 2,
    /// No packet came.
    SampleLost = 3,
    /// Samples came too late to be used.
    SampleLate = 4,
    /// Packets came damaged.
    SampleCorrupt = 5,
    /// A sample was not a finite number.
    SampleNotFinite = 6,
    /// The machine's sensors say that they are not valid.
    SampleInvalid = 7,
    /// A position is outside its limits.
    PositionLimit = 8,
    /// A position changes faster than its limit.
    PositionRate = 9,
    /// Position and reference are too far apart.
    TrackingError = 10,
    /// A position does not move any more though its command does.
    SensorStuck = 11,
    /// The controller's command is not a finite number.
    CommandNotFinite = 12,
    /// A command has been at its limit for too long.
    CommandSaturated = 13,
    /// The controller FMU failed.
    ControllerFailed = 14,
    /// The machine's power is off.
    PowerLost = 15,
    /// The machine stopped itself.
    MachineSafe = 16,
    /// The machine counts its packets anew.
    MachineRestarted = 17,
    /// The runner missed too many cycles in one go.
    Overrun = 18,
}

impl State {
    /// All states.
    pub const ALL: [State; 6] =
        [State::Idle, State::Ready, State::Running, State::Hold, State::Safe, State::Fault];

    /// The state of this number.
    #[must_use]
    pub fn of(number: u8) -> Option<State> {
        State::ALL.get(usize::from(number)).copied()
    }

    /// The state's name.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["idle", "ready", "running", "hold", "safe", "fault"][self as usize]
    }

    /// Whether the controller drives.
    #[must_use]
    pub fn drives(self) -> bool {
        matches!(self, State::Running | State::Hold)
    }
}

impl Reason {
    /// All reasons.
    pub const ALL: [Reason; 19] = [
        Reason::None,
        Reason::Stopped,
        Reason::Finished,
        Reason::SampleLost,
        Reason::SampleLate,
        Reason::SampleCorrupt,
        Reason::SampleNotFinite,
        Reason::SampleInvalid,
        Reason::PositionLimit,
        Reason::PositionRate,
        Reason::TrackingError,
        Reason::SensorStuck,
        Reason::CommandNotFinite,
        Reason::CommandSaturated,
        Reason::ControllerFailed,
        Reason::PowerLost,
        Reason::MachineSafe,
        Reason::MachineRestarted,
        Reason::Overrun,
    ];

    /// The reason of this number.
    #[must_use]
    pub fn of(number: u8) -> Option<Reason> {
        Reason::ALL.get(usize::from(number)).copied()
    }

    /// One clause for a person.
    #[must_use]
    pub fn sentence(self) -> &'static str {
        match self {
            Reason::None => "as it should be",
            Reason::Stopped => "somebody stopped it",
            Reason::Finished => "the plan has ended",
            Reason::SampleLost => "no packet came from the machine",
            Reason::SampleLate => "samples came too late to be used",
            Reason::SampleCorrupt => "packets came damaged",
            Reason::SampleNotFinite => "a sample was not a finite number",
            Reason::SampleInvalid => "the machine's sensors said that they are not valid",
            Reason::PositionLimit => "a position was outside its limits",
            Reason::PositionRate => "a position changed faster than its limit",
            Reason::TrackingError => "position and reference were too far apart",
            Reason::SensorStuck => "a position did not move though its command did",
            Reason::CommandNotFinite => "the controller's command was not a finite number",
            Reason::CommandSaturated => "a command was at its limit for too long",
            Reason::ControllerFailed => "the controller FMU failed",
            Reason::PowerLost => "the machine's power was off",
            Reason::MachineSafe => "the machine had stopped itself",
            Reason::MachineRestarted => "the machine counted its packets anew",
            Reason::Overrun => "the runner missed too many cycles in one go",
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.sentence())
    }
}

/// State and reason: all that the state machine remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Memory {
    /// The state.
    pub state: State,
    /// Why.
    pub reason: Reason,
}

/// What happened in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events {
    /// Cycles since the last good sample; 0: one came in this cycle.
    pub missing: u32,
    /// Why no good sample came, if none did.
    pub missing_because: Reason,
    /// The machine is powered and has not stopped itself.
    pub machine_ready: bool,
    /// A limit is broken.
    pub fault: Option<Reason>,
    /// Somebody wants it to run.
    pub start: bool,
    /// Somebody wants it to stop.
    pub stop: bool,
    /// Somebody acknowledges the fault.
    pub reset: bool,
    /// The plan has ended.
    pub finished: bool,
    /// The command has reached the safe value.
    pub at_rest: bool,
}

/// One cycle of the state machine. The first line that fits a state decides:
///
/// | state | event | next | reason |
/// |---|---|---|---|
/// | every one but fault | the controller failed | fault | controller failed |
/// | every one but idle and fault | a limit is broken | fault | which |
/// | idle | stop | safe | stopped |
/// | idle | a sample, and the machine is ready | ready | none |
/// | ready | stop | safe | stopped |
/// | ready | no sample for more than `hold` cycles | idle | why |
/// | ready | start, and a sample in this cycle | running | none |
/// | running, hold | stop | safe | stopped |
/// | running, hold | the plan has ended | safe | finished |
/// | running, hold | no sample for more than `hold` cycles | safe | why |
/// | running | no sample | hold | why |
/// | hold | a sample | running | none |
/// | safe, fault | reset, at rest, a sample, the machine ready, no limit broken | idle | none |
///
/// Everything else stays as it is: a fault keeps its first reason.
#[must_use]
pub fn next(memory: Memory, events: &Events, hold: u32) -> Memory {
    use State::{Fault, Hold, Idle, Ready, Running, Safe};
    let to = |state, reason| Memory { state, reason };
    let state = memory.state;
    let sampled = events.missing == 0;
    let gone = events.missing > hold;
    if let (Some(reason), false) = (events.fault, state == Fault)
        && (state != Idle || reason == Reason::ControllerFailed)
    {
        return to(Fault, reason);
    }
    match state {
        Idle | Ready | Running | Hold if events.stop => to(Safe, Reason::Stopped),
        Idle if sampled && events.machine_ready => to(Ready, Reason::None),
        Ready if gone => to(Idle, events.missing_because),
        Ready if events.start && sampled => to(Running, Reason::None),
        Running | Hold if events.finished => to(Safe, Reason::Finished),
        Running | Hold if gone => to(Safe, events.missing_because),
        Running if !sampled => to(Hold, events.missing_because),
        Hold if sampled => to(Running, Reason::None),
        Safe | Fault if can_reset(events) => to(Idle, Reason::None),
        _ => memory,
    }
}

fn can_reset(events: &Events) -> bool {
    let heard = events.missing == 0 && events.machine_ready;
    events.reset && events.at_rest && heard && events.fault.is_none() && !events.stop
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A cycle in which all is well.
    const WELL: Events = Events {
        missing: 0,
        missing_because: Reason::None,
        machine_ready: true,
        fault: None,
        start: false,
        stop: false,
        reset: false,
        finished: false,
        at_rest: true,
    };
    const LOST: Events = Events { missing: 1, missing_because: Reason::SampleLost, ..WELL };
    const GONE: Events = Events { missing: 4, ..LOST };

    fn memory(state: State, reason: Reason) -> Memory {
        Memory { state, reason }
    }

    #[test]
    fn the_table_is_the_function() {
        use State::{Fault, Hold, Idle, Ready, Running, Safe};
        let broken = Events { fault: Some(Reason::PositionLimit), ..WELL };
        let failed = Events { fault: Some(Reason::ControllerFailed), ..WELL };
        let stop = Events { stop: true, ..WELL };
        let reset = Events { reset: true, ..WELL };
        let start = Events { start: true, ..WELL };
        let table: &[(State, Events, State, Reason)] = &[
            (Idle, failed, Fault, Reason::ControllerFailed),
            (Idle, broken, Ready, Reason::None),
            (Idle, stop, Safe, Reason::Stopped),
            (Idle, WELL, Ready, Reason::None),
            (Idle, Events { machine_ready: false, ..WELL }, Idle, Reason::None),
            (Idle, GONE, Idle, Reason::None),
            (Ready, broken, Fault, Reason::PositionLimit),
            (Ready, stop, Safe, Reason::Stopped),
            (Ready, GONE, Idle, Reason::SampleLost),
            (Ready, start, Running, Reason::None),
            (Ready, Events { start: true, ..LOST }, Ready, Reason::None),
            (Ready, WELL, Ready, Reason::None),
            (Running, broken, Fault, Reason::PositionLimit),
            (Running, stop, Safe, Reason::Stopped),
            (Running, Events { finished: true, ..WELL }, Safe, Reason::Finished),
            (Running, GONE, Safe, Reason::SampleLost),
            (Running, LOST, Hold, Reason::SampleLost),
            (Running, WELL, Running, Reason::None),
            (Hold, broken, Fault, Reason::PositionLimit),
            (Hold, stop, Safe, Reason::Stopped),
            (Hold, Events { finished: true, ..LOST }, Safe, Reason::Finished),
            (Hold, GONE, Safe, Reason::SampleLost),
            (Hold, LOST, Hold, Reason::None),
            (Hold, WELL, Running, Reason::None),
            (Safe, broken, Fault, Reason::PositionLimit),
            (Safe, stop, Safe, Reason::None),
            (Safe, reset, Idle, Reason::None),
            (Safe, Events { at_rest: false, ..reset }, Safe, Reason::None),
            (Safe, Events { missing: 1, ..reset }, Safe, Reason::None),
            (Fault, failed, Fault, Reason::None),
            (Fault, stop, Fault, Reason::None),
            (Fault, reset, Idle, Reason::None),
            (Fault, Events { reset: true, ..broken }, Fault, Reason::None),
            (Fault, Events { machine_ready: false, ..reset }, Fault, Reason::None),
        ];
        for (state, events, then, reason) in table {
            let found = next(memory(*state, Reason::None), events, 3);
            assert_eq!(found, memory(*then, *reason), "{state:?} with {events:?}");
        }
    }

    #[test]
    fn numbers_name_states_and_reasons() {
        assert!(State::ALL.iter().all(|s| State::of(*s as u8) == Some(*s)));
        assert!(Reason::ALL.iter().all(|r| Reason::of(*r as u8) == Some(*r)));
        assert_eq!((State::of(6), Reason::of(19)), (None, None));
    }

    fn any_state() -> impl Strategy<Value = State> {
        prop::sample::select(State::ALL.to_vec())
    }

    fn any_reason() -> impl Strategy<Value = Reason> {
        prop::sample::select(Reason::ALL.to_vec())
    }

    prop_compose! {
        fn any_events()(
            missing in 0u32..10,
            missing_because in any_reason(),
            fault in prop::option::of(any_reason()),
            flags in prop::array::uniform6(any::<bool>()),
        ) -> Events {
            let [machine_ready, start, stop, reset, finished, at_rest] = flags;
            Events {
                missing, missing_because, machine_ready, fault, start, stop, reset, finished, at_rest,
            }
        }
    }

    proptest! {
        #[test]
        fn it_drives_only_from_ready_and_only_when_asked(
            state in any_state(), reason in any_reason(), events in any_events(), hold in 0u32..5,
        ) {
            let then = next(memory(state, reason), &events, hold).state;
            if then.drives() && !state.drives() {
                prop_assert_eq!(state, State::Ready);
                prop_assert!(events.start && events.missing == 0 && events.fault.is_none());
                prop_assert!(!events.stop);
            }
        }

        #[test]
        fn nothing_drives_on_over_a_fault_a_stop_or_too_many_missing_samples(
            state in any_state(), reason in any_reason(), events in any_events(), hold in 0u32..5,
        ) {
            let then = next(memory(state, reason), &events, hold).state;
            let forbidden = events.fault.is_some() || events.stop || events.missing > hold;
            prop_assert!(!(forbidden && then.drives()), "{:?}", then);
            if events.fault.is_some() && state != State::Idle {
                prop_assert_eq!(then, State::Fault);
            }
        }

        #[test]
        fn a_fault_is_left_by_a_reset_only_and_keeps_its_first_reason(
            first in any_reason(), all in prop::collection::vec(any_events(), 1..40),
        ) {
            let mut now = memory(State::Fault, first);
            for events in all {
                now = next(now, &Events { reset: false, ..events }, 3);
                prop_assert_eq!(now, memory(State::Fault, first));
            }
        }

        #[test]
        fn hold_lasts_as_long_as_it_may(hold in 0u32..20) {
            let mut now = memory(State::Running, Reason::None);
            for missing in 1..=hold {
                now = next(now, &Events { missing, ..LOST }, hold);
                prop_assert_eq!(now.state, State::Hold);
            }
            now = next(now, &Events { missing: hold + 1, ..LOST }, hold);
            prop_assert_eq!(now, memory(State::Safe, Reason::SampleLost));
        }
    }
}
