//! An opened FMU: its package, its description, its library.

use std::path::Path;
use std::sync::Arc;

use fmi_bindings::import::OnMessage;
use fmi_bindings::import::{v2, v3};
use modeldescription::variable::{Causality, Variable};
use modeldescription::{FmiVersion, ModelDescription, Package};

use crate::error::Error;
use crate::isolate::{IsolatedSlave, Worker};
use crate::problem::Problems;
use crate::slave::{Address, Fmi2Slave, Fmi3Slave, Settings, Slave, Value, numbers, structure};

/// An FMU that is opened and loaded, ready to be instantiated any number of times.
///
/// The unpacked package lives as long as this and all slaves made from it. A copy shares it.
#[derive(Clone)]
pub struct Fmu {
    package: Arc<Package>,
    description: Arc<ModelDescription>,
    library: Library,
    /// Values of structural parameters.
    structure: Vec<(String, Value)>,
}

/// The loaded library, by version of the standard.
#[derive(Clone)]
enum Library {
    V2(Arc<v2::Library>),
    V3(Arc<v3::Library>),
    /// A WebAssembly component, where there is no library for this machine.
    #[cfg(feature = "wasm")]
    Component(Arc<crate::slave::ComponentLibrary>),
    /// Each instance in a process of its own, which loads the library.
    Elsewhere(Worker),
}

impl Library {
    /// The library for this machine.
    fn of(package: &Package, version: FmiVersion) -> Result<Self, Error> {
        let binary = package.binary();
        #[cfg(feature = "wasm")]
        if let (Err(_), Some(file)) = (&binary, package.component()) {
            return Ok(Library::Component(Arc::new(crate::slave::ComponentLibrary::load(&file)?)));
        }
        #[cfg(not(feature = "wasm"))]
        if let (Err(_), Some(_)) = (&binary, package.component()) {
            return Err(Error::Component {
                fmu: package.description().model_name.clone(),
                call: "the component".to_owned(),
                what: "is all that it has for this machine, and this build does not run WebAssembly components: build \
                       it with `cargo install --path . --features wasm`, or get a library for this machine"
                    .to_owned(),
            });
        }
        let binary = binary?;
        Ok(match version {
            FmiVersion::V2 => Library::V2(Arc::new(v2::Library::load(&binary)?)),
            FmiVersion::V3 => Library::V3(Arc::new(v3::Library::load(&binary)?)),
        })
    }
}

/// What an instance is made with.
#[derive(Clone, Default)]
pub struct InstanceOptions {
    /// Ask the FMU to show windows of its own.
    pub visible: bool,
    /// Ask the FMU for debug messages.
    pub logging_on: bool,
    /// Sees each message of the FMU at once; without it messages are only found in errors.
    pub on_message: Option<OnMessage>,
}

impl Fmu {
    /// Opens a `.fmu` file, or a folder with the content of one, and loads its library.
    ///
    /// # Errors
    /// A package that does not open, offers no co-simulation, has no library for this
    /// machine, or has one that does not load.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let package = Fmu::package_of(path.as_ref())?;
        let description = Arc::new(package.description().clone());
        let library = Library::of(&package, description.fmi_version)?;
        Ok(Fmu { package: Arc::new(package), description, library, structure: Vec::new() })
    }

    /// Opens an FMU without loading its library: each instance runs in a process of its own. One
    /// that crashes or hangs is an error that names it.
    ///
    /// # Errors
    /// A package that does not open or offers no co-simulation.
    pub fn open_isolated(path: impl AsRef<Path>, worker: &Worker) -> Result<Self, Error> {
        let package = Fmu::package_of(path.as_ref())?;
        let description = Arc::new(package.description().clone());
        let library = Library::Elsewhere(worker.clone());
        Ok(Fmu { package: Arc::new(package), description, library, structure: Vec::new() })
    }

    fn package_of(path: &Path) -> Result<Package, Error> {
        let package = Package::open(path)?;
        let description = package.description();
        let offered = [
            (description.model_exchange.is_some(), "model exchange"),
            (description.scheduled_execution.is_some(), "scheduled execution"),
        ];
        let offered: Vec<&str> = offered.iter().filter(|o| o.0).map(|o| o.1).collect();
        if description.co_simulation.is_none() {
            let offered = offered.join(" and ");
            return Err(Error::Package {
                path: path.to_path_buf(),
                reason: format!(
                    "the FMU offers no co-simulation, only {offered}; export it for co-simulation"
                ),
            });
        }
        Ok(package)
    }

    /// Gives structural parameters of FMI 3.0 other values: all that is made from this FMU from now on
    /// has arrays of the sizes that follow.
    ///
    /// # Errors
    /// A name that is no structural parameter, or a value that it does not take.
    pub fn configure(&mut self, structure: &[(String, Value)]) -> Result<(), Error> {
        let name = &self.description.model_name;
        self.description = Arc::new(structure::configured(name, &self.description, structure)?);
        self.structure.retain(|(known, _)| structure.iter().all(|(name, _)| name != known));
        self.structure.extend_from_slice(structure);
        Ok(())
    }

    /// The model description.
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// The variable of this name, or the element of an array as if it were a variable of its own:
    /// `command[1]` of the array `command`.
    ///
    /// # Errors
    /// There is no such variable or element.
    pub fn variable(&self, name: &str) -> Result<Variable, Error> {
        let found = Address::find(&self.description.model_name, &self.description, name);
        Ok(found.map_err(Problems::from)?.variable)
    }

    /// The names of an array's elements, in row-major order.
    ///
    /// # Errors
    /// There is no such variable.
    pub fn elements(&self, name: &str) -> Result<Vec<String>, Error> {
        Ok(numbers(&self.description, &self.variable(name)?))
    }

    /// Where the value of a variable, or of an element of an array, is found: value reference, place
    /// in the variable from 0, number of values of the variable.
    ///
    /// # Errors
    /// There is no such variable or element.
    pub fn place(&self, name: &str) -> Result<(u32, usize, usize), Error> {
        let found = Address::find(&self.description.model_name, &self.description, name);
        let found = found.map_err(Problems::from)?;
        let (index, size) = found.element.map_or((0, 1), |e| (e.index, e.size));
        Ok((found.variable.value_reference, index, size))
    }

    /// The names of the numbers of one causality as a system connects and records them, an array by
    /// its elements.
    pub fn names(&self, causality: Causality) -> Vec<String> {
        let variables = self.description.variables.iter().filter(|v| v.causality == causality);
        variables.flat_map(|variable| numbers(&self.description, variable)).collect()
    }

    /// The unpacked package.
    pub fn package(&self) -> &Package {
        &self.package
    }

    /// Functions that the standard requires and this FMU's library lacks; none are known of a
    /// library that is loaded elsewhere.
    pub fn missing_functions(&self) -> &[&'static str] {
        match &self.library {
            Library::V2(library) => library.missing(),
            Library::V3(library) => library.missing(),
            Library::Elsewhere(_) => &[],
            // It is linked by its interface, all of it.
            #[cfg(feature = "wasm")]
            Library::Component(_) => &[],
        }
    }

    /// Makes an instance.
    ///
    /// # Errors
    /// What the FMU says when it refuses.
    pub fn instantiate(
        &self,
        name: impl Into<String>,
        options: &InstanceOptions,
    ) -> Result<Box<dyn Slave>, Error> {
        let InstanceOptions { visible, logging_on, on_message } = options.clone();
        let (name, structure) = (name.into(), self.structure.clone());
        let settings = Settings { name, visible, logging_on, on_message, structure };
        let (package, description) = (Arc::clone(&self.package), Arc::clone(&self.description));
        Ok(match &self.library {
            Library::V2(library) => {
                Box::new(Fmi2Slave::new(Arc::clone(library), description, package, settings)?)
            }
            Library::V3(library) => {
                Box::new(Fmi3Slave::new(Arc::clone(library), description, package, settings)?)
            }
            #[cfg(feature = "wasm")]
            Library::Component(library) => Box::new(crate::slave::ComponentSlave::new(
                Arc::clone(library),
                description,
                package,
                settings,
            )?),
            Library::Elsewhere(worker) => {
                Box::new(IsolatedSlave::new(worker, description, package, settings)?)
            }
        })
    }
}
