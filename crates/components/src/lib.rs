//! The plant library and the control laws: one file per component.
//!
//! Folders are the stages of the signal path. A component is a unit type, or a static of a type that
//! several share, that implements [`model::Component`]; to add one, write its file and its line in
//! [`COMPONENTS`]. The physical causes that components stand for are in [`effects`]. Nothing here
//! allocates; functions come from `libm`, so that results are equal on every machine.
#![no_std]
#[cfg(test)]
extern crate std;

pub mod actuator;
pub mod amplifier;
pub mod control;
pub mod coupling;
pub mod creep;
pub mod effects;
pub mod environment;
pub mod hysteresis;
pub mod linear;
pub mod mechanics;
pub mod random;
pub mod sensor;
pub mod solve;
pub mod timing;
pub mod turn;

mod affine;
mod low_pass;
mod quantiser;
mod rules;
#[cfg(test)]
mod testing;

/// All component types, in the order of the signal path.
pub static COMPONENTS: model::Registry = &[
    &timing::Delay,
    &timing::ClockOffset,
    &timing::DAC_QUANTISATION,
    &amplifier::AmplifierLag,
    &amplifier::AMPLIFIER_SECOND_ORDER,
    &amplifier::AmplifierRc,
    &amplifier::AmplifierSlew,
    &amplifier::AmplifierFoldback,
    &amplifier::AmplifierClamp,
    &amplifier::AmplifierNonlinearity,
    &amplifier::PiezoCharge,
    &actuator::PolarisationSaturation,
    &actuator::ACTUATOR_GAIN,
    &actuator::ActuatorTemperature,
    &actuator::ActuatorAgeing,
    &actuator::SelfHeating,
    &actuator::ThermalPort,
    &hysteresis::PrandtlIshlinskii,
    &hysteresis::ModifiedPrandtlIshlinskii,
    &hysteresis::SkewedPlay,
    &hysteresis::GeneralisedPlay,
    &hysteresis::Preisach,
    &hysteresis::BoucWen,
    &hysteresis::Duhem,
    &hysteresis::Dahl,
    &hysteresis::RateDependentPlay,
    &hysteresis::LaggingPlay,
    &hysteresis::Grpi,
    &hysteresis::Mpi,
    &hysteresis::DynamicPrandtlIshlinskii,
    &actuator::Remanence,
    &creep::KelvinVoigtCreep,
    &creep::LogarithmicCreep,
    &creep::FractionalCreep,
    &mechanics::LoadForce,
    &mechanics::MODE,
    &mechanics::ModePair,
    &mechanics::Arx,
    &mechanics::CollocatedMode,
    &mechanics::LOADED_MODE,
    &mechanics::Duffing,
    &mechanics::PositionStiffness,
    &mechanics::Friction,
    &mechanics::NonlinearDamping,
    &mechanics::Backlash,
    &mechanics::CuttingForce,
    &mechanics::Vibration,
    &mechanics::MechanicalPort,
    &coupling::CommandCoupling,
    &coupling::DisplacementCoupling,
    &coupling::ModeCoupling,
    &coupling::ModalMatrix,
    &coupling::SofteningModes,
    &coupling::OpticsJacobian,
    &coupling::PsdPincushion,
    &environment::ThermalDrift,
    &environment::ThermalExpansion,
    &environment::Disturbance,
    &environment::FloorVibration,
    &sensor::SensorLag,
    &sensor::SENSOR_SECOND_ORDER,
    &sensor::SensorButterworth,
    &sensor::SENSOR_SCALE,
    &sensor::SensorPolynomial,
    &sensor::SensorQuadCell,
    &sensor::SensorNoise,
    &sensor::SensorDrift,
    &sensor::MainsHum,
    &sensor::Crosstalk,
    &sensor::SENSOR_QUANTISATION,
    &hysteresis::InversePrandtlIshlinskii,
    &hysteresis::InverseModifiedPrandtlIshlinskii,
    &hysteresis::InverseGeneralisedPlay,
    &hysteresis::InversePreisach,
    &hysteresis::INVERSE_BOUC_WEN,
    &hysteresis::INVERSE_DUHEM,
    &hysteresis::INVERSE_DAHL,
    &hysteresis::INVERSE_RATE_DEPENDENT_PLAY,
    &hysteresis::INVERSE_GRPI,
    &hysteresis::INVERSE_MPI,
    &hysteresis::INVERSE_DYNAMIC_PRANDTL_ISHLINSKII,
    &control::JacobianCoordinator,
    &control::PreviewCoordinator,
    &control::ReferencePreview,
    &control::ReferenceFilter,
    &control::DisturbanceObserver,
    &control::ReferenceLead,
    &creep::InverseKelvinVoigtCreep,
    &control::REFERENCE_CURVE,
    &control::FeedforwardGain,
    &control::BoucWenFeedforward,
    &control::COMMAND_CURVE,
    &control::Notch,
    &control::FeedbackNotch,
    &control::Repetitive,
    &control::INTEGRAL_RESONANT_CONTROL,
    &control::POSITIVE_POSITION_FEEDBACK,
    &control::NON_MINIMUM_PHASE_DAMPING,
    &control::Pid,
    &control::IncrementalPid,
];

/// The component type of this name (a blueprint's `type`).
#[must_use]
pub fn find(kind: &str) -> Option<&'static dyn model::Component> {
    COMPONENTS.iter().copied().find(|c| c.declaration().kind == kind)
}
