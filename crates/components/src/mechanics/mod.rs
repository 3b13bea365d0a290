//! Moving mass, flexures, guides and load.

mod arx;
mod backlash;
mod collocated_mode;
mod cutting_force;
mod duffing;
mod friction;
mod load_force;
mod loaded_mode;
mod mechanical_port;
mod mode;
mod mode_pair;
mod nonlinear_damping;
mod position_stiffness;
mod vibration;

pub use arx::Arx;
pub use backlash::Backlash;
pub use collocated_mode::CollocatedMode;
pub use cutting_force::CuttingForce;
pub use duffing::Duffing;
pub use friction::Friction;
pub use load_force::LoadForce;
pub use loaded_mode::LOADED_MODE;
pub use mechanical_port::MechanicalPort;
pub use mode::MODE;
pub use mode_pair::ModePair;
pub use nonlinear_damping::NonlinearDamping;
pub use position_stiffness::PositionStiffness;
pub use vibration::Vibration;

/// The components of this folder, in the order of the signal path.
pub(crate) static COMPONENTS: model::Registry = &[
    &LoadForce,
    &MODE,
    &ModePair,
    &Arx,
    &CollocatedMode,
    &LOADED_MODE,
    &Duffing,
    &PositionStiffness,
    &Friction,
    &NonlinearDamping,
    &Backlash,
    &CuttingForce,
    &Vibration,
    &MechanicalPort,
];
