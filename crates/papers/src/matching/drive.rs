//! Our machines under the signals of the papers.

use super::{response, signal};

/// The command of an axis and the position at the end of each of its samples.
pub(crate) struct Response {
    pub(crate) command: Vec<f64>,
    /// One more than commands: the position before the first.
    pub(crate) position: Vec<f64>,
    pub(crate) period: f64,
}

impl Response {
    /// The position at the end of each sample.
    pub(crate) fn after(&self) -> &[f64] {
        &self.position[1..]
    }
}

/// What axis 1 of a truth rig does under a paper's signal, times `gain`; the last command is held for
/// one sample more.
pub(crate) fn driven(
    rig: &str,
    name: &str,
    settings: &[(&str, f64)],
    gain: f64,
) -> anyhow::Result<Response> {
    axis_driven(rig, 1, name, settings, gain)
}

/// What an axis, from 1, does as in [`driven`].
pub(crate) fn axis_driven(
    rig: &str,
    axis: usize,
    name: &str,
    settings: &[(&str, f64)],
    gain: f64,
) -> anyhow::Result<Response> {
    let (u, period) = signal(name, settings)?;
    let mut command: Vec<f64> = u.iter().map(|u| gain * u).collect();
    command.push(command.last().copied().unwrap_or(0.0));
    let position = response(&mut super::rig(rig)?, axis, &command, period)?;
    command.pop();
    Ok(Response { command, position, period })
}
