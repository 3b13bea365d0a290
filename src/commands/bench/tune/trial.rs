//! A proposed law is written and measured, and taken back where it is not better.

use bench::gateway::station::{self, Law, Station};

use super::experiment::{Bed, Loop};
use super::{Measured, Tune, Tuned};

/// Parts of the proposed gains that are tried one after the other until the step does not overshoot too far.
const GENTLER: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// Part of the amplification of noise that a second proposal is allowed, where no part of the first one is kept: a law that
/// answers a step less abruptly.
pub(super) const CALMER: f64 = 0.1;
/// Times that are waited until such an axis has come to rest, at most.
const RESTS: usize = 4;

/// Why a loop is not kept.
pub(super) struct Refusal {
    pub(super) why: String,
    is_wild: bool,
}

/// A new loop as it was measured, if it was measured whole, and why it is not kept.
pub(super) type Tried = (Option<Measured>, Option<Refusal>);

impl Tune {
    /// Writes the proposed law and measures it, first with a tenth of the reference; why the old one was restored, if it was.
    pub(super) fn try_law(
        &self,
        station: &mut dyn Station,
        bed: &Bed,
        answer: &Tuned,
        is_again: bool,
    ) -> anyhow::Result<Tried> {
        let old = &answer.before;
        let mut attempt = || -> Result<Tried, String> {
            let mut last = (None, None);
            for part in GENTLER {
                last = self.try_part(station, bed, answer, (part, is_again || part < 1.0))?;
                // Smaller gains help a loop that went wrong at once or overshoots, not one that is too slow.
                if !is_wild(&last) {
                    break;
                }
            }
            Ok(last)
        };
        let tried = attempt();
        if !matches!(&tried, Ok((_, None))) {
            station.set_law(&old.law).map_err(|error| {
                anyhow::anyhow!(
                    "the values are no better, and the old ones cannot be restored: {error}"
                )
            })?;
        }
        tried.map_err(anyhow::Error::msg)
    }

    /// Writes the proposed law with this part of its gains and measures it; why it is not kept.
    fn try_part(
        &self,
        station: &mut dyn Station,
        bed: &Bed,
        answer: &Tuned,
        (part, rests): (f64, bool),
    ) -> Result<Tried, String> {
        let (law, old) = (&answer.proposed, &answer.before.found);
        station.set_law(&with_part(law, part))?;
        if rests {
            come_to_rest(station, bed)?;
        }
        let (small, _) = bed.measure(station, 0.1)?;
        if let Some(mut refusal) = self.refusal(&small, old) {
            refusal.why.insert_str(0, "with a tenth of the signals ");
            refusal.is_wild = true;
            return Ok((None, Some(refusal)));
        }
        let (found, _) = bed.measure(station, 1.0)?;
        let why = self.refusal(&found, old);
        Ok((Some(Measured { law: station.law()?, found }), why))
    }

    /// Why a loop is not kept; none: it is better than the old one.
    fn refusal(&self, new: &Loop, old: &Loop) -> Option<Refusal> {
        // Not a number is no better either.
        if new.rms_error.is_nan() || new.rms_error >= old.rms_error {
            return Some(Refusal { why: "the error is not smaller".to_owned(), is_wild: false });
        }
        let allowed = self.overshoot.max(old.overshoot);
        if new.overshoot <= allowed {
            return None;
        }
        // A part below 0 is told as 0: there is no overshoot.
        let percent = |part: f64| 100.0 * part.max(0.0);
        let why = format!(
            "the step overshoots by {:.1} %, more than before ({:.1} %) and than --overshoot allows ({:.1} %): give a smaller --sensitivity or --noise",
            percent(new.overshoot),
            percent(old.overshoot),
            percent(self.overshoot)
        );
        Some(Refusal { why, is_wild: true })
    }
}

/// Whether a loop went wrong at once or overshot.
pub(super) fn is_wild((_, refusal): &Tried) -> bool {
    refusal.as_ref().is_some_and(|refusal| refusal.is_wild)
}

/// The law with this part of its gains.
pub(super) fn with_part(law: &Law, part: f64) -> Law {
    Law { kp: part * law.kp, ki: part * law.ki, kd: part * law.kd, ..law.clone() }
}

/// Leads an axis that oscillated to the middle of the travel, and waits there.
pub(super) fn come_to_rest(station: &mut dyn Station, bed: &Bed) -> Result<(), String> {
    station::lead(station, true, bed.middle)?;
    for _ in 0..RESTS {
        station::settled(station, 1e-3 * bed.amplitude)?;
    }
    Ok(())
}
