//! Safety: which state the bench is in, when the machine is in danger, what command it may get.
//!
//! * [`next`]: the state machine, a pure function.
//! * [`Monitor`]: looks at samples and commands for what breaks a limit.
//! * [`Shaper`]: the command that is sent: limited, slewed, bumpless, ramped to the safe value.

mod limits;
mod monitor;
mod shaper;
mod state;

pub use limits::{AxisLimits, Watch};
pub use monitor::{Monitor, Observed};
pub use shaper::Shaper;
pub(crate) use shaper::smooth;
pub use state::{Events, Memory, Reason, State, next};
