//! `piezoloop pack`: blueprint → FMU.

mod binaries;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use cli::{Answer, Screen};
use fmi_bindings::export::Library;
use modeldescription::describe::{About, describe};
use modeldescription::description::{CoSimulation, Interface};
use modeldescription::package::{PackageBuilder, Platform};
use modeldescription::{FmiVersion, ModelDescription};
use serde::Serialize;
use sha2::{Digest as _, Sha256};

pub(crate) use binaries::{Binary, binaries_in};

use crate::reference::{self, Reference};
use crate::{documentation, fmus, inputs, libraries, ports};

/// Packs a blueprint as an FMI co-simulation FMU
///
/// The tool contains the shared library of the FMU; no compiler is needed.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop pack plant.toml -o plant.fmu\n  piezoloop pack evc -o evc.fmu\n  piezoloop pack plant.toml --binary win64=piezoloop_blueprint.dll -o plant.fmu\n  piezoloop pack evc --libraries target/portable -o evc.fmu\n  piezoloop pack p1 --fmi 3 --ports mechanical,electrical --port-value 'capacitance=2.1 uF' -o p1.fmu\n  piezoloop pack evc --sources=only -o evc.fmu\n  piezoloop pack evc --fmi 3 --wasm -o evc.fmu"
)]
pub(crate) struct Pack {
    /// A blueprint file, or the name of a rig
    blueprint: PathBuf,
    /// The FMU to write [default: the model's name with .fmu]
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
    /// Internal step in s, instead of the blueprint's; linear parts are exact at any step
    #[arg(long, value_name = "S", value_parser = crate::ranges::step())]
    step: Option<f64>,
    /// Version of the standard: 2 or 3
    #[arg(long, value_name = "VERSION", default_value = "2")]
    fmi: Version,
    /// Add every effect of the library that the plant lacks, disabled; a start value such as
    /// axis[1].backlash.enabled=true enables it
    #[arg(long)]
    all_effects: bool,
    /// Add ports for system simulation: mechanical (force, position and velocity of the tip, in N, m and m/s),
    /// electrical (voltage, current, charge), thermal (temperature, heat); AXIS.mechanical adds one to a single axis
    #[arg(long, value_name = "PORTS", value_delimiter = ',', value_parser = ports::wish)]
    ports: Vec<ports::Wish>,
    /// A value that a port needs and the blueprint does not state, as in 'stiffness=20 N/um' or 'AXIS.capacitance=3.1
    /// uF' (may be given several times)
    #[arg(long = "port-value", value_name = "QUANTITY=VALUE", requires = "ports", value_parser = ports::given)]
    port_values: Vec<ports::Given>,
    /// Add a shared library of this tool for a further platform, or replace the built-in one (may be given several
    /// times)
    #[arg(long = "binary", value_name = "PLATFORM=FILE")]
    binaries: Vec<String>,
    /// Include all shared libraries of this folder, which has one subfolder per platform, as made by
    /// dev/tools/portable
    #[arg(long, value_name = "FOLDER")]
    libraries: Option<PathBuf>,
    /// Add the FMU as C99 sources, for targets without a library; with =only, no library is included
    #[arg(
        long,
        value_name = "only",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "beside"
    )]
    sources: Option<Beside>,
    /// Add the FMU as a WebAssembly component by the draft of the layered standard FMI-LS-WASM (experimental;
    /// FMI 3.0): it runs on every platform, without access to files or network; with =only, no library is included
    #[arg(
        long,
        value_name = "only",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "beside"
    )]
    wasm: Option<Beside>,
}

/// The forms of an FMU that suit every platform, and whether each is added to the libraries.
#[derive(Clone, Copy, Default)]
struct Portable {
    sources: Option<Beside>,
    wasm: Option<Beside>,
}

impl Portable {
    /// Whether no library is included.
    fn alone(self) -> bool {
        [self.sources, self.wasm].contains(&Some(Beside::Only))
    }
}

/// What the FMU has besides a portable form.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Beside {
    /// Together with the shared libraries
    #[value(name = "beside")]
    Libraries,
    /// Without shared libraries
    Only,
}

/// FMI version that blueprints are packed with before they are simulated.
pub(crate) const PACKED_WITH: FmiVersion = FmiVersion::V2;

/// Version of the standard.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    /// FMI 2.0
    #[value(name = "2")]
    Two,
    /// FMI 3.0
    #[value(name = "3")]
    Three,
}

/// What was packed.
#[derive(Serialize)]
pub(crate) struct Packed {
    fmu: PathBuf,
    fmi_version: &'static str,
    model: String,
    kind: &'static str,
    guid: String,
    variables: usize,
    internal_step_s: f64,
    platforms: Vec<String>,
    /// Whether it can be compiled from its sources.
    sources: bool,
    /// Whether it has a WebAssembly component.
    wasm: bool,
    bytes: usize,
    /// The ports that were added.
    ports: Vec<ports::Offered>,
}

impl Pack {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        screen.show(&self.execute()?)
    }

    /// Packs.
    pub(crate) fn execute(&self) -> anyhow::Result<Packed> {
        let mut source = inputs::blueprint(&self.blueprint)?;
        if let Some(step) = self.step {
            source.blueprint.step = step.into();
            source.text = source.blueprint.to_toml();
        }
        if self.all_effects {
            crate::effects::add_all(&mut source.blueprint)?;
            source.text = source.blueprint.to_toml();
        }
        let mut offered = Vec::new();
        if !self.ports.is_empty() {
            offered = ports::add(&mut source.blueprint, &self.ports, &self.port_values)?;
            source.text = source.blueprint.to_toml();
        }
        let output = inputs::output(self.out.clone(), &source.blueprint.name, "fmu");
        cli::can_write_as(&output, inputs::FMU)?;
        let portable = Portable { sources: self.sources, wasm: self.wasm };
        if portable.alone() && !(self.binaries.is_empty() && self.libraries.is_none()) {
            let option = if self.sources == Some(Beside::Only) { "sources" } else { "wasm" };
            bail!(
                "--{option}=only: no library is included; leave out --binary and --libraries, or write --{option}"
            );
        }
        if self.wasm.is_some() && self.fmi == Version::Two {
            bail!("--wasm: WebAssembly components belong to FMI 3.0; add --fmi 3");
        }
        let mut binaries: Vec<_> =
            self.binaries.iter().map(|text| Binary::read(text)).collect::<Result<_, _>>()?;
        if let Some(folder) = &self.libraries {
            for binary in binaries_in(folder, Library::Blueprint)? {
                if !binaries.iter().any(|given: &Binary| given.platform == binary.platform) {
                    binaries.push(binary);
                }
            }
        }
        let version = match self.fmi {
            Version::Two => FmiVersion::V2,
            Version::Three => FmiVersion::V3,
        };
        pack_with(&source, version, &binaries, portable, offered, &output)
    }
}

/// Writes the FMU of a blueprint for a user, with its page and reference results.
pub(crate) fn pack(
    source: &inputs::BlueprintText,
    version: FmiVersion,
    given: &[Binary],
    output: &Path,
) -> anyhow::Result<Packed> {
    pack_with(source, version, given, Portable::default(), Vec::new(), output)
}

/// As [`pack`], with the portable forms that are wanted, and ports that were added.
fn pack_with(
    source: &inputs::BlueprintText,
    version: FmiVersion,
    given: &[Binary],
    portable: Portable,
    ports: Vec<ports::Offered>,
    output: &Path,
) -> anyhow::Result<Packed> {
    let mut assembled = assemble(source, version, given, portable, &ports)?;
    let Assembled { package, description, .. } = &mut assembled;
    // What this platform's library computes; without one there is nothing to hold another against.
    let reference = match Platform::from_name(libraries::PLATFORM) {
        Some(_) => Some(reference_of(package, reference::OURS, None)?),
        None => None,
    };
    if let Some(reference) = &reference {
        reference.pack(package)?;
    }
    let page = documentation::page(&source.blueprint, description, reference.as_ref())?;
    package.documentation("index.html", page.into_bytes())?;
    if portable.alone() {
        package.remove_binaries();
        assembled.platforms.clear();
    }
    let Assembled { package, .. } = &assembled;
    let bytes = package.to_bytes()?.len();
    package.write(output)?;
    let Assembled { system, kind, platforms, description, .. } = assembled;
    Ok(Packed {
        fmu: output.to_owned(),
        fmi_version: version.text(),
        model: system.name().to_owned(),
        kind,
        guid: description.instantiation_token,
        variables: system.variables().len(),
        internal_step_s: system.period(),
        platforms,
        sources: portable.sources.is_some(),
        wasm: portable.wasm.is_some(),
        bytes,
        ports,
    })
}

/// Writes the FMU of a blueprint for a run of our own: nobody reads it, so it has no page and no
/// reference results.
pub(crate) fn pack_to_run(source: &inputs::BlueprintText, output: &Path) -> anyhow::Result<()> {
    assemble(source, PACKED_WITH, &[], Portable::default(), &[])?.package.write(output)?;
    Ok(())
}

/// An FMU before its page and reference results.
struct Assembled {
    package: PackageBuilder,
    description: ModelDescription,
    system: model::System,
    kind: &'static str,
    platforms: Vec<String>,
}

/// Everything of an FMU that follows from the blueprint alone.
fn assemble(
    source: &inputs::BlueprintText,
    version: FmiVersion,
    given: &[Binary],
    portable: Portable,
    ports: &[ports::Offered],
) -> anyhow::Result<Assembled> {
    let with_sources = portable.sources.is_some();
    let checked = source.blueprint.check(learned::COMPONENTS)?;
    let system = checked.build();
    let (kind, icon): (_, &[u8]) = match system.kind() {
        model::Kind::Plant => ("plant", include_bytes!("../icons/plant.png")),
        model::Kind::Controller => ("controller", include_bytes!("../icons/controller.png")),
    };
    let mut co_simulation = co_simulation(&system);
    if with_sources {
        let common = &mut co_simulation.common;
        // The C asks for its memory through the importer's functions, which FMI 3.0 does not have.
        common.can_not_use_memory_management_functions = version != FmiVersion::V2;
        common.source_files = vec![source::package::MAIN.to_owned()];
    }
    let mut about = About::new(version, system.name(), co_simulation, system.period());
    let categories = fmi_bindings::export::LOG_CATEGORIES;
    about.log_categories =
        categories.iter().map(|(name, what)| ((*name).to_owned(), (*what).to_owned())).collect();
    tell(&mut about, source);
    let description = describe(system.variables(), &about)?;
    let mut package = PackageBuilder::new(&description)?;
    let mut platforms = Vec::new();
    let carried = Platform::from_name(libraries::PLATFORM);
    if !given.iter().any(|binary| Some(binary.platform) == carried) {
        let folder = carried.map_or(libraries::PLATFORM, |platform| platform.folder(version));
        package.binary(folder, libraries::BLUEPRINT.bytes.to_vec())?;
        platforms.push(folder.to_owned());
    }
    for binary in given {
        binary.check(Library::Blueprint, &description)?;
        let folder = binary.platform.folder(version);
        package
            .binary(folder, binary.bytes.clone())
            .with_context(|| format!("--binary {}: give one library per platform", binary.text))?;
        platforms.push(folder.to_owned());
    }
    if with_sources {
        put_sources(&mut package, version, &checked)?;
    }
    if portable.wasm.is_some() {
        let component = source::component(checked.spec()).map_err(anyhow::Error::msg)?;
        package.component(&component)?;
    }
    put_pictures(&mut package, version, icon, &ports::terminals(system.variables(), ports))?;
    if version == FmiVersion::V3 {
        put_icons_of_terminals(&mut package, ports)?;
    }
    package.resource("blueprint.toml", source.text.clone().into_bytes())?;
    for (name, bytes) in checked.table_files() {
        package.resource(&name, bytes)?;
    }
    let notice =
        b"The shared library of this FMU is licensed under MIT or Apache-2.0, at your option.\n\
        The model in resources/blueprint.toml belongs to whoever made it.\n";
    package.license("license.txt", notice.to_vec())?;
    package.license("LICENSE-MIT.txt", include_bytes!("../../LICENSE-MIT").to_vec())?;
    package.license("LICENSE-APACHE.txt", include_bytes!("../../LICENSE-APACHE").to_vec())?;
    Ok(Assembled { package, description, system, kind, platforms })
}

/// Who made the model, and what it may be used for.
fn tell(about: &mut About, source: &inputs::BlueprintText) {
    let some = |text: &str| Some(text.to_owned()).filter(|text| !text.is_empty());
    let blueprint = &source.blueprint;
    about.description = some(&blueprint.description);
    about.generation_tool = Some(format!("Piezoloop {}", crate::VERSION));
    about.author = some(&blueprint.author);
    about.copyright = some(&blueprint.copyright);
    let library = "MIT OR Apache-2.0 (the shared library)";
    about.license = Some(match blueprint.license.as_str() {
        "" => library.to_owned(),
        own => format!("{own} (the model); {library}"),
    });
    // Without a version of its own, a model is told apart by what its blueprint says.
    about.version = some(&blueprint.version).or_else(|| {
        let digest = Sha256::digest(blueprint.to_toml().as_bytes());
        let digits = hex::encode(&digest[..6]);
        Some(format!("blueprint {digits}"))
    });
}

/// The model as C.
fn put_sources(
    package: &mut PackageBuilder,
    version: FmiVersion,
    checked: &data::CheckedBlueprint,
) -> anyhow::Result<()> {
    let is_v2 = version == FmiVersion::V2;
    let files = source::package::files(checked.spec(), checked.system(), is_v2);
    for (name, content) in files.map_err(anyhow::Error::msg)? {
        package.source(&name, content)?;
    }
    let notice = b"sources/core.h was translated by wasm2c of the WebAssembly Binary Toolkit (WABT), whose text it\n\
        repeats in part: Copyright WebAssembly Community Group participants, Apache-2.0 (LICENSE-APACHE.txt).\n";
    package.license("wabt.txt", notice.to_vec())?;
    Ok(())
}

/// The icon, where each version of the standard wants it.
pub(crate) fn put_icon(
    package: &mut PackageBuilder,
    version: FmiVersion,
    icon: &[u8],
) -> anyhow::Result<()> {
    put_pictures(package, version, icon, "")
}

/// The icon, and in FMI 3.0 the terminals.
fn put_pictures(
    package: &mut PackageBuilder,
    version: FmiVersion,
    icon: &[u8],
    terminals: &str,
) -> anyhow::Result<()> {
    if version == FmiVersion::V2 {
        package.entry("model.png", icon.to_vec())?;
        return Ok(());
    }
    package.entry("terminalsAndIcons/icon.png", icon.to_vec())?;
    let end = "</fmiTerminalsAndIcons>";
    let xml = include_str!("../icons/terminalsAndIcons.xml");
    let xml = xml.replace(end, &format!("{terminals}{end}"));
    package.entry("terminalsAndIcons/terminalsAndIcons.xml", xml.into_bytes())?;
    Ok(())
}

/// What the terminals look like.
fn put_icons_of_terminals(
    package: &mut PackageBuilder,
    offered: &[ports::Offered],
) -> anyhow::Result<()> {
    for (name, icon) in ports::ICONS {
        if offered.iter().any(|port| port.port.name() == *name) {
            package.entry(format!("terminalsAndIcons/{name}.png"), icon.to_vec())?;
        }
    }
    Ok(())
}

/// Runs a package as far as it has come, as an importer would.
pub(crate) fn reference_of(
    package: &PackageBuilder,
    tolerance: f64,
    worker: Option<&cosim::Worker>,
) -> anyhow::Result<Reference> {
    let folder = tempfile::tempdir().context("no temporary folder can be made")?;
    let file = folder.path().join("model.fmu");
    package.write(&file)?;
    Reference::of(&fmus::open_in(&file, worker)?.fmu, tolerance)
}

/// What the shared libraries can do.
fn co_simulation(system: &model::System) -> CoSimulation {
    CoSimulation {
        common: Interface {
            can_not_use_memory_management_functions: true,
            can_get_and_set_fmu_state: true,
            can_serialize_fmu_state: true,
            provides_directional_derivatives: true,
            ..Interface::new(system.name())
        },
        can_handle_variable_communication_step_size: true,
        max_output_derivative_order: 1,
        can_interpolate_inputs: true,
        fixed_internal_step_size: Some(system.period()),
        ..CoSimulation::default()
    }
}

impl Packed {
    /// What the packed runs on, for people.
    fn targets(&self) -> String {
        let mut targets = self.platforms.clone();
        targets.extend(self.sources.then(|| "every C99 compiler (sources)".to_owned()));
        targets.extend(self.wasm.then(|| "WebAssembly (component)".to_owned()));
        targets.join(", ")
    }
}

impl Answer for Packed {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "{}: {} \"{}\", FMI {} co-simulation, {} variables, internal step {} s, for {}, {} kB",
            self.fmu.display(),
            self.kind,
            self.model,
            self.fmi_version,
            self.variables,
            self.internal_step_s,
            self.targets(),
            self.bytes.div_ceil(1000)
        )?;
        self.ports.iter().flat_map(ports::Offered::sentences).try_for_each(|s| writeln!(out, "{s}"))
    }
}
