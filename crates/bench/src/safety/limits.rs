//! What one axis may do.

/// Limits of one axis. A limit that is not set is infinite. Units are those of the FMU's variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisLimits {
    /// Least and greatest command.
    pub command: [f64; 2],
    /// Fastest change of the command, per second; the command is slewed to it.
    pub command_rate: f64,
    /// Least and greatest position.
    pub position: [f64; 2],
    /// Fastest change of the position between two samples, per second.
    pub position_rate: f64,
    /// Greatest distance of position and reference.
    pub tracking_error: f64,
    /// Command of the safe state.
    pub safe: f64,
    /// How fast the command goes to the safe value, per second.
    pub safe_rate: f64,
}

impl Default for AxisLimits {
    fn default() -> Self {
        AxisLimits {
            command: [f64::NEG_INFINITY, f64::INFINITY],
            command_rate: f64::INFINITY,
            position: [f64::NEG_INFINITY, f64::INFINITY],
            position_rate: f64::INFINITY,
            tracking_error: f64::INFINITY,
            safe: 0.0,
            safe_rate: f64::INFINITY,
        }
    }
}

/// What is watched over all axes, in cycles. 0 switches a watch off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Watch {
    /// Cycles without a good sample over which the controller drives on.
    pub hold: u32,
    /// Greatest age of a sample, in cycles.
    pub max_age: u32,
    /// Cycles in a row with too great a tracking error.
    pub tracking: u32,
    /// Cycles in a row in which a position has the same bits while its command moves.
    pub stuck: u32,
    /// Cycles in a row in which a command is at its limit.
    pub saturated: u32,
    /// Cycles that the runner may miss in one go.
    pub overrun: u32,
}

impl Default for Watch {
    fn default() -> Self {
        Watch { hold: 5, max_age: 3, tracking: 1, stuck: 0, saturated: 0, overrun: 0 }
    }
}
