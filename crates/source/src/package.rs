//! The files below `sources/` of an FMU.

use std::fmt::Write as _;
use std::io::Read as _;

use model::{System, SystemSpec};

use crate::spec;

/// The core, packed; `dev/tools/source-core` makes it.
const CORE: &[u8] = include_bytes!("../c/core.h.gz");

/// The file that is compiled; it includes the others.
pub const MAIN: &str = "fmu.c";

/// The files of one model, with their names below `sources/`.
///
/// # Errors
/// The model cannot be written as bytes.
pub fn files(
    spec: &SystemSpec,
    system: &System,
    is_v2: bool,
) -> Result<Vec<(String, Vec<u8>)>, String> {
    let mut files: Vec<_> =
        core()?.into_iter().map(|(name, content)| (name.to_owned(), content)).collect();
    let edge = if is_v2 { "fmi2.h" } else { "fmi3.h" };
    files.retain(|(name, _)| !name.starts_with("fmi") || name == edge);
    let main = format!(
        "/* The whole FMU: compile this file, with the headers of the standard in the compiler's path. */\n\
         #include \"runtime.h\"\n#include \"model.h\"\n#include \"core.h\"\n#include \"{edge}\"\n"
    );
    files.push((MAIN.to_owned(), main.into_bytes()));
    files.push(("model.h".to_owned(), model(spec, system)?.into_bytes()));
    if !is_v2 {
        files.push((
            "buildDescription.xml".to_owned(),
            build_description(system.name()).into_bytes(),
        ));
    }
    Ok(files)
}

/// The files that are the same in every FMU, with their names.
///
/// # Errors
/// The packed core is damaged.
pub fn core() -> Result<Vec<(&'static str, Vec<u8>)>, String> {
    let mut core = Vec::new();
    flate2::read::GzDecoder::new(CORE)
        .read_to_end(&mut core)
        .map_err(|error| format!("the C core in this program is damaged: {error}"))?;
    Ok(vec![
        ("core.h", core),
        ("runtime.h", include_bytes!("../c/runtime.h").to_vec()),
        ("fmu.h", include_bytes!("../c/fmu.h").to_vec()),
        ("states.h", include_bytes!("../c/states.h").to_vec()),
        ("fmi2.h", include_bytes!("../c/fmi2.h").to_vec()),
        ("fmi3.h", include_bytes!("../c/fmi3.h").to_vec()),
    ])
}

/// What is the model's own.
fn model(spec: &SystemSpec, system: &System) -> Result<String, String> {
    let bytes = spec::to_bytes(spec)?;
    let mut text = format!(
        "/* The model {name}: its blueprint as bytes. */\n\
         #define PIEZOLOOP_PREFIX {name}_\n\
         #define PIEZOLOOP_TOKEN \"{token}\"\n\
         #define PIEZOLOOP_MODEL piezoloop_model\n\
         #define PIEZOLOOP_MODEL_SIZE {size}\n\
         #define PIEZOLOOP_VALUES {values}\n\
         /* Memory of an instance in pages of 64 KiB; where it is too little, instantiation asks for more. */\n\
         #ifndef PIEZOLOOP_PAGES\n#define PIEZOLOOP_PAGES {pages}\n#endif\n\
         static const unsigned char piezoloop_model[{size}] = {{",
        name = system.name(),
        token = system.variables().fingerprint(),
        size = bytes.len(),
        values = system.variables().len() + 1,
        pages = pages(bytes.len(), system),
    );
    for (at, byte) in bytes.iter().enumerate() {
        let separator = if at % 32 == 0 { "\n" } else { "" };
        let _ = write!(text, "{separator}{byte},");
    }
    text.push_str("\n};\n");
    Ok(text)
}

/// Pages that an instance is likely to need: the core's own, what it keeps of variables, and copies of the
/// context and of the bytes.
fn pages(bytes: usize, system: &System) -> usize {
    let own = 700 * system.variables().len() + 10 * system.context().byte_len() + 4 * bytes;
    5 + own.div_ceil(65_536) - 1
}

fn build_description(name: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiBuildDescription fmiVersion=\"3.0\">\n  \
         <BuildConfiguration modelIdentifier=\"{name}\">\n    \
         <SourceFileSet language=\"C99\">\n      \
         <SourceFile name=\"{MAIN}\"/>\n    \
         </SourceFileSet>\n  \
         </BuildConfiguration>\n\
         </fmiBuildDescription>\n"
    )
}
