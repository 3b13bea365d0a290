//! `piezoloop pack`: blueprint → FMU.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use cli::{Answer, Screen};
use fmi_bindings::export::Library;
use modeldescription::FmiVersion;
use modeldescription::package::Platform;
use serde::Serialize;

use crate::packing::{Assembled, Beside, Binary, Portable, assemble, binaries_in};
use crate::reference::{self, Reference};
use crate::{documentation, inputs, libraries, ports};

/// Packs a blueprint as an FMI co-simulation FMU
///
/// The tool contains the shared library of the FMU; no compiler is needed.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop pack plant.toml -o plant.fmu\n  piezoloop pack evc -o evc.fmu\n  piezoloop pack plant.toml --binary win64=piezoloop_fmu_blueprint.dll -o plant.fmu\n  piezoloop pack evc --libraries target/portable -o evc.fmu\n  piezoloop pack p1 --fmi 3 --ports mechanical,electrical --port-value 'capacitance=2.1 uF' -o p1.fmu\n  piezoloop pack evc --sources=only -o evc.fmu\n  piezoloop pack evc --fmi 3 --wasm -o evc.fmu"
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

/// Writes it with the portable forms that are wanted, and ports that were added.
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
        Some(_) => Some(Reference::of_package(package, reference::OURS, None)?),
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
