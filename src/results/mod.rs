//! What the commands give: as JSON, as text, and as what the pages show.

pub(crate) mod estimate;
pub(crate) mod frequency_response;
pub(crate) mod identify;
pub(crate) mod invert;
pub(crate) mod simulate;
pub(crate) mod system;
pub(crate) mod tune;
