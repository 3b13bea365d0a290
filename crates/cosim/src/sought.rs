//! A parameter to find, as a command line asks for it.

/// `NAME[=START[,LOW..HIGH]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sought {
    /// Name of the variable.
    pub name: String,
    /// Value to begin with; none: the FMU's.
    pub start: Option<f64>,
    /// Least and greatest value.
    pub bounds: Option<(f64, f64)>,
}

impl Sought {
    /// Reads it.
    ///
    /// # Errors
    /// A sentence: what is missing, or is no finite number.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (name, rest) = match text.split_once('=') {
            Some((name, rest)) => (name, Some(rest)),
            None => (text, None),
        };
        let name = name.trim().to_owned();
        if name.is_empty() {
            return Err("no parameter is named; write NAME or NAME=START".to_owned());
        }
        let Some(rest) = rest else { return Ok(Self { name, start: None, bounds: None }) };
        let (start, bounds) = match rest.split_once(',') {
            Some((start, bounds)) => (start, Some(bounds)),
            None => (rest, None),
        };
        let start = Some(number(start)?);
        let Some(bounds) = bounds else { return Ok(Self { name, start, bounds: None }) };
        let Some((low, high)) = bounds.split_once("..") else {
            return Err("write bounds as LOW..HIGH, as in mass=0.2,0.1..0.5".to_owned());
        };
        Ok(Self { name, start, bounds: Some((number(low)?, number(high)?)) })
    }
}

fn number(part: &str) -> Result<f64, String> {
    let number = part.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| {
        format!("\"{part}\" is no finite number; write NAME=START or NAME=START,LOW..HIGH")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_and_bounds_may_be_left_out() {
        let sought =
            |name: &str, start, bounds| Ok(Sought { name: name.to_owned(), start, bounds });
        assert_eq!(Sought::parse("mass"), sought("mass", None, None));
        assert_eq!(Sought::parse(" A[1,2] = 2e-3"), sought("A[1,2]", Some(2e-3), None));
        let bounds = Some((-1.0, 1.0));
        assert_eq!(Sought::parse("k=0.5, -1 .. 1"), sought("k", Some(0.5), bounds));
        for bad in ["", "=1", "k=", "k=nan", "k=1,2", "k=1,2..", "k=1,-inf..2", "k=1,1..2..3"] {
            assert!(Sought::parse(bad).is_err(), "{bad}");
        }
    }
}
