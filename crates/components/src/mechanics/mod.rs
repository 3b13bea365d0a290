//! Moving mass, flexures, guides and load.

mod arx;
mod backlash;
mod collocated_mode;
mod cutting_force;
mod duffing;
mod friction;
mod load_force;
mod loaded_mode;
mod mode;
mod mode_pair;
mod nonlinear_damping;
mod position_stiffness;
mod substeps;
mod vibration;

pub use arx::Arx;
pub use backlash::Backlash;
pub use collocated_mode::CollocatedMode;
pub use cutting_force::CuttingForce;
pub use duffing::Duffing;
pub use friction::Friction;
pub use load_force::LoadForce;
pub use loaded_mode::LOADED_MODE;
pub use mode::MODE;
pub use mode_pair::ModePair;
pub use nonlinear_damping::NonlinearDamping;
pub use position_stiffness::PositionStiffness;
pub use vibration::Vibration;
