//! From a plant to its controller.

mod calibration;
mod closed_loop;
mod invert;
mod learned_axis;
mod linearised;
mod loop_shape;
mod tuning;
mod undone;

pub use calibration::{Calibration, CalibrationRecord, CoordinateFit, calibrate};
pub use closed_loop::{LoopRun, simulate_loop};
pub use invert::{ControlSettings, Inversion, LoopFigures, invert};
pub use tuning::{
    Gains, LoopCurves, LoopVerdict, Machine, Ultimate, impulse_of, judge_loop, loop_curves, relay,
    robust, ultimate_by_gain, ziegler_nichols,
};
