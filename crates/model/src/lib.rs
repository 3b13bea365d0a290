//! What a quantity, a component and a chain of components are.
//!
//! A [`Component`] is one physical effect or one control law: it *declares* its quantities once
//! ([`Declaration`]) and steps over slices. A [`System`] is a built chain of components: everything
//! that never changes is its plan, everything that changes is one [`Context`], so that reset, save
//! and restore are copies. Building allocates and can fail; stepping does neither.
//!
//! Equations are in SI. Variables at the edge carry the unit of the blueprint (`um`, `V`, …); the
//! value that a user sets is kept as it was given, so that reading it back returns the same bits.
#![no_std]
extern crate alloc;

mod bundle;
mod component;
mod context;
mod declaration;
mod effect;
mod fit;
mod fnv;
mod port;
mod quantity;
mod registry;
mod stage;
mod system;
mod table;
mod unit;
mod variable;
mod wiring;

pub use bundle::Bundle;
#[cfg(feature = "records")]
#[doc(hidden)]
pub use component::Record;
#[cfg(not(target_family = "wasm"))]
pub use component::TransferPath;
pub use component::{
    Component, ComponentRef, Example, Extension, Inverse, Sizes, Tick, Undoing, Violation,
};
pub use context::{Context, ContextError};
pub use declaration::{Conversion, Declaration};
pub use effect::{Effect, Group, Phenomenon};
pub use fit::{Fit, Free, Missing, Range, Scale, Search};
pub use fnv::{fnv_64, fnv_128};
pub use port::{DEMANDED_INPUTS, DemandedInput, Input, MAX_PORTS, Output, Published, Source};
pub use quantity::{Quantity, Role, Shape, Structural, Variability, Within, unit_on_axis};
pub use registry::{Registry, count, joined};
pub use stage::Stage;
pub use system::{
    AxisSpec, BuildError, Connections, CouplingSpec, InputSpec, Kind, NodeSpec, PortSpec,
    StepError, System, SystemSpec,
};
pub use system::{DerivativeError, DerivativeRoom, Past, Quick};
pub use table::Table;
pub use unit::{BASE_UNITS, Unit, UnitError};
pub use variable::{Causality, DataType, Gate, SetError, Variable, VariableTable};
pub use wiring::Wiring;
