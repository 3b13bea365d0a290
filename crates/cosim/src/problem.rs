//! What a check of settings finds. A check returns all problems.

use std::fmt;

/// One problem of the settings of a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// No slave of this name.
    #[error("there is no FMU `{name}`; there are: {there}")]
    NoSuchSlave {
        /// The name.
        name: String,
        /// The names there are.
        there: String,
    },
    /// A problem of something that stands in a file.
    #[error("{place}: {problem}")]
    At {
        /// File and line.
        place: String,
        /// What is wrong there.
        problem: Box<Problem>,
    },
    /// Two slaves of one name.
    #[error("two FMUs are called `{name}`; give one of them another name")]
    SameName {
        /// The name.
        name: String,
    },
    /// An order of steps that is not one of all slaves.
    #[error("the order of steps must name every FMU once, but `{name}` {what}")]
    Order {
        /// The name.
        name: String,
        /// What is wrong with it.
        what: &'static str,
    },
    /// Two recorded variables of one name.
    #[error("two recorded variables are called `{name}`; record one of them under another name")]
    SameColumn {
        /// The name.
        name: String,
    },
    /// No variable of this name.
    #[error("FMU `{slave}` has no variable `{variable}`{}", did_you_mean(near))]
    NoSuchVariable {
        /// Name of the FMU.
        slave: String,
        /// The name.
        variable: String,
        /// Names like it.
        near: Vec<String>,
    },
    /// No element of this place.
    #[error("array `{array}` of FMU `{slave}` has no element `{element}`: {why}")]
    NoSuchElement {
        /// Name of the FMU.
        slave: String,
        /// Name of the array.
        array: String,
        /// The name.
        element: String,
        /// What is wrong.
        why: String,
    },
    /// A variable in a role it cannot have.
    #[error("variable `{variable}` of FMU `{slave}` is {is}, but must be {must_be} to {role}")]
    WrongRole {
        /// Name of the FMU.
        slave: String,
        /// Name of the variable.
        variable: String,
        /// Causality or type it has.
        is: String,
        /// What the is must be.
        must_be: &'static str,
        /// What for.
        role: String,
    },
    /// An input with two sources.
    #[error(
        "input `{variable}` of FMU `{slave}` has two sources: {first} and {second}; \
             keep one of them"
    )]
    TwoSources {
        /// Name of the FMU.
        slave: String,
        /// Name of the input.
        variable: String,
        /// The one source.
        first: String,
        /// The other source.
        second: String,
    },
    /// Units that measure different things.
    #[error("{from} in {from_unit} cannot feed {to} in {to_unit}: {why}")]
    Units {
        /// The source.
        from: String,
        /// The from's unit.
        from_unit: String,
        /// The input.
        to: String,
        /// The to's unit.
        to_unit: String,
        /// What is wrong.
        why: String,
    },
    /// A signal that the table does not have.
    #[error(
        "there is no column `{name}` for input `{variable}` of FMU `{slave}`; \
             there are: {there}"
    )]
    NoSuchColumn {
        /// The name.
        name: String,
        /// Name of the FMU.
        slave: String,
        /// Name of the input.
        variable: String,
        /// The columns there are.
        there: String,
    },
    /// A table that is not one.
    #[error("record {record} of the input table: {what}")]
    Table {
        /// Number of the record, from 0.
        record: usize,
        /// What is wrong.
        what: String,
    },
    /// A value that cannot be given before the run.
    #[error("value {value} for variable `{variable}` of FMU `{slave}`: {why}")]
    StartValue {
        /// Name of the FMU.
        slave: String,
        /// Name of the variable.
        variable: String,
        /// The value.
        value: String,
        /// What is wrong.
        why: String,
    },
    /// A time span or step that is none.
    #[error("{0}")]
    Time(String),
    /// An FMU that needs equal steps gets unequal ones.
    #[error(
        "FMU `{slave}` takes equal communication steps only \
             (canHandleVariableCommunicationStepSize is false), but {what}"
    )]
    UnequalSteps {
        /// Name of the FMU.
        slave: String,
        /// Which step is not equal to the others.
        what: String,
    },
    /// A step of an FMU's own that does not fit.
    #[error("FMU `{slave}` steps {what}")]
    Pace {
        /// Name of the FMU.
        slave: String,
        /// What is wrong and the way out.
        what: String,
    },
    /// An algebraic loop that cannot be iterated, or settings for it that are none.
    #[error("{0}")]
    Iteration(String),
    /// Nothing can be extrapolated.
    #[error(
        "no connection can be extrapolated: the FMU that gives must state maxOutputDerivativeOrder of 1 \
         or more, the one that takes canInterpolateInputs, both of FMI 2.0 and with the communication \
         step as their own; use jacobi or gauss-seidel"
    )]
    NoSlopes,
    /// Two FMUs do not form a loop.
    #[error("{0}")]
    Loop(String),
}

fn did_you_mean(near: &[String]) -> String {
    match near {
        [] => String::new(),
        names => format!("; did you mean `{}`?", names.join("` or `")),
    }
}

impl Problem {
    /// This problem at its place, unless that is not known.
    pub(crate) fn at(self, place: &str) -> Problem {
        match (self, place) {
            (problem, "") => problem,
            (problem, place) => Problem::At { place: place.to_owned(), problem: Box::new(problem) },
        }
    }
}

/// All problems that a check found; at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct Problems(pub Vec<Problem>);

impl Problems {
    /// `value`, if there is no problem.
    pub(crate) fn none_or<T>(problems: Vec<Problem>, value: T) -> Result<T, Problems> {
        if problems.is_empty() { Ok(value) } else { Err(Problems(problems)) }
    }
}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Self {
        Problems(vec![problem])
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Of a connection that is recorded, the same is found twice, at its place and without one.
        let is_same = |earlier: &Problem, problem: &Problem| {
            earlier == problem
                || matches!(earlier, Problem::At { problem: inner, .. } if **inner == *problem)
        };
        let first = |(at, problem): &(usize, &Problem)| {
            !self.0[..*at].iter().any(|earlier| is_same(earlier, problem))
        };
        let all = self.0.iter().enumerate().filter(first);
        let texts: Vec<String> = all.map(|(_, problem)| problem.to_string()).collect();
        f.write_str(&texts.join("\n"))
    }
}

impl std::error::Error for Problems {}

/// The names most like `name`, for an error message: at most three.
pub(crate) fn nearest<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let limit = name.chars().count() / 3 + 1;
    let mut near: Vec<(usize, &str)> = names
        .map(|candidate| (edits(name, candidate), candidate))
        .filter(|(distance, _)| *distance <= limit)
        .collect();
    near.sort_unstable();
    near.into_iter().take(3).map(|(_, candidate)| candidate.to_owned()).collect()
}

/// Levenshtein distance, upper and lower case alike.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found() {
        let names = ["position[1]", "position[2]", "command[1]"];
        assert_eq!(nearest("postion[1]", names.into_iter()), ["position[1]", "position[2]"]);
        assert_eq!(nearest("x", names.into_iter()), Vec::<String>::new());
        assert_eq!(edits("kitten", "sitting"), 3);
    }
}
