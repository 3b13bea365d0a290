//! What is asked of a controller, and what is known of the one that was made.

use data::CheckedBlueprint;
use identify::learned::InverseFigures;
use identify::{Error, NotInvertible};
use serde::Serialize;

use crate::check::Check;
use crate::coupled_loop::CoupledFigures;
use crate::damping::{Damping, DampingFigures};
use crate::design::{CommandActs, Feedback};
use crate::feedforward::Feedforward;
use crate::preview::PreviewFigures;

/// Choices about a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlSettings {
    /// Name of the controller; `None`: the plant's with `_controller` behind it.
    pub name: Option<String>,
    /// Sample time in s; `None`: that of what was learned, else the plant's internal step.
    pub period: Option<f64>,
    /// Greatest frequency in Hz of the commands that a learned inverse is learned from; `None`: the
    /// bandwidth of the learned linear part, but at least 50 samples a wave.
    pub band: Option<f64>,
    /// Largest sensitivity |1/(1 + L)| that the loop may have, above 1. It implies a gain margin of
    /// M/(M−1) and a phase margin of 2·asin(1/2M): 3 and 39° for the default of 1.5.
    pub sensitivity: f64,
    /// Most that white sensor noise may be amplified on its way to the command, with the command
    /// expressed as the position that it stands for: standard deviation over standard deviation.
    pub noise: f64,
    /// How the feedforward is made.
    pub feedforward: Feedforward,
    /// The law that acts on the error.
    pub feedback: Feedback,
    /// How the first resonance is damped, in an inner loop; the law is then PID or PI.
    pub damping: Damping,
    /// When a command acts: what the margins allow for.
    pub acts: CommandActs,
    /// Whether coupled axes are controlled in pairs (two a mirror), each by its own sensor only.
    pub independent: bool,
    /// Whether a controller that errs more than feedback alone on its own plant is given all the same.
    pub force: bool,
}

impl Default for ControlSettings {
    fn default() -> Self {
        Self {
            name: None,
            period: None,
            band: None,
            sensitivity: 1.5,
            noise: 10.0,
            feedforward: Feedforward::Automatic,
            feedback: Feedback::Pid,
            damping: Damping::None,
            acts: CommandActs::Either,
            independent: false,
            force: false,
        }
    }
}

/// A controller and what is known of its loops.
#[derive(Clone, Debug, Serialize)]
pub struct Inversion {
    /// The controller, ready to be written.
    #[serde(skip)]
    pub controller: CheckedBlueprint,
    /// The loop of each axis.
    pub axes: Vec<LoopFigures>,
    /// The coordinators of coupled axes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coordinators: Vec<Coordinator>,
}

/// What is known of a coordinator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coordinator {
    /// Names of the axes.
    pub axes: Vec<String>,
    /// Types of the couplings that it undoes.
    pub couplings: Vec<String>,
    /// Condition number of the Jacobian.
    pub condition: f64,
    /// The loop of all its axes, where the coupling has dynamics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupled_loop: Option<CoupledFigures>,
    /// The inverse of the coupling's dynamics, where one is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preview: Option<PreviewFigures>,
    /// What the coordinator does not undo; empty where the coupling is static and straight.
    pub note: String,
}

/// The loop of one axis, on the plant linearised at its steepest slope with all its linear components. Margins
/// and sensitivity are the worst over the plant as given and with the modes' frequencies 10 % lower and higher,
/// with the command acting at once and one period later ([`CommandActs`]), and hold for every smaller slope of
/// the hysteresis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopFigures {
    /// Name of the axis.
    pub axis: String,
    /// What the feedforward is.
    pub feedforward: String,
    /// What the feedback does.
    pub shape: String,
    /// Steepest slope in position (motion where axes are coupled by optics) per command.
    pub slope: f64,
    /// Proportional gain in command per position.
    pub kp: f64,
    /// Integral gain in command per position and second.
    pub ki: f64,
    /// Derivative gain in command-seconds per position.
    pub kd: f64,
    /// Time constant of the derivative's filter in s.
    pub derivative_filter: f64,
    /// Lowest frequency at which the loop gain is 1, in Hz.
    pub bandwidth: f64,
    /// By how much the loop gain may grow before the loop becomes unstable.
    pub gain_margin: f64,
    /// In degrees.
    pub phase_margin: f64,
    /// Greatest |1/(1 + L)|.
    pub sensitivity: f64,
    /// Standard deviation of the command per standard deviation of white sensor noise, without the
    /// loop's answer.
    pub noise_gain: f64,
    /// Mean time from a command to the position in s, with all linear components and half a period of hold.
    pub delay: f64,
    /// Least and greatest position that the command's bounds always allow, also after the opposite
    /// bound was visited, as simulated; of coupled axes, that all of them may use at once.
    pub reach: (f64, f64),
    /// The inner loop that damps the first resonance, where there is one. Margins and sensitivity are then those of
    /// the whole loop over the plants of its grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<DampingFigures>,
    /// What the controller does on its own plant.
    pub checks: Vec<Check>,
    /// What is left to feedback, and what it costs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_to_feedback: Vec<String>,
    /// The inverse, where it was learned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inverse: Option<InverseFigures>,
}

pub(crate) fn refused(reasons: Vec<NotInvertible>) -> Error {
    Error::NotInvertible(reasons)
}
