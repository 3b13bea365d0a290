//! Formulas of conversions, as in `2*X1 + sin(X1)^2`.
//!
//! Source: ASAM MDF 4.2, section 5.17.5, and the General Expression Syntax 1.0, of which numbers,
//! the variable, arithmetic and functions are read. A formula is parsed once and bounded in its length, so
//! that its cost for each value is bounded.

/// Most operations of a formula; those of instruments have some ten.
const MOST: usize = 1000;
/// Longest formula, in bytes.
pub(super) const LONGEST: usize = 100 * MOST;
/// Deepest bracket.
const DEEPEST: usize = 64;

/// A formula in the order in which it is computed.
#[derive(Debug)]
pub(super) struct Formula {
    steps: Vec<Step>,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Number(f64),
    Variable,
    One(OfOne),
    Two(OfTwo),
}

type OfOne = fn(f64) -> f64;
type OfTwo = fn(f64, f64) -> f64;

const FUNCTIONS: [(&str, OfOne); 22] = [
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("arcsin", f64::asin),
    ("arccos", f64::acos),
    ("arctan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("exp", f64::exp),
    ("log", f64::ln),
    ("ln", f64::ln),
    ("log10", f64::log10),
    ("abs", f64::abs),
    ("sqrt", f64::sqrt),
    ("floor", f64::floor),
    ("ceil", f64::ceil),
    ("round", f64::round),
    ("int", f64::trunc),
];

const FUNCTIONS_OF_TWO: [(&str, OfTwo); 5] = [
    ("pow", f64::powf),
    ("power", f64::powf),
    ("min", f64::min),
    ("max", f64::max),
    ("fmod", |left, right| left % right),
];

impl Formula {
    /// Reads a formula; the error says what cannot be read.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!("it has more than {LONGEST} characters"));
        }
        let mut parser = Parser { rest: text.as_bytes(), steps: Vec::new() };
        parser.sum(0)?;
        match parser.peek() {
            None => Ok(Self { steps: parser.steps }),
            Some(other) => Err(format!("\"{}\" is not expected", char::from(other))),
        }
    }

    /// The formula's value at x.
    pub(super) fn value(&self, x: f64) -> f64 {
        let mut stack = Vec::with_capacity(DEEPEST);
        for step in &self.steps {
            let value = match step {
                Step::Number(value) => Some(*value),
                Step::Variable => Some(x),
                Step::One(function) => stack.pop().map(function),
                Step::Two(function) => {
                    stack.pop().and_then(|right| Some(function(stack.pop()?, right)))
                }
            };
            stack.extend(value);
        }
        stack.pop().unwrap_or(f64::NAN)
    }
}

struct Parser<'a> {
    rest: &'a [u8],
    steps: Vec<Step>,
}

impl Parser<'_> {
    fn peek(&mut self) -> Option<u8> {
        self.rest = self.rest.trim_ascii_start();
        self.rest.first().copied()
    }

    fn take(&mut self, text: &str) -> bool {
        self.peek();
        let rest = self.rest.strip_prefix(text.as_bytes());
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn expect(&mut self, text: &str) -> Result<(), String> {
        let found = self.take(text);
        found.then_some(()).ok_or_else(|| format!("\"{text}\" is missing"))
    }

    fn push(&mut self, step: Step) -> Result<(), String> {
        self.steps.push(step);
        match self.steps.len() > MOST {
            true => Err(format!("it has more than {MOST} operations")),
            false => Ok(()),
        }
    }

    fn sum(&mut self, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(format!("it has brackets in brackets, deeper than {DEEPEST}"));
        }
        self.product(depth)?;
        loop {
            if self.take("+") {
                self.product(depth)?;
                self.push(Step::Two(|left, right| left + right))?;
            } else if self.take("-") {
                self.product(depth)?;
                self.push(Step::Two(|left, right| left - right))?;
            } else {
                return Ok(());
            }
        }
    }

    fn product(&mut self, depth: usize) -> Result<(), String> {
        self.signed(depth)?;
        loop {
            if self.take("*") {
                self.signed(depth)?;
                self.push(Step::Two(|left, right| left * right))?;
            } else if self.take("/") {
                self.signed(depth)?;
                self.push(Step::Two(|left, right| left / right))?;
            } else if self.take("%") {
                self.signed(depth)?;
                self.push(Step::Two(|left, right| left % right))?;
            } else {
                return Ok(());
            }
        }
    }

    /// A power binds stronger than the sign before it.
    fn signed(&mut self, depth: usize) -> Result<(), String> {
        let mut is_negative = false;
        loop {
            if self.take("-") {
                is_negative = !is_negative;
            } else if !self.take("+") {
                break;
            }
        }
        self.atom(depth)?;
        if self.take("**") || self.take("^") {
            if depth > DEEPEST {
                return Err("it has too many powers of powers".into());
            }
            self.signed(depth + 1)?;
            self.push(Step::Two(f64::powf))?;
        }
        if is_negative {
            self.push(Step::One(|value| -value))?;
        }
        Ok(())
    }

    fn atom(&mut self, depth: usize) -> Result<(), String> {
        let next = self.peek().ok_or("it ends too early")?;
        match next {
            b'(' => {
                self.take("(");
                self.sum(depth + 1)?;
                self.expect(")")
            }
            b'0'..=b'9' | b'.' => self.number(),
            b'a'..=b'z' | b'A'..=b'Z' | b'_' => self.word(depth),
            other => Err(format!("\"{}\" is not expected", char::from(other))),
        }
    }

    fn number(&mut self) -> Result<(), String> {
        let digits = |bytes: &[u8]| bytes.iter().take_while(|b| b.is_ascii_digit()).count();
        let mut length = digits(self.rest);
        if self.rest.get(length) == Some(&b'.') {
            length += 1 + digits(&self.rest[length + 1..]);
        }
        if let Some(b'e' | b'E') = self.rest.get(length) {
            let signs = usize::from(matches!(self.rest.get(length + 1), Some(b'+' | b'-')));
            let exponent = digits(self.rest.get(length + 1 + signs..).unwrap_or_default());
            length += if exponent > 0 { 1 + signs + exponent } else { 0 };
        }
        let (number, rest) = self.rest.split_at(length);
        let text = String::from_utf8_lossy(number);
        let number = text.parse().map_err(|_| format!("\"{text}\" is no number"))?;
        self.rest = rest;
        self.push(Step::Number(number))
    }

    fn word(&mut self, depth: usize) -> Result<(), String> {
        let is_letter = |byte: &&u8| byte.is_ascii_alphanumeric() || **byte == b'_';
        let length = self.rest.iter().take_while(is_letter).count();
        let (word, rest) = self.rest.split_at(length);
        let word = String::from_utf8_lossy(word).to_lowercase();
        self.rest = rest;
        if !self.take("(") {
            return match word.as_str() {
                "x" | "x1" => self.push(Step::Variable),
                "pi" => self.push(Step::Number(std::f64::consts::PI)),
                _ => Err(format!("\"{word}\" is not known")),
            };
        }
        self.sum(depth + 1)?;
        let one = FUNCTIONS.iter().find(|(name, _)| *name == word);
        let two = FUNCTIONS_OF_TWO.iter().find(|(name, _)| *name == word);
        match (one, two) {
            (Some((_, function)), _) => self.push(Step::One(*function))?,
            (_, Some((_, function))) => {
                self.expect(",")?;
                self.sum(depth + 1)?;
                self.push(Step::Two(*function))?;
            }
            _ => return Err(format!("the function \"{word}\" is not known")),
        }
        self.expect(")")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str, x: f64) -> f64 {
        Formula::parse(text).unwrap_or_else(|why| panic!("{text}: {why}")).value(x)
    }

    #[test]
    fn formulas_have_the_usual_values() {
        for (text, expected) in [
            ("X", 3.0),
            ("2*X1 + 1", 7.0),
            ("-X^2", -9.0),
            ("2^3^2", 512.0),
            ("2**-1", 0.5),
            ("(X + 1) * (X - 1) / 4", 2.0),
            ("10 - 4 - 3", 3.0),
            ("pow(X, 2) % 5", 4.0),
            ("sqrt(X1*12) - abs(-1.5e0)", 4.5),
            ("sin(pi/2) + log10(1E2)", 3.0),
            ("- - X", 3.0),
            (".5*X", 1.5),
        ] {
            assert!((at(text, 3.0) - expected).abs() < 1e-12, "{text} is {}", at(text, 3.0));
        }
    }

    #[test]
    fn what_is_no_formula_is_reported() {
        for (text, why) in [
            ("", "ends too early"),
            ("X +", "ends too early"),
            ("X Y", "\"Y\" is not expected"),
            ("(X", "\")\" is missing"),
            ("gamma(X)", "\"gamma\" is not known"),
            ("Z", "\"z\" is not known"),
            ("1..2", "not expected"),
        ] {
            let message = Formula::parse(text).unwrap_err();
            assert!(message.contains(why), "{text}: {message}");
        }
    }

    #[test]
    fn long_and_deep_formulas_are_refused_at_once() {
        let long = "X+".repeat(200_000) + "X";
        assert!(Formula::parse(&long).unwrap_err().contains("characters"));
        assert!(Formula::parse(&long[..40_001]).unwrap_err().contains("1000 operations"));
        for deep in
            ["(".repeat(50_000), "sin(".repeat(10_000), "X^".repeat(20_000), "-".repeat(90_000)]
        {
            assert!(Formula::parse(&deep).is_err());
        }
    }
}
