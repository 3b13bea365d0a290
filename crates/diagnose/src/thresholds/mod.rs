//! The thresholds of the diagnosis, stage by stage, each with its sentence.
//!
//! `docs/diagnosis.md` states those that a user meets; a test compares the page with the values.

pub(crate) mod answer;
pub(crate) mod base;
pub(crate) mod belief;
pub(crate) mod fit;
pub(crate) mod noise;
pub(crate) mod repair;
pub(crate) mod search;

#[cfg(test)]
mod tests {
    use super::{answer, base, belief, fit, noise, search};

    /// The page in one line.
    fn page() -> String {
        let text = include_str!("../../../../docs/diagnosis.md");
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    fn in_words(number: f64) -> &'static str {
        let words = [
            (0.3, "the last 30 %"),
            (0.5, "half of the gap's power"),
            (0.8, "four fifths of the gap"),
            (0.9, "nine tenths"),
            (3.0, "three"),
            (4.0, "four"),
            (5.0, "five"),
            (6.0, "the sixth power"),
            (7.0, "seven"),
            (30.0, "thirty times"),
        ];
        words.into_iter().find(|(value, _)| *value == number).expect("a word for the number").1
    }

    #[test]
    fn the_page_states_the_thresholds_of_the_code() {
        use belief::Thresholds as Belief;
        use noise::Thresholds as Noise;
        use search::Thresholds as Search;
        let percent = |part: f64| format!("{:.0} %", 100.0 * part);
        let stated = [
            format!("below {} of the first estimate", Noise::QUIETER),
            format!("up to {} times the power of a stated noise", Noise::ADEQUATE_GIVEN),
            format!("{} times that of a record at rest", Noise::ADEQUATE_AT_REST),
            format!("and {} times that of an estimated one", Noise::ADEQUATE_ESTIMATED),
            format!("{} of each record, or `--holdout`", in_words(base::Thresholds::HELD_OUT)),
            format!("leaves less than {} of the power", base::Thresholds::READING_LESS),
            format!("with {} steps from row to row, and the reading", base::Thresholds::WITHIN_ROW),
            format!(
                "within {} of that frequency",
                percent(1.0 - 2.0 * base::Thresholds::MODE_NEAR_NYQUIST)
            ),
            format!("condition number above {}", base::Thresholds::CONDITION),
            format!("screening selects {}", in_words(Search::FAMILIES_FITTED as f64)),
            format!("or {} where an effect", in_words(Search::FAMILIES_FITTED_BESIDE as f64)),
            format!("the best {} are fitted thoroughly", in_words(Search::FAMILIES_REFINED as f64)),
            format!("explains {} and an error remains", in_words(Search::AWAY_NEAR)),
            format!(
                "from {} and {} times larger",
                Search::AWAY_FACTORS[0],
                Search::AWAY_FACTORS[2]
            ),
            format!("leaves more than {} times what it promised", Search::STUCK),
            format!(
                "values {:.0}, {:.0} and {} off",
                100.0 * Search::RELEASED_SHIFTS[1],
                100.0 * Search::RELEASED_SHIFTS[3],
                percent(Search::RELEASED_SHIFTS[5])
            ),
            format!(
                "{} to {} times the model's in steps of {}",
                Search::RESONANCE_RANGE[0],
                Search::RESONANCE_RANGE[1],
                percent(Search::RESONANCE_STEP - 1.0)
            ),
            format!("the {} places", in_words(Search::RESONANCE_STARTS as f64)),
            format!("explain {}", in_words(Belief::POWER)),
            format!("a score of {} over the frequency bands", Belief::SCORE),
            format!(
                "with {} of the power a score of {}",
                in_words(Belief::POWER_CLEAR),
                Belief::SCORE_WITH_POWER
            ),
            format!("at most {} the error", in_words(Belief::OUT_OF_REACH)),
            format!("best {} single effects", in_words(Belief::PAIR_RIVALS as f64 + 1.0)),
            format!(
                "by at least {} and removes at least {}",
                Belief::CUT,
                percent(Belief::FURTHER.0)
            ),
            format!("adds {} to the score", Belief::FURTHER.1),
            format!("must divide the error by {}", Belief::CUT_TO_NOISE),
            format!("less than the noise's power (by {})", Belief::CUT_SHARPLY),
            format!("explains {} of what two leave", in_words(Belief::THIRD_TAKES)),
            format!("costs less than {} of score and power", Belief::DROPPED),
            format!("fall with {} of", in_words(Belief::SHARPNESS)),
            format!("predicts each 1/{} of a record", Belief::CAUSED_BLOCKS),
            format!("agree within a factor of {}", Belief::ALIKE),
            format!("probabilities sum to {}", percent(Belief::SET)),
            format!(
                "removes {} of the power with at most {} coefficients",
                in_words(Belief::FITTED_WELL.0),
                Belief::FITTED_WELL.1
            ),
            format!(
                "of it, at least {}, and is not named",
                percent(answer::Thresholds::LOOKS_LIKE)
            ),
            format!(
                "a probability of at most {}, and a group {}",
                percent(Belief::LIBRARY),
                percent(Belief::LIBRARY_OF_GROUPS)
            ),
            format!("must explain at least {} of it", percent(Belief::POWER_OF_OWN)),
        ];
        let page = page();
        for sentence in stated {
            assert!(page.contains(&sentence), "docs/diagnosis.md does not say: {sentence}");
        }
        // "about five": exp(1.6); "three times the largest later block": of effective values; "about an eighth".
        assert_eq!(Belief::ORDER.exp().round(), 5.0);
        assert_eq!(base::Thresholds::RUN_IN_STANDS_OUT.sqrt(), 3.0);
        assert_eq!((1.0 / Belief::LEFT_OF_UNKNOWN).round(), 8.0);
        // "Less than ten times the noise's power is faint".
        assert_eq!(Belief::FAINT, 10.0);
        assert_eq!((fit::Thresholds::MANY_TUNED, fit::Thresholds::FAR), (8, 3.0));
    }
}
