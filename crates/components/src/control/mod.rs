//! Control laws and feedforward.

mod active_damping;
mod bouc_wen_feedforward;
mod curve;
mod disturbance_observer;
mod feedforward_gain;
mod incremental_pid;
mod jacobian_coordinator;
mod limiter;
mod notch;
mod pid;
mod preview_coordinator;
mod reference_filter;
mod reference_lead;
mod reference_preview;
mod repetitive;

pub use active_damping::{
    ActiveDamping, INTEGRAL_RESONANT_CONTROL, NON_MINIMUM_PHASE_DAMPING, POSITIVE_POSITION_FEEDBACK,
};
pub use bouc_wen_feedforward::BoucWenFeedforward;
pub use curve::{COMMAND_CURVE, REFERENCE_CURVE};
pub use disturbance_observer::DisturbanceObserver;
pub use feedforward_gain::FeedforwardGain;
pub use incremental_pid::IncrementalPid;
pub use jacobian_coordinator::{JacobianCoordinator, condition};
pub use notch::{FeedbackNotch, Notch};
pub use pid::Pid;
pub use preview_coordinator::PreviewCoordinator;
pub use reference_filter::ReferenceFilter;
pub use reference_lead::ReferenceLead;
pub use reference_preview::ReferencePreview;
pub use repetitive::Repetitive;

/// The components of this folder, in the order of the signal path.
pub(crate) static COMPONENTS: model::Registry = &[
    &JacobianCoordinator,
    &PreviewCoordinator,
    &ReferencePreview,
    &ReferenceFilter,
    &DisturbanceObserver,
    &ReferenceLead,
    &super::creep::InverseKelvinVoigtCreep,
    &REFERENCE_CURVE,
    &FeedforwardGain,
    &BoucWenFeedforward,
    &COMMAND_CURVE,
    &Notch,
    &FeedbackNotch,
    &Repetitive,
    &INTEGRAL_RESONANT_CONTROL,
    &POSITIVE_POSITION_FEEDBACK,
    &NON_MINIMUM_PHASE_DAMPING,
    &Pid,
    &IncrementalPid,
];
