//! System Structure and Parameterization (SSP): read and write systems of connected FMUs.
//!
//! * [`SystemStructure`] is an SSD: systems, components, connectors, connections, units.
//! * [`SignalDictionary`] is an SSB: signals that elements share by name.
//! * [`ParameterSet`] is an SSV, [`ParameterMapping`] an SSM; both stand in files of their own or
//!   inside the SSD.
//! * [`Ssp`] is an opened `.ssp`, with the parameter files loaded; [`SspBuilder`] packs one.
//! * [`Flat`] is a system without hierarchy: which variable of which component feeds which.
//!
//! Version 1.0 is written. Of 2.0 everything is read that 1.0 has too, its numeric types, and its arrays of
//! connectors; its clocks and variants are not.

mod connector;
mod dictionary;
mod flat;
mod package;
mod problem;
mod read;
mod reader;
mod structure;
mod values;
mod write;

pub use connector::{Connector, ConnectorType, Dimension, Kind, Source};
pub use dictionary::{DictionaryReference, SignalDictionary};
pub use flat::{Flat, FlatComponent, FlatConnection, FlatInput, FlatOutput, FlatStart, Linear};
pub use package::{Ssp, SspBuilder};
pub use problem::SspError;
pub use structure::{
    Annotation, Binding, Component, Connection, Element, End, Enumeration, Experiment,
    Implementation, Mapped, Mapping, MappingEntry, Parameter, ParameterMapping, ParameterSet,
    ParameterValue, System, SystemStructure, Transformation,
};

/// Name of the SSD inside an SSP.
pub const SYSTEM_STRUCTURE: &str = "SystemStructure.ssd";
/// Media type of an FMU.
pub const FMU_TYPE: &str = "application/x-fmu-sharedlibrary";
