//! What the answer leaves.

use crate::gap::Discrepancy;
use crate::gap::Leftover;
use crate::outcome::Outcome;
use crate::place::Maps;
use crate::score::{explained, mean_square};
use crate::thresholds::answer::Thresholds;

pub(super) fn leftover(o: &Outcome, maps: &Maps<'_>) -> Leftover {
    let over_noise =
        o.found.last.judged.held_out / o.noise_ratio.map_or(1.0, |factor| factor * factor);
    let residual = &o.found.last.judged.residual;
    let left = Maps { before: residual, after: residual, ..*maps };
    let is_there = over_noise > Thresholds::LEFT;
    Leftover {
        present: is_there,
        over_noise,
        input_driven: if is_there {
            left.is_input_driven(left.before, &left.command())
        } else {
            None
        },
        bands: if is_there { left.bands() } else { Vec::new() },
        discrepancy: is_there.then(|| discrepancy(o)).flatten(),
        looks_like: looks_like(o).filter(|_| is_there),
    }
}

/// Size and time of what is left beside the noise, where it is more than the noise.
pub(super) fn discrepancy(o: &Outcome) -> Option<Discrepancy> {
    let judged = &o.found.last.judged;
    let left = o.judge.discrepancy(judged, &o.task.data);
    // One that is slower than the records has a variance that they do not show: what stands here is in them.
    let seen = (mean_square(&judged.residual) - 1.0).max(0.0).sqrt();
    let rms = left.size.min(seen) * o.sigma / o.task.factor;
    let range = 2.0 * o.task.data.output_span.half / o.task.factor;
    (left.size > 0.0 && range > 0.0).then(|| Discrepancy {
        rms,
        of_range: rms / range,
        time: left.time,
    })
}

/// The effect that would take the largest part of what the named ones leave, on held-out rows.
pub(super) fn looks_like(o: &Outcome) -> Option<String> {
    let beyond = o.found.beyond.as_ref()?;
    let (family, _) = beyond.picks.iter().find(|pick| !o.found.last.picks.contains(pick))?;
    let part = explained(&o.found.last.judged, &beyond.judged);
    (part > Thresholds::LOOKS_LIKE).then(|| o.library[*family].effect.name.to_owned())
}
