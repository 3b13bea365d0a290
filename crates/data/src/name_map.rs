//! Which column of a log belongs to which variable of a model.

use std::collections::BTreeMap;

use crate::Problem;

/// Pairs of a variable and a column, as `--map FMU_NAME=COLUMN` gives them. A variable that is not
/// in the map has the column of its own name, or of its short name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NameMap {
    columns: BTreeMap<String, String>,
}

impl NameMap {
    /// Reads pairs, each as `command[1]=u1`.
    ///
    /// # Errors
    /// Each pair that has no `=` or an empty side, and each variable that is named twice.
    pub fn parse<S: AsRef<str>>(pairs: &[S]) -> Result<Self, crate::Problems> {
        let mut map = Self::default();
        let mut problems = Vec::new();
        for pair in pairs.iter().map(AsRef::as_ref) {
            let halves = pair.split_once('=').map(|(name, column)| (name.trim(), column.trim()));
            let problem = |rule: &str, way_out: &str| {
                Problem::new("--map", rule, way_out).value(format!("\"{pair}\""))
            };
            match halves {
                Some((name, column)) if !name.is_empty() && !column.is_empty() => {
                    if map.columns.insert(name.into(), column.into()).is_some() {
                        let way_out = "give each variable one column";
                        problems.push(problem("the variable has a column already", way_out));
                    }
                }
                _ => {
                    let way_out = "write VARIABLE=COLUMN, as in command[1]=u1";
                    problems.push(problem("does not name a variable and a column", way_out));
                }
            }
        }
        if problems.is_empty() { Ok(map) } else { Err(crate::Problems::new(problems)) }
    }

    /// The column that was named for this variable.
    #[must_use]
    pub fn column(&self, variable: &str) -> Option<&str> {
        self.columns.get(variable).map(String::as_str)
    }

    /// All pairs, variable and column, by variable.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.columns.iter().map(|(name, column)| (name.as_str(), column.as_str()))
    }

    /// Whether no pair was given.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_pairs() {
        let map = NameMap::parse(&["command[1]=u1", " y = position "]).unwrap();
        assert_eq!(map.column("command[1]"), Some("u1"));
        assert_eq!(map.column("y"), Some("position"));
        assert_eq!(map.column("u1"), None);
        assert_eq!(map.iter().count(), 2);
    }

    #[test]
    fn reports_every_bad_pair() {
        let problems = NameMap::parse(&["u", "=y", "u=", "a=b", "a=c"]).unwrap_err();
        assert_eq!(problems.as_slice().len(), 4);
        let text = problems.to_string();
        assert!(text.contains("--map: \"u\": does not name a variable and a column"), "{text}");
        assert!(text.contains("--map: \"a=c\": the variable has a column already"), "{text}");
    }
}
