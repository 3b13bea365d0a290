//! Moving mass, flexures, guides and load.

mod backlash;
mod cutting_force;
mod duffing;
mod friction;
mod loaded_mode;
mod mode;
mod vibration;

pub use backlash::Backlash;
pub use cutting_force::CuttingForce;
pub use duffing::Duffing;
pub use friction::Friction;
pub use loaded_mode::LoadedMode;
pub use mode::Mode;
pub use vibration::Vibration;
