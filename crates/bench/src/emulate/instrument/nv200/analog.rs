//! The analog input of the emulated NV200, and the limit of the slew rate of its set points.

use super::Nv200Instrument;

/// Set points come from the analog input.
pub(super) const ANALOG: u8 = 1;
/// Volts at the upper end of the range.
const FULL: f64 = 10.0;
/// The lowest limit of the slew rate in %/ms, and the one that is none.
pub(super) const SLOWEST: f64 = 8e-7;
pub(super) const NO_LIMIT: f64 = 2000.0;

impl Nv200Instrument {
    /// Leads the set point to where the analog input, or a slow command, wants it.
    pub(super) fn lead(&mut self) {
        let (travel, is_closed) = (self.stage.travel[0], self.stage.axes[0].servo);
        let [least, greatest] = match (is_closed, travel.volts) {
            (true, _) => travel.range(),
            (false, [a, b]) => [a.min(b), a.max(b)],
        };
        let wanted = match self.source {
            ANALOG => {
                let volts = if self.analog { self.stage.analog_volts(0) } else { 0.0 };
                Some(least + (volts / FULL).clamp(0.0, 1.0) * (greatest - least))
            }
            _ => self.wanted,
        };
        let Some(wanted) = wanted else { return };
        // %/ms in a step.
        let most = 10.0 * self.slew * self.stage.period() * (greatest - least);
        let axis = &mut self.stage.axes[0];
        let now = if is_closed { &mut axis.target } else { &mut axis.volts };
        let way = wanted - *now;
        if self.slew < NO_LIMIT && way.abs() > most {
            *now += most.copysign(way);
        } else {
            (*now, self.wanted) = (wanted, None);
        }
    }
}
