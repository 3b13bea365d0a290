//! Ranges of the numbers on the command line: declared once, where the option is; from there they are
//! checked before any work and shown in `--help` (see [`shown`]).

use std::fmt;
use std::str::FromStr;

use clap::builder::{PossibleValue, StyledStr, TypedValueParser};
use clap::{Arg, Command};

/// Longest time that any command takes, in s.
pub(crate) const LONGEST: f64 = 1e9;

/// The hidden value by which a parser tells its range.
const MARK: &str = "range";

/// A parser with a range.
#[derive(Clone)]
pub(crate) struct Ranged<T> {
    read: fn(&str) -> Option<T>,
    is_within: Within<T>,
    /// The range in words.
    range: String,
}

#[derive(Clone)]
enum Within<T> {
    /// Above or from the first, up to the second.
    Above(T, T),
    From(T, T),
    /// What `read` takes.
    Any,
}

/// Numbers above `low`, up to `high`.
pub(crate) fn above(low: f64, high: f64) -> Ranged<f64> {
    let range = format!("above {low}, up to {}", Short(high));
    Ranged { read: |text| text.parse().ok(), is_within: Within::Above(low, high), range }
}

/// Numbers from `low` to `high`.
pub(crate) fn from(low: f64, high: f64) -> Ranged<f64> {
    let range = format!("{} to {}", Short(low), Short(high));
    Ranged { read: |text| text.parse().ok(), is_within: Within::From(low, high), range }
}

/// Values of a signal in its own unit.
pub(crate) fn signal() -> Ranged<f64> {
    from(-1e15, 1e15)
}

/// Times of a log or a run in s, from 0.
pub(crate) fn time() -> Ranged<f64> {
    from(0.0, LONGEST)
}

/// Steps and periods in s: those that a blueprint may have.
pub(crate) fn step() -> Ranged<f64> {
    from(1e-9, 1e3)
}

/// Counts from `low` to `high`.
pub(crate) fn count(low: usize, high: usize) -> Ranged<usize> {
    integers(low, high)
}

/// Whole numbers of any type from `low` to `high`.
pub(crate) fn integers<T>(low: T, high: T) -> Ranged<T>
where
    T: FromStr + PartialOrd + fmt::Display + Clone,
{
    let range = format!("{low} to {high}");
    Ranged { read: |text| text.parse().ok(), is_within: Within::From(low, high), range }
}

/// Seeds: every whole number of 64 bits.
pub(crate) fn seed() -> Ranged<u64> {
    Ranged { range: "0 to 2^64 - 1".to_owned(), ..integers(0, u64::MAX) }
}

/// Threads; 0 stands for one per processor.
pub(crate) fn threads() -> Ranged<usize> {
    count(0, 1024)
}

/// Cycles per second, as in 10k.
pub(crate) fn rate() -> Ranged<f64> {
    let read = |text: &str| bench::plan::parse_rate(text).ok();
    Ranged { read, is_within: Within::Any, range: "0.1 to 200k, as in 10k or 2.5kHz".to_owned() }
}

/// `MIN..MAX`.
pub(crate) fn limits() -> Ranged<[f64; 2]> {
    let read = |text: &str| {
        let (min, max) = text.split_once("..")?;
        let [min, max] = [min.trim().parse::<f64>().ok()?, max.trim().parse::<f64>().ok()?];
        (-1e15 <= min && min < max && max <= 1e15).then_some([min, max])
    };
    let range = "MIN below MAX, each -1e15 to 1e15, as in 0..120".to_owned();
    Ranged { read, is_within: Within::Any, range }
}

impl<T> TypedValueParser for Ranged<T>
where
    T: PartialOrd + Clone + Send + Sync + 'static,
{
    type Value = T;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &std::ffi::OsStr,
    ) -> Result<T, clap::Error> {
        let Self { read, is_within, range } = self.clone();
        let parse = move |text: &str| {
            let is_within = |value: &T| match &is_within {
                Within::Above(low, high) => low < value && value <= high,
                Within::From(low, high) => low <= value && value <= high,
                Within::Any => true,
            };
            read(text.trim()).filter(is_within).ok_or_else(|| format!("must be {range}"))
        };
        parse.parse_ref(command, argument, value)
    }

    /// Not offered, only told: see [`shown`].
    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let range = PossibleValue::new(MARK).help(self.range.clone()).hide(true);
        Some(Box::new(std::iter::once(range)))
    }
}

/// The command with the ranges of its options in their help texts, and of all commands below it.
pub(crate) fn shown(command: Command) -> Command {
    let with_range = |arg: Arg| {
        let Some(range) = of(&arg) else { return arg };
        let message = |help: Option<&StyledStr>| help.map(|help| format!("{help} ({range})"));
        let (help, long) = (message(arg.get_help()), message(arg.get_long_help()));
        // A negative number is a value that is refused, no option.
        let arg = arg.hide_possible_values(true).allow_hyphen_values(true);
        let arg = help.into_iter().fold(arg, Arg::help);
        long.into_iter().fold(arg, Arg::long_help)
    };
    command.mut_args(with_range).mut_subcommands(shown)
}

/// The range of an option, if it takes numbers.
pub(crate) fn of(arg: &Arg) -> Option<String> {
    let described = arg.get_possible_values();
    let described = described.first().filter(|described| described.get_name() == MARK)?;
    described.get_help().map(ToString::to_string)
}

/// Large and small numbers by their power of ten.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.abs() {
            size if size != 0.0 && !(1e-3..1e5).contains(&size) => write!(f, "{:e}", self.0),
            _ => write!(f, "{}", self.0),
        }
    }
}
