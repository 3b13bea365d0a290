//! The FMU of a blueprint: its description, libraries, portable forms, pictures and licences.

mod binaries;

use std::path::Path;

use anyhow::Context;
use fmi_bindings::export::Library;
use modeldescription::describe::{About, describe};
use modeldescription::description::{CoSimulation, Interface};
use modeldescription::package::{PackageBuilder, Platform};
use modeldescription::{FmiVersion, ModelDescription};
use sha2::{Digest as _, Sha256};

pub(crate) use binaries::{Binary, binaries_in};

use crate::{inputs, libraries, ports};

/// FMI version that blueprints are packed with before they are simulated.
pub(crate) const PACKED_WITH: FmiVersion = FmiVersion::V2;

/// The forms of an FMU that suit every platform, and whether each is added to the libraries.
#[derive(Clone, Copy, Default)]
pub(crate) struct Portable {
    pub(crate) sources: Option<Beside>,
    pub(crate) wasm: Option<Beside>,
}

impl Portable {
    /// Whether no library is included.
    pub(crate) fn alone(self) -> bool {
        [self.sources, self.wasm].contains(&Some(Beside::Only))
    }
}

/// What the FMU has besides a portable form.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Beside {
    /// Together with the shared libraries
    #[value(name = "beside")]
    Libraries,
    /// Without shared libraries
    Only,
}

/// Writes the FMU of a blueprint for a run of our own: nobody reads it, so it has no page and no
/// reference results.
pub(crate) fn pack_to_run(source: &inputs::BlueprintText, output: &Path) -> anyhow::Result<()> {
    assemble(source, PACKED_WITH, &[], Portable::default(), &[])?.package.write(output)?;
    Ok(())
}

/// An FMU before its page and reference results.
pub(crate) struct Assembled {
    pub(crate) package: PackageBuilder,
    pub(crate) description: ModelDescription,
    pub(crate) system: model::System,
    pub(crate) kind: &'static str,
    pub(crate) platforms: Vec<String>,
}

/// Everything of an FMU that follows from the blueprint alone.
pub(crate) fn assemble(
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
        model::Kind::Plant => ("plant", include_bytes!("icons/plant.png")),
        model::Kind::Controller => ("controller", include_bytes!("icons/controller.png")),
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
    add_origin(&mut about, source);
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
    package.license("LICENSE-MIT.txt", include_bytes!("../LICENSE-MIT").to_vec())?;
    package.license("LICENSE-APACHE.txt", include_bytes!("../LICENSE-APACHE").to_vec())?;
    Ok(Assembled { package, description, system, kind, platforms })
}

/// States who made the model, and what it may be used for.
fn add_origin(about: &mut About, source: &inputs::BlueprintText) {
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
    let xml = include_str!("icons/terminalsAndIcons.xml");
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
