//! From a plant to its controller.
//!
//! * [`invert`]: plant → controller, the inverse of what the plant does as feedforward and a PID loop with stated
//!   margins; [`simulate_loop`] runs the two.
//! * [`relay`], [`robust`] and others: gains from experiments on a machine; [`ServoPlant`]: values for the servo of an
//!   instrument.
//! * [`calibrate`]: the Jacobian of coupled axes from their simultaneous motion.
//!
//! Nothing prints; an [`Observer`](identify::Observer) is told how far long work is.

mod along;
mod analysis;
mod axis;
mod calibration;
mod check;
mod closed_loop;
mod coupled_loop;
mod coupling;
mod curve;
mod damping;
mod design;
mod feedforward;
mod inverse_filter;
mod inversion;
mod invert;
mod learned_axis;
mod linearised;
mod loop_shape;
mod nyquist;
mod path;
mod preview;
mod probe;
mod responses;
mod search;
mod servo;
mod tuning;
mod work;

pub use along::{Along, along};
pub use calibration::{Calibration, CalibrationRecord, CoordinateFit, calibrate};
pub use check::Check;
pub use closed_loop::{LoopRun, simulate_loop};
pub use coupled_loop::CoupledFigures;
pub use damping::{Damping, DampingFigures};
pub use design::{CommandActs, Feedback};
pub use feedforward::Feedforward;
pub use identify::learned::InverseFigures;
pub use identify::{Error, NotInvertible, SettingsProblem};
pub use inversion::{ControlSettings, Coordinator, Inversion, LoopFigures};
pub use invert::invert;
pub use preview::PreviewFigures;
pub use responses::{AxisResponses, FrequencyCurves, TimeRun, responses};
pub use servo::{
    Line, NarrowMode, NotchFilter, ServoLaw, ServoLimits, ServoPlant, ServoVerdict, law_in_record,
    measured_response, multisine,
};
pub use tuning::{
    Gains, LoopCurves, LoopVerdict, Machine, Ultimate, impulse_of, judge_loop, loop_curves, relay,
    robust, ultimate_by_gain, ziegler_nichols,
};
