//! The command that is sent.

use super::limits::AxisLimits;
use super::state::State;

/// Makes the command of each cycle: the controller's, limited and slewed; at the start blended in
/// from where the command is; in a stop ramped to the safe value.
#[derive(Clone, Debug)]
pub struct Shaper {
    limits: Box<[AxisLimits]>,
    commands: Box<[f64]>,
    /// Commands when the controller took over.
    from: Box<[f64]>,
    /// Cycle of the blend; reaches `blend` and stays.
    taken_over: u32,
    blend: u32,
    period: f64,
    clipped: u64,
}

impl Shaper {
    /// Begins at the safe values. `blend`: cycles over which the controller takes over.
    #[must_use]
    pub fn new(limits: &[AxisLimits], blend: u32, period: f64) -> Self {
        let safe: Box<[f64]> = limits.iter().map(|axis| axis.safe).collect();
        let (commands, from) = (safe.clone(), safe);
        Shaper { limits: limits.into(), commands, from, taken_over: 0, blend, period, clipped: 0 }
    }

    /// Commands as they were sent last.
    #[must_use]
    pub fn commands(&self) -> &[f64] {
        &self.commands
    }

    /// Limits of the axes.
    #[must_use]
    pub fn limits(&self) -> &[AxisLimits] {
        &self.limits
    }

    /// Cycles times axes in which the controller wanted more than it may.
    #[must_use]
    pub fn clipped(&self) -> u64 {
        self.clipped
    }

    /// Whether all commands are at their safe values.
    #[must_use]
    pub fn at_rest(&self) -> bool {
        self.commands.iter().zip(&self.limits).all(|(command, axis)| *command == axis.safe)
    }

    /// The controller takes over from the present commands.
    pub fn take_over(&mut self) {
        self.from.copy_from_slice(&self.commands);
        self.taken_over = 0;
    }

    /// The commands of one cycle that the state machine allows. `wanted` must be finite while the
    /// controller drives.
    pub fn shape(&mut self, state: State, wanted: &[f64]) -> &[f64] {
        let drives = state.drives();
        if drives && self.taken_over < self.blend {
            self.taken_over += 1;
        }
        let weight = match self.blend {
            0 => 1.0,
            blend => smooth(f64::from(self.taken_over) / f64::from(blend)),
        };
        for (index, axis) in self.limits.iter().enumerate() {
            let now = self.commands[index];
            let (target, rate) = if drives {
                let blended = self.from[index] + weight * (wanted[index] - self.from[index]);
                // At full weight the controller's own bits.
                (if weight == 1.0 { wanted[index] } else { blended }, axis.command_rate)
            } else {
                (axis.safe, axis.safe_rate)
            };
            let [least, greatest] = axis.command;
            let most = rate * self.period;
            let slewed = if (target - now).abs() <= most {
                target
            } else {
                now + most.copysign(target - now)
            };
            let allowed = slewed.max(least).min(greatest);
            self.clipped += u64::from(drives && allowed != target);
            self.commands[index] = allowed;
        }
        &self.commands
    }
}

/// From 0 to 1 without a jump in value or slope.
pub(crate) fn smooth(x: f64) -> f64 {
    if x >= 1.0 { 1.0 } else { x * x * (3.0 - 2.0 * x) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn limits() -> AxisLimits {
        AxisLimits {
            command: [0.0, 100.0],
            command_rate: 5000.0,
            safe: 10.0,
            safe_rate: 2000.0,
            ..AxisLimits::default()
        }
    }

    #[test]
    fn it_takes_over_without_a_bump() {
        let free = AxisLimits { command_rate: f64::INFINITY, ..limits() };
        let mut shaper = Shaper::new(&[free], 100, 1e-3);
        shaper.take_over();
        let mut before = 10.0;
        for _ in 0..100 {
            let now = shaper.shape(State::Running, &[80.0])[0];
            // The steepest slope of the blend is 1.5 times the mean.
            assert!(now - before <= 1.5 * 70.0 / 100.0 + 1e-9 && now >= before, "{before} {now}");
            before = now;
        }
        assert_eq!(before, 80.0);
    }

    #[test]
    fn it_ramps_to_the_safe_value_and_stays() {
        let mut shaper = Shaper::new(&[limits()], 0, 1e-3);
        for _ in 0..100 {
            shaper.shape(State::Running, &[60.0]);
        }
        for k in 1..=25 {
            let expected = 60.0 - 2.0 * f64::from(k);
            assert_eq!(shaper.shape(State::Fault, &[f64::NAN]), [expected]);
            assert_eq!(shaper.at_rest(), k == 25);
        }
        assert_eq!(shaper.shape(State::Safe, &[90.0]), [10.0]);
    }

    proptest! {
        #[test]
        fn whatever_the_controller_wants_the_limits_hold(
            all in prop::collection::vec((0usize..6, -1e6f64..1e6), 1..200), blend in 0u32..20,
        ) {
            let mut shaper = Shaper::new(&[limits()], blend, 1e-3);
            let mut before = 10.0;
            for (state, wanted) in all {
                let now = shaper.shape(State::ALL[state], &[wanted])[0];
                prop_assert!((0.0..=100.0).contains(&now));
                prop_assert!((now - before).abs() <= 5.0 + 1e-9);
                before = now;
            }
        }
    }
}
