//! The known word that somebody probably meant.

/// The word of `known` with the smallest edit distance to `word`, if it is close enough to be a
/// slip: at most a third of the word's letters (at least one, not all) differ, upper and lower case aside. Where none is,
/// an index that is missing is no difference: `positon` is near `position[1]`.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let known: Vec<&str> = known.into_iter().collect();
    let stem = |name: &'a str| name.split_once('[').map_or(name, |(stem, _)| stem);
    nearest_by(word, &known, |name| name).or_else(|| nearest_by(word, &known, stem))
}

fn nearest_by<'a>(
    word: &str,
    known: &[&'a str],
    part: impl Fn(&'a str) -> &'a str,
) -> Option<&'a str> {
    let lower = word.to_lowercase();
    let letters = lower.chars().count();
    let most = (letters / 3).max(1).min(letters.saturating_sub(1));
    known
        .iter()
        .map(|candidate| (distance(&lower, &part(candidate).to_lowercase()), *candidate))
        .filter(|(distance, _)| *distance <= most)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// Edit distance where a swap of neighbours counts as one (optimal string alignment).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut row = vec![i + 1];
        for (j, y) in b.iter().enumerate() {
            let mut least = (last[j] + usize::from(x != y)).min(last[j + 1] + 1).min(row[j] + 1);
            if i > 0 && j > 0 && *x == b[j - 1] && a[i - 1] == *y {
                least = least.min(before[j - 1] + 1);
            }
            row.push(least);
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

/// `did you mean "w"? `, or nothing.
pub(crate) fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map_or_else(String::new, |near| format!("did you mean \"{near}\"? "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_slips_and_only_slips() {
        assert_eq!(nearest("freqency", ["frequency", "damping"]), Some("frequency"));
        assert_eq!(nearest("Gian", ["gain", "frequency"]), Some("gain"));
        assert_eq!(nearest("W", ["w", "r"]), Some("w"));
        assert_eq!(nearest("temperature", ["gain", "frequency"]), None);
        assert_eq!(nearest("positon", ["command[1]", "position[1]"]), Some("position[1]"));
        assert_eq!(nearest("x", []), None);
        assert_eq!(nearest("x", ["u", "y"]), None);
    }

    #[test]
    fn distances_of_known_pairs() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("ab", "ba"), 1);
        assert_eq!(distance("", "abc"), 3);
    }
}
