//! The answer in one sentence.

use crate::gap::{Gap, NamedEffect, OutputGap, Shrink, Tried, Verdict};
use crate::thresholds::answer::Thresholds;

/// The one effect that no model foretells.
const NOISE: &str = components::effects::SENSOR_NOISE.name;

fn number(value: f64) -> String {
    report::format_number(value, 4)
}

/// With its unit, where it has one.
fn amount(value: f64, unit: &str) -> String {
    if unit == "1" { number(value) } else { format!("{} {unit}", number(value)) }
}

/// In whole percent; nothing is 0, not −0.
fn percent(part: f64) -> f64 {
    (100.0 * part).round() + 0.0
}

/// The low end of an interval of fractions, in percent: a repair that doubles the error or more is worth no number.
pub(crate) fn at_least(part: f64) -> String {
    if part < -1.0 { "less than -100".to_owned() } else { format!("{:.0}", percent(part)) }
}

pub(crate) fn of(gap: &Gap) -> String {
    let s = &gap.shrink;
    let output = &gap.place.output;
    let (before, floor) = (amount(s.rms_before, &s.unit), amount(s.noise_floor, &s.unit));
    match gap.verdict {
        Verdict::Adequate => format!(
            "The model is adequate: on held-out rows {output} is off by {before} rms, the noise is {floor}."
        ),
        Verdict::Retune => format!(
            "Only parameters are off: re-tuned within their tolerance the model leaves {before} rms of {output} (as given {}), the noise is {floor}.",
            amount(s.rms_as_given, &s.unit)
        ),
        Verdict::InsufficientExcitation => format!(
            "These logs are not sufficient: the command hardly moves {output} above its noise of {floor}."
        ),
        Verdict::Unknown => unknown(gap, output, s, gap.place.input_driven),
        Verdict::Effects => effects(gap),
    }
}

/// An output whose gap no candidate explains.
fn unknown(gap: &Gap, output: &str, s: &Shrink, input_driven: Option<bool>) -> String {
    format!(
        "Something is missing that none of the candidates explains: {output} is off by {} rms where the noise is {}{}{}.",
        amount(s.rms_before, &s.unit),
        amount(s.noise_floor, &s.unit),
        match input_driven {
            Some(true) => ", and it follows the command",
            Some(false) => ", and it does not follow the command",
            None => "",
        },
        partial(gap, output)
    )
}

/// The best partial answer for an output, which is no name.
fn partial(gap: &Gap, output: &str) -> String {
    let Some(p) = gap.partial.iter().find(|p| p.effect.output == output) else {
        return "; no candidate alone removes any of it on held-out rows".to_owned();
    };
    if let Some(own) = p.own_course {
        return format!(
            "; the best single candidate is {}: {}, so that it may be something else",
            name(&p.effect),
            own_drift(own)
        );
    }
    let is_own = |t: &&Tried| t.effect == p.effect.effect && t.output == output;
    let tried = gap.candidates.iter().find(is_own);
    // Of what was fitted nothing else is left out.
    let at_bound = tried.is_some_and(|t| t.left_out.is_some());
    let (but, may_be) = match at_bound {
        true => ("its fit ends at a bound of what the effect can be, and ", "is probably"),
        false => ("", "may be"),
    };
    format!(
        "; the best single candidate is {}: {but}it would remove {:.0} % of the gap's power on held-out rows and leave {} rms, so that it {may_be} something else",
        name(&p.effect),
        percent(p.effect.explained),
        amount(p.rms_after, &p.unit)
    )
}

/// The part of the gap's power that a drift without a formula takes, and what that means.
pub(crate) fn own_drift(part: f64) -> String {
    format!(
        "{:.0} % of the gap's power on held-out rows is a drift that the rows around each row show and no model predicts",
        percent(part)
    )
}

/// What is named, what adding it does to the output with the largest gap that has a name, and the outputs of which
/// nothing is explained.
fn effects(gap: &Gap) -> String {
    let named_outputs = gap.outputs.iter().filter(|o| o.verdict == Verdict::Effects);
    let over_noise = |o: &OutputGap| o.shrink.rms_before / o.shrink.noise_floor;
    let is_main = |o: &OutputGap| o.output == gap.place.output;
    let first = named_outputs
        .max_by(|a, b| is_main(a).cmp(&is_main(b)).then(over_noise(a).total_cmp(&over_noise(b))));
    let (output, s) = first.map_or((&gap.place.output, &gap.shrink), |o| (&o.output, &o.shrink));
    let unexplained = gap.outputs.iter().filter(|o| o.verdict == Verdict::Unknown);
    let others = unexplained.map(|o| format!(" {}", unknown(gap, &o.output, &o.shrink, None)));
    let own = match gap.effects.iter().all(|e| e.effect == NOISE) {
        true => format!(
            "The readings are noisier than stated, and nothing else is missing (sensor noise): {output} is off by {} rms that no model predicts; the noise was given as {}.",
            amount(s.rms_before, &s.unit),
            amount(s.noise_floor, &s.unit)
        ),
        false => named(gap, output, s),
    };
    own + &others.collect::<String>()
}

fn named(gap: &Gap, of: &str, s: &Shrink) -> String {
    let missing = match &gap.by_output()[..] {
        [(output, own)] if *output == of && gap.place.output == of => listed(own),
        several => {
            let all = several.iter().map(|(output, own)| format!("{} in {output}", listed(own)));
            all.collect::<Vec<_>>().join("; ")
        }
    };
    // Nothing else is named beside it.
    if let Some(own) = s.own_course {
        return format!(
            "The model lacks {missing}: {}; {} stays off by {} rms, the noise is {}.",
            own_drift(own),
            of,
            amount(s.rms_before, &s.unit),
            amount(s.noise_floor, &s.unit)
        );
    }
    let how = match (s.fraction, s.ci95) {
        (Some(f), Some([low, high])) => {
            // One record does not show how records of another kind differ.
            let of = if s.holdout.len() == 1 { " for a record like this one" } else { "" };
            let interval = format!("95 %{of}: {} to {:.0} %", at_least(low), percent(high));
            match s.as_found.filter(|found| found - f > Thresholds::REPAIR_LOSS) {
                None => format!(
                    "removes {:.0} % of the gap's power on held-out rows ({interval})",
                    percent(f)
                ),
                Some(found) => format!(
                    "removes {:.0} % of the gap's power on held-out rows, {:.0} % with the repaired \
                     blueprint, whose components do not hold all of it ({interval})",
                    percent(found),
                    percent(f)
                ),
            }
        }
        _ => "shrinks the gap".to_owned(),
    };
    format!(
        "The model lacks {missing}: adding {} {how}, from {} to {} rms of {}; the noise is {}.",
        if gap.effects.len() > 1 { "them" } else { "it" },
        number(s.rms_before),
        amount(s.rms_after, &s.unit),
        of,
        amount(s.noise_floor, &s.unit)
    )
}

fn listed(effects: &[&NamedEffect]) -> String {
    let names: Vec<String> = effects.iter().map(|effect| name(effect)).collect();
    match names.split_last() {
        None => String::new(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
    }
}

/// Names of effects in words, one and the other.
pub(crate) fn together<'n>(names: impl IntoIterator<Item = &'n str>) -> String {
    names.into_iter().map(|n| n.replace('_', " ")).collect::<Vec<_>>().join(" and ")
}

fn name(e: &NamedEffect) -> String {
    let what = if e.set.len() > 1 {
        e.set.iter().map(|n| n.replace('_', " ")).collect::<Vec<_>>().join(" or ")
    } else {
        e.effect.replace('_', " ")
    };
    let also = match e.also.as_slice() {
        [] => String::new(),
        others => format!(", also in {}", others.join(", ")),
    };
    format!("{what} ({}, {:.0} %{also})", e.stage, 100.0 * e.probability)
}
