//! What an FMU around another one has besides the two: licences, icon, reference results, page.

use std::path::Path;

use cosim::Worker;
use diagnose::Repaired;
use modeldescription::Package;

use crate::reference::{self, Reference};
use crate::{documentation, packing};

/// Completes the package and writes it.
pub(crate) fn finish(
    wrapper: &mut Repaired,
    original: &Package,
    file: &Path,
    worker: Option<&Worker>,
) -> anyhow::Result<()> {
    let notice =
        b"The shared library of this FMU is licensed under MIT or Apache-2.0, at your option.\n\
        The FMU in resources/inner belongs to whoever made it.\n";
    let package = &mut wrapper.package;
    package.license("license.txt", notice.to_vec())?;
    package.license("LICENSE-MIT.txt", include_bytes!("../LICENSE-MIT").to_vec())?;
    package.license("LICENSE-APACHE.txt", include_bytes!("../LICENSE-APACHE").to_vec())?;
    let has = |path: &str| original.folder().join(path).is_file();
    let version = original.description().fmi_version;
    if !has("model.png") && !has("terminalsAndIcons/terminalsAndIcons.xml") {
        packing::put_icon(package, version, include_bytes!("icons/plant.png"))?;
    }
    let own = has("documentation/index.html").then_some("resources/inner/documentation/index.html");
    // An original that does not run under signals of our making has no reference results.
    let reference = match Reference::of_package(package, reference::FOREIGN, worker) {
        Ok(reference) => Some(reference),
        Err(error) => {
            wrapper.notes.push(format!("no reference results are inside: {error:#}"));
            None
        }
    };
    if let Some(reference) = &reference {
        reference.pack(&mut wrapper.package)?;
    }
    let page = documentation::repaired(wrapper, own, reference.as_ref())?;
    wrapper.package.documentation("index.html", page.into_bytes())?;
    Ok(wrapper.package.write(file)?)
}
