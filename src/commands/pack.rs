//! `piezoloop pack`: blueprint → FMU.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use modeldescription::FmiVersion;
use modeldescription::describe::{About, describe};
use modeldescription::description::{CoSimulation, Interface};
use modeldescription::package::{PackageBuilder, Platform};
use serde::Serialize;

use crate::answer::{Answer, Screen};
use crate::{inputs, libraries};

/// Packs a blueprint as an FMI co-simulation FMU
///
/// The shared library inside the FMU is carried by this tool; no compiler is needed.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop pack plant.toml -o plant.fmu\n  piezoloop pack evc -o evc.fmu\n  piezoloop pack plant.toml --binary win64=piezoloop_plant.dll -o plant.fmu"
)]
pub(crate) struct Pack {
    /// A blueprint file, or the name of a rig
    blueprint: PathBuf,
    /// The FMU to write [default: the model's name with .fmu]
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
    /// Internal step in s in the place of the blueprint's; linear parts are exact at any step
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    step: Option<f64>,
    /// Version of the standard: 2 or 3
    #[arg(long, value_name = "VERSION", default_value = "2")]
    fmi: Version,
    /// Add every effect of the library that the plant does not have, switched off: a start value
    /// such as axis[1].backlash.enabled=true brings it in
    #[arg(long)]
    all_effects: bool,
    /// A shared library for a further platform (may be given several times)
    #[arg(long = "binary", value_name = "PLATFORM=FILE")]
    binaries: Vec<String>,
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
    bytes: usize,
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
        let output = inputs::output(self.out.clone(), &source.blueprint.name, "fmu");
        inputs::not_over(&output, &[&self.blueprint])?;
        let extra = further_binaries(&self.binaries)?;
        let version = match self.fmi {
            Version::Two => FmiVersion::V2,
            Version::Three => FmiVersion::V3,
        };
        pack(&source, version, &extra, &output)
    }
}

/// Writes the FMU of a blueprint.
pub(crate) fn pack(
    source: &inputs::BlueprintText,
    version: FmiVersion,
    further: &[(String, Vec<u8>)],
    output: &Path,
) -> anyhow::Result<Packed> {
    let system = source.blueprint.check(components::COMPONENTS)?.build();
    let (library, kind) = match system.kind() {
        model::Kind::Plant => (&libraries::PLANT, "plant"),
        model::Kind::Controller => (&libraries::CONTROLLER, "controller"),
    };
    let mut about = About::new(version, system.name(), co_simulation(&system), system.period());
    let categories = fmi_bindings::export::LOG_CATEGORIES;
    about.log_categories =
        categories.iter().map(|(name, what)| ((*name).to_owned(), (*what).to_owned())).collect();
    about.description = Some(source.blueprint.description.clone()).filter(|d| !d.is_empty());
    about.generation_tool = Some(format!("Piezoloop {}", crate::VERSION));
    about.license = Some("MIT OR Apache-2.0 (the shared library)".to_owned());
    let description = describe(system.variables(), &about)?;
    let mut package = PackageBuilder::new(&description)?;
    package.binary(libraries::PLATFORM, library.bytes.to_vec())?;
    let mut platforms = vec![libraries::PLATFORM.to_owned()];
    for (platform, bytes) in further {
        package.binary(platform, bytes.clone())?;
        platforms.push(platform.clone());
    }
    package.resource("blueprint.toml", source.text.clone().into_bytes())?;
    let notice =
        b"The shared library of this FMU is licensed under MIT or Apache-2.0, at your option.\n\
        The model in resources/blueprint.toml belongs to whoever made it.\n";
    package.license("license.txt", notice.to_vec())?;
    package.license("LICENSE-MIT.txt", include_bytes!("../../LICENSE-MIT").to_vec())?;
    package.license("LICENSE-APACHE.txt", include_bytes!("../../LICENSE-APACHE").to_vec())?;
    let page = crate::documentation::page(&source.blueprint, system.period(), system.variables());
    package.documentation("index.html", page.into_bytes())?;
    let bytes = package.to_bytes()?.len();
    package.write(output)?;
    Ok(Packed {
        fmu: output.to_owned(),
        fmi_version: version.text(),
        model: system.name().to_owned(),
        kind,
        guid: description.instantiation_token.clone(),
        variables: system.variables().len(),
        internal_step_s: system.period(),
        platforms,
        bytes,
    })
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
        can_interpolate_inputs: true,
        fixed_internal_step_size: Some(system.period()),
        ..CoSimulation::default()
    }
}

/// Reads the libraries of `--binary PLATFORM=FILE`.
fn further_binaries(given: &[String]) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut all = Vec::new();
    for text in given {
        let Some((platform, file)) = text.split_once('=') else {
            bail!("--binary {text}: write PLATFORM=FILE, as in win64=piezoloop_plant.dll");
        };
        if Platform::from_name(platform).is_none() {
            bail!(
                "--binary {text}: \"{platform}\" is no platform of FMI; use linux64, win64, darwin64, \
                 aarch64-linux, …"
            );
        }
        if platform == libraries::PLATFORM {
            bail!(
                "--binary {text}: the FMU carries a library for {platform} already; leave it out"
            );
        }
        let bytes = std::fs::read(file)
            .with_context(|| format!("--binary {text}: {file} cannot be read"))?;
        all.push((platform.to_owned(), bytes));
    }
    Ok(all)
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
            self.platforms.join(", "),
            self.bytes.div_ceil(1000)
        )
    }
}
