//! Rules that several signals share.

use crate::parameter::{FREQUENCY, HIGH, LOW, Parameter, RISE};
use crate::signal_type::{Rule, Settings};

/// Lowest frequency of a band.
pub(crate) const LOWEST: Parameter =
    Parameter::real("lowest_frequency", "Hz", "Lower end of the band.", [1.0, 1e-6, 1e6]);

/// Highest frequency of a band.
pub(crate) const HIGHEST: Parameter =
    Parameter::real("highest_frequency", "Hz", "Upper end of the band.", [100.0, 1e-6, 1e6]);

/// The limits in order.
pub(crate) const LOW_BELOW_HIGH: Rule = Rule {
    parameter: "low",
    text: "must lie below high; lower low or raise high",
    holds: |s| s.get(&LOW) < s.get(&HIGH),
};

/// A frequency that the grid can carry.
pub(crate) const FREQUENCY_BELOW_NYQUIST: Rule = Rule {
    parameter: "frequency",
    text: "must not exceed half the sample rate, 1/(2·sample_time); lower it or sample faster",
    holds: |s| carried(s, &FREQUENCY),
};

/// The band's ends in order.
pub(crate) const BAND_IN_ORDER: Rule = Rule {
    parameter: "lowest_frequency",
    text: "must not exceed highest_frequency; lower it or raise highest_frequency",
    holds: |s| s.get(&LOWEST) <= s.get(&HIGHEST),
};

/// A band that the grid can carry.
pub(crate) const BAND_BELOW_NYQUIST: Rule = Rule {
    parameter: "highest_frequency",
    text: "must not exceed half the sample rate, 1/(2·sample_time); lower it or sample faster",
    holds: |s| carried(s, &HIGHEST),
};

/// A change of level that ends within its hold.
pub(crate) const fn rise_within(text: &'static str, holds: fn(&Settings) -> bool) -> Rule {
    Rule { parameter: RISE.name, text, holds }
}

/// Whether the grid carries a frequency; half the sample rate itself is allowed, up to rounding.
pub(crate) fn carried(settings: &Settings, frequency: &Parameter) -> bool {
    settings.get(frequency) * settings.sample_time() <= 0.5 * (1.0 + 1e-12)
}
