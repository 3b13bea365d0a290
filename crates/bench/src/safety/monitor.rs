//! What breaks a limit.

use super::limits::{AxisLimits, Watch};
use super::state::Reason;
use crate::packet::{Header, Status};

/// Looks at samples and commands, cycle by cycle.
#[derive(Clone, Debug)]
pub struct Monitor {
    axes: Box<[Axis]>,
    watch: Watch,
    /// Length of a cycle in s.
    period: f64,
}

/// What is remembered of one axis.
#[derive(Clone, Debug)]
struct Axis {
    limits: AxisLimits,
    /// Last good position, and the sequence that it came with.
    position: Option<(f64, u32)>,
    tracking: u32,
    stuck: u32,
    saturated: u32,
    /// Command when the position began to keep its bits.
    command_then: f64,
}

/// One cycle as the monitor sees it.
#[derive(Clone, Copy, Debug)]
pub struct Observed<'a> {
    /// Positions of a sample that came in this cycle; `None` when none did.
    pub sample: Option<(&'a [f64], u32)>,
    /// References, while the controller drives and the plan plays.
    pub references: Option<&'a [f64]>,
    /// Commands that were sent last.
    pub commands: &'a [f64],
    /// Whether the controller drives.
    pub drives: bool,
}

impl Monitor {
    /// A monitor of these axes with cycles of `period` s.
    #[must_use]
    pub fn new(limits: &[AxisLimits], watch: Watch, period: f64) -> Self {
        let axis = |limits: &AxisLimits| Axis {
            limits: *limits,
            position: None,
            tracking: 0,
            stuck: 0,
            saturated: 0,
            command_then: 0.0,
        };
        Monitor { axes: limits.iter().map(axis).collect(), watch, period }
    }

    /// The first limit that is broken, axis by axis.
    pub fn look(&mut self, observed: &Observed<'_>) -> Option<Reason> {
        let mut found = None;
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let command = observed.commands.get(index).copied().unwrap_or_default();
            if let Some((positions, sequence)) = observed.sample {
                let position = positions.get(index).copied().unwrap_or_default();
                let moved = axis.moved(position, sequence, self.period);
                let stuck = axis.stuck(position, command, observed.drives, self.watch.stuck);
                axis.position = Some((position, sequence));
                found = found.or(moved).or(stuck);
            }
            let reference = observed.references.and_then(|all| all.get(index)).copied();
            found = found.or(axis.tracks(reference, self.watch.tracking));
            found = found.or(axis.saturates(command, observed.drives, self.watch.saturated));
        }
        found
    }

    /// What the machine says about itself while it should be ready.
    #[must_use]
    pub fn machine(header: Option<&Header>) -> Option<Reason> {
        let status = header?.status;
        if !status.has(Status::POWERED) {
            return Some(Reason::PowerLost);
        }
        status.has(Status::SAFE).then_some(Reason::MachineSafe)
    }

    /// Forgets what was, for a new start.
    pub fn reset(&mut self) {
        for axis in &mut self.axes {
            (axis.position, axis.tracking, axis.stuck, axis.saturated) = (None, 0, 0, 0);
        }
    }
}

/// Counts cycles in a row; true when there are `most` of them, unless `most` is 0.
fn in_a_row(count: &mut u32, goes_on: bool, most: u32) -> bool {
    *count = if goes_on { count.saturating_add(1) } else { 0 };
    most > 0 && *count >= most
}

impl Axis {
    fn moved(&self, position: f64, sequence: u32, period: f64) -> Option<Reason> {
        let [least, greatest] = self.limits.position;
        if position < least || position > greatest {
            return Some(Reason::PositionLimit);
        }
        let (before, at) = self.position?;
        let cycles = f64::from(sequence.wrapping_sub(at).max(1));
        let rate = (position - before).abs() / (cycles * period);
        (rate > self.limits.position_rate).then_some(Reason::PositionRate)
    }

    fn stuck(&mut self, position: f64, command: f64, drives: bool, most: u32) -> Option<Reason> {
        let same = self.position.is_some_and(|(before, _)| before.to_bits() == position.to_bits());
        if !same {
            self.command_then = command;
        }
        let stuck = in_a_row(&mut self.stuck, same && drives, most);
        (stuck && command != self.command_then).then_some(Reason::SensorStuck)
    }

    fn tracks(&mut self, reference: Option<f64>, most: u32) -> Option<Reason> {
        let error = reference.zip(self.position).map(|(r, (y, _))| (r - y).abs());
        let too_far = error.is_some_and(|error| error > self.limits.tracking_error);
        in_a_row(&mut self.tracking, too_far, most).then_some(Reason::TrackingError)
    }

    fn saturates(&mut self, command: f64, drives: bool, most: u32) -> Option<Reason> {
        let [least, greatest] = self.limits.command;
        let at_limit = drives && (command <= least || command >= greatest);
        in_a_row(&mut self.saturated, at_limit, most).then_some(Reason::CommandSaturated)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: AxisLimits = AxisLimits {
        command: [0.0, 100.0],
        command_rate: 1e3,
        position: [-10.0, 10.0],
        position_rate: 1000.0,
        tracking_error: 0.5,
        safe: 0.0,
        safe_rate: 1e3,
    };
    const WATCH: Watch =
        Watch { hold: 3, max_age: 3, tracking: 3, stuck: 4, saturated: 2, overrun: 5 };

    fn monitor() -> Monitor {
        Monitor::new(&[LIMITS, LIMITS], WATCH, 1e-3)
    }

    fn look(m: &mut Monitor, k: u32, y: [f64; 2], r: [f64; 2], u: [f64; 2]) -> Option<Reason> {
        let sample = Some((&y[..], k));
        m.look(&Observed { sample, references: Some(&r), commands: &u, drives: true })
    }

    #[test]
    fn positions_outside_and_too_fast() {
        let mut m = monitor();
        assert_eq!(look(&mut m, 0, [0.0, 9.0], [0.0, 9.0], [1.0; 2]), None);
        assert_eq!(look(&mut m, 1, [1.0, 10.0], [1.0, 10.0], [1.0; 2]), None);
        assert_eq!(
            look(&mut m, 2, [1.0, 10.1], [1.0, 10.1], [1.0; 2]),
            Some(Reason::PositionLimit)
        );
        let mut m = monitor();
        look(&mut m, 0, [0.0; 2], [0.0; 2], [1.0; 2]);
        // 1.1 in two cycles is slower than the limit, in one it is faster.
        assert_eq!(look(&mut m, 2, [1.1, 0.0], [1.1, 0.0], [1.0; 2]), None);
        assert_eq!(look(&mut m, 3, [2.3, 0.1], [2.3, 0.1], [1.0; 2]), Some(Reason::PositionRate));
    }

    #[test]
    fn tracking_error_must_last() {
        let mut m = monitor();
        let found: Vec<_> = [0.6, 0.6, 0.4, 0.6, 0.6, 0.6]
            .iter()
            .zip(0..)
            .map(|(r, k)| look(&mut m, k, [f64::from(k) * 1e-6, 0.0], [*r, 0.0], [1.0; 2]))
            .collect();
        assert_eq!(found[..5], [None; 5]);
        assert_eq!(found[5], Some(Reason::TrackingError));
    }

    #[test]
    fn a_sensor_is_stuck_only_if_its_command_moves() {
        let still = |k: u32| f64::from(k) * 0.1;
        let mut m = monitor();
        for k in 0..20 {
            assert_eq!(look(&mut m, k, [0.0, still(k) / 10.0], [0.0; 2], [5.0; 2]), None, "{k}");
        }
        let mut m = monitor();
        let found = (0..20).position(|k| {
            let y = [0.3, still(k) / 10.0];
            look(&mut m, k, y, y, [5.0 + still(k), 5.0]) == Some(Reason::SensorStuck)
        });
        assert_eq!(found, Some(4), "the fifth sample is the fourth that repeats the first");
    }

    #[test]
    fn a_command_at_its_limit_must_leave_it() {
        let mut m = monitor();
        let y = |k: u32| [f64::from(k) * 1e-6; 2];
        assert_eq!(look(&mut m, 0, y(0), y(0), [100.0, 1.0]), None);
        assert_eq!(look(&mut m, 1, y(1), y(1), [99.0, 1.0]), None);
        assert_eq!(look(&mut m, 2, y(2), y(2), [100.0, 1.0]), None);
        assert_eq!(look(&mut m, 3, y(3), y(3), [100.0, 1.0]), Some(Reason::CommandSaturated));
    }
}
