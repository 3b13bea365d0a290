//! The command line as a whole: read, with a word for options in the wrong place.

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{ArgMatches, Command, CommandFactory};

use crate::{Cli, ranges};

/// All commands, with the ranges of their options in the help texts.
pub(crate) fn command() -> Command {
    ranges::shown(Cli::command())
}

/// What the call says; a wrong one, and one for help, end here.
pub(crate) fn matches() -> ArgMatches {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    command().try_get_matches_from(&arguments).unwrap_or_else(|mut error| {
        if error.kind() == ErrorKind::UnknownArgument
            && let Some(ContextValue::String(option)) = error.get(ContextKind::InvalidArg)
            && let Some(place) = place_of(&command(), option, &arguments)
        {
            let place = vec![format!("write it after the command: {place}").into()];
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(place));
        }
        error.exit()
    })
}

/// Where an option stands that was written before its command.
fn place_of(tool: &Command, option: &str, arguments: &[OsString]) -> Option<String> {
    let name = option.split(['=', ' ']).next()?.trim_start_matches('-').to_owned();
    let mut command = tool;
    let mut way = tool.get_name().to_owned();
    for word in arguments.iter().skip(1).filter_map(|word| word.to_str()) {
        let Some(found) = command.get_subcommands().find(|known| known.get_name() == word) else {
            continue;
        };
        command = found;
        way = format!("{way} {word}");
        let takes = |arg: &clap::Arg| {
            arg.get_long() == Some(&*name) || arg.get_short().is_some_and(|s| name == s.to_string())
        };
        if command.get_arguments().any(takes) {
            return Some(format!("{way} … {}", option.split(' ').next()?));
        }
    }
    None
}
