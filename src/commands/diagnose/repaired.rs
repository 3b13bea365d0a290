//! The repaired model: whether it can be written as asked, and the writing of it.

use std::path::Path;

use anyhow::{Context, bail};
use data::NameMap;
use diagnose::Diagnosis;
use fmi_bindings::export::Library;
use modeldescription::FmiVersion;
use modeldescription::package::Platform;

use super::Diagnose;
use super::source::Source;
use crate::commands::pack;
use crate::inputs::BlueprintText;
use crate::packing::{self, Binary};
use crate::{libraries, wrapped};

impl Diagnose {
    /// Whether the repaired model can be of the kind that is asked for.
    pub(super) fn check_repair(&self) -> anyhow::Result<()> {
        let Some(file) = &self.repair else { return Ok(()) };
        match (cli::ends_in(file, "fmu"), cli::ends_in(file, "toml")) {
            (true, _) => Ok(()),
            (_, true) if self.is_fmu() => bail!(
                "--repair {}: an FMU has no blueprint that effects could be written into; give a \
                 name that ends in .fmu, and effects are put around it",
                file.display()
            ),
            (_, true) => Ok(()),
            _ => bail!(
                "--repair {}: the ending says what is written; give one in .toml or .fmu",
                file.display()
            ),
        }
    }

    /// The libraries of other platforms, where they were given; for a repaired FMU that has another one inside, or not.
    pub(super) fn libraries(&self, wraps: bool) -> anyhow::Result<Vec<Binary>> {
        let Some(folder) = &self.libraries else { return Ok(Vec::new()) };
        let library = if wraps { Library::Wrap } else { Library::Blueprint };
        let mut all = packing::binaries_in(folder, library)?;
        all.retain(|binary| Some(binary.platform) != Platform::from_name(libraries::PLATFORM));
        Ok(all)
    }

    /// Writes an FMU with the diagnosed one inside.
    fn write_wrapper(
        &self,
        diagnosis: &Diagnosis,
        (model, file): (&Path, &Path),
        names: &NameMap,
        others: &[Binary],
    ) -> anyhow::Result<Vec<String>> {
        let mut carried = vec![(libraries::PLATFORM, libraries::WRAP.bytes)];
        carried
            .extend(others.iter().map(|b| (b.platform.folder(FmiVersion::V3), b.bytes.as_slice())));
        let mut repaired = diagnosis.repair_fmu(model, names, &carried)?;
        others.iter().try_for_each(|binary| binary.check(Library::Wrap, &repaired.description))?;
        let original = modeldescription::Package::open(model)?;
        wrapped::finish(&mut repaired, &original, file, self.isolation.worker()?.as_ref())?;
        Ok(repaired.notes)
    }

    /// Writes the repaired model; what stays out of it, one sentence each.
    pub(super) fn write_repair(
        &self,
        diagnosis: &mut Diagnosis,
        (source, file): (&Source, &Path),
        names: &NameMap,
        others: &[Binary],
    ) -> anyhow::Result<Vec<String>> {
        if let Some(model) = source.fmu() {
            return self.write_wrapper(diagnosis, (&model, file), names, others);
        }
        let (repaired, notes) = diagnosis.repair(&source.blueprint()?.blueprint);
        repaired.check(learned::COMPONENTS).with_context(|| {
            format!("{} is not written: the repaired blueprint breaks a rule", file.display())
        })?;
        if cli::ends_in(file, "fmu") {
            let text = repaired.to_toml();
            let source = BlueprintText { text, blueprint: repaired };
            pack::pack(&source, packing::PACKED_WITH, others, file)?;
            return Ok(notes);
        }
        repaired.write(file)?;
        Ok(notes)
    }
}
