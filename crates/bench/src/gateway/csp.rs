//! A drive in cyclic synchronous position mode (CSP), the profile CiA 402 over EtherCAT: E-727-class piezo controllers and
//! servo drives.
//!
//! | object | what | direction |
//! |---|---|---|
//! | 0x6040 | controlword | output |
//! | 0x607A | target position | output |
//! | 0x6060 | modes of operation, 8 = CSP | output, optional |
//! | 0x6041 | statusword | input |
//! | 0x6064 | position actual value | input |
//! | 0x6061 | modes of operation display | input, optional |
//!
//! Without ENABLE the drive is led to *ready to switch on*, and its target follows its position. With ENABLE it is led to
//! *operation enabled*; from there the target goes from the position to the command within [`TAKE_OVER`] exchanges, so that
//! nothing jumps. A fault is not reset while ENABLE is set: without it, as the acknowledgement, bit 7 resets it.
//!
//! Source: CiA 402-2 / IEC 61800-7-201, state machine, controlword and statusword; ETG.6010 for EtherCAT.

use serde::Deserialize;

/// Exchanges from the position to the command.
pub const TAKE_OVER: u32 = 100;
/// Exchanges within which a drive is in *operation enabled*.
pub const BRING_UP: u32 = 2000;
/// Cyclic synchronous position mode.
pub const MODE: i8 = 8;

/// Where the objects beside target and position stand in the process data of the channel's SubDevices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CspData {
    /// 0x6040, u16: byte in the outputs.
    pub controlword: usize,
    /// 0x6041, u16: byte in the inputs.
    pub statusword: usize,
    /// 0x6060, i8: byte in the outputs; without it the mode is set elsewhere.
    pub mode: Option<usize>,
    /// 0x6061, i8: byte in the inputs; without it the mode is not looked at.
    pub mode_display: Option<usize>,
}

/// States of a drive, by its statusword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveState {
    /// It comes up.
    NotReady,
    /// No high level power.
    SwitchOnDisabled,
    /// It may be switched on.
    ReadyToSwitchOn,
    /// Power is on, nothing moves.
    SwitchedOn,
    /// It follows its target.
    OperationEnabled,
    /// It stops.
    QuickStop,
    /// It reacts to a fault.
    FaultReaction,
    /// It has a fault.
    Fault,
}

impl DriveState {
    /// The state that a statusword tells.
    #[must_use]
    pub fn of(statusword: u16) -> Self {
        match (statusword & 0x4f, statusword & 0x6f) {
            (0x40, _) => DriveState::SwitchOnDisabled,
            (0x0f, _) => DriveState::FaultReaction,
            (0x08, _) => DriveState::Fault,
            (_, 0x21) => DriveState::ReadyToSwitchOn,
            (_, 0x23) => DriveState::SwitchedOn,
            (_, 0x27) => DriveState::OperationEnabled,
            (_, 0x07) => DriveState::QuickStop,
            _ => DriveState::NotReady,
        }
    }
}

/// What a drive is told next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// 0x6040.
    pub controlword: u16,
    /// It is in *operation enabled*, as it was asked to be.
    pub follows: bool,
    /// Share of the command in the target; the rest is the position at which it began to follow.
    pub share: f64,
    /// It does as it is told.
    pub powered: bool,
}

/// One drive.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drive {
    /// Exchanges with ENABLE.
    asked: u32,
    /// Exchanges in *operation enabled*.
    follows: u32,
    resets: bool,
}

impl Drive {
    /// The next controlword, for a statusword and the mode that it displays.
    pub fn turn(&mut self, enabled: bool, statusword: u16, mode: Option<i8>) -> Turn {
        use DriveState::{
            Fault, FaultReaction, NotReady, OperationEnabled, QuickStop, ReadyToSwitchOn,
            SwitchOnDisabled, SwitchedOn,
        };
        let state = DriveState::of(statusword);
        self.asked = if enabled { self.asked.saturating_add(1) } else { 0 };
        let is_mode = mode.is_none_or(|mode| mode == MODE);
        let does = enabled && state == OperationEnabled && is_mode;
        self.follows = if does { self.follows.saturating_add(1) } else { 0 };
        // The reset of a fault is an edge.
        self.resets = !enabled && state == Fault && !self.resets;
        let controlword = match state {
            Fault if self.resets => 0x80,
            NotReady | FaultReaction | Fault | QuickStop => 0x00,
            SwitchOnDisabled => 0x06,
            _ if !enabled => 0x06,
            ReadyToSwitchOn => 0x07,
            // Not before its mode is that of the targets.
            SwitchedOn if !is_mode => 0x07,
            SwitchedOn | OperationEnabled => 0x0f,
        };
        let is_broken = matches!(state, FaultReaction | Fault | QuickStop);
        let is_late = enabled && !does && self.asked > BRING_UP;
        Turn {
            controlword,
            follows: does,
            share: f64::from(self.follows.min(TAKE_OVER)) / f64::from(TAKE_OVER),
            powered: !is_broken && !is_late,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statuswords_of_the_standard_are_their_states() {
        use DriveState::*;
        for (word, state) in [
            (0x0000, NotReady),
            (0x0250, SwitchOnDisabled),
            (0x0231, ReadyToSwitchOn),
            (0x0233, SwitchedOn),
            (0x1237, OperationEnabled),
            (0x0217, QuickStop),
            (0x021f, FaultReaction),
            (0x0218, Fault),
        ] {
            assert_eq!(DriveState::of(word), state, "{word:#06x}");
        }
    }

    #[test]
    fn a_drive_comes_up_takes_over_slowly_and_goes_down() {
        let mut drive = Drive::default();
        let mut controlwords = Vec::new();
        for word in [0x0250, 0x0231, 0x0233, 0x0237] {
            controlwords.push(drive.turn(true, word, Some(MODE)).controlword);
        }
        assert_eq!(controlwords, [0x06, 0x07, 0x0f, 0x0f]);
        let shares: Vec<f64> =
            (0..150).map(|_| drive.turn(true, 0x0237, Some(MODE)).share).collect();
        assert!(shares.windows(2).all(|pair| (0.0..=0.0101).contains(&(pair[1] - pair[0]))));
        assert_eq!((shares[0], shares[149]), (0.02, 1.0));
        let turn = drive.turn(false, 0x0237, Some(MODE));
        assert_eq!((turn.controlword, turn.share), (0x06, 0.0));
    }

    #[test]
    fn a_fault_is_reset_by_an_edge_and_only_without_enable() {
        let mut drive = Drive::default();
        for _ in 0..3 {
            let turn = drive.turn(true, 0x0218, None);
            assert_eq!((turn.controlword, turn.powered), (0x00, false));
        }
        let edges: Vec<u16> = (0..4).map(|_| drive.turn(false, 0x0218, None).controlword).collect();
        assert_eq!(edges, [0x80, 0x00, 0x80, 0x00]);
    }

    #[test]
    fn another_mode_or_a_drive_that_does_not_come_up_is_no_power() {
        let mut drive = Drive::default();
        let turn = drive.turn(true, 0x0233, Some(1));
        assert_eq!((turn.controlword, turn.share, turn.powered), (0x07, 0.0, true));
        for _ in 0..BRING_UP {
            drive.turn(true, 0x0233, Some(1));
        }
        assert!(!drive.turn(true, 0x0233, Some(1)).powered);
    }
}
