//! Which of the project's TOML files a text is, for messages where one stands in the place of another.

/// What only one kind of file has: the beginning of a line, and the kind.
const MARKS: [(&str, &str); 17] = [
    ("piezoloop_record", "a record of a specimen"),
    ("piezoloop", "a blueprint"),
    ("[[sequence]]", "a plan of the bench"),
    ("[watch]", "a plan of the bench"),
    ("gateway", "a plan of the bench"),
    ("[[case]]", "a campaign of the bench"),
    ("[[fault]]", "a script of faults"),
    ("[fmus]", "a system of FMUs"),
    ("[fmus.", "a system of FMUs"),
    ("[connections]", "a system of FMUs"),
    ("[vary]", "a plan of a sweep"),
    ("[loop]", "a plan of a sweep"),
    ("[identify]", "a plan of a sweep"),
    ("[diagnose]", "a plan of a sweep"),
    ("[columns]", "what describes a log"),
    ("[columns.", "what describes a log"),
    ("[tool.", "a configuration of another program"),
];

/// The kind of a text, if a line says it: `a blueprint`.
#[must_use]
pub fn toml_kind(text: &str) -> Option<&'static str> {
    let is = |line: &str, mark: &str| {
        let rest = line.strip_prefix(mark);
        rest.is_some_and(|rest| mark.starts_with('[') || rest.trim_start().starts_with('='))
    };
    let of = |line: &str| MARKS.iter().find(|(mark, _)| is(line, mark)).map(|(_, kind)| *kind);
    text.lines().map(str::trim).find_map(of)
}

/// `is a blueprint, no KIND: ` where a text is of another kind than `kind`, else nothing: what goes before the
/// first error of a reader.
#[must_use]
pub fn of_another_kind(text: &str, kind: &str) -> String {
    match toml_kind(text) {
        Some(own) if own != kind => {
            let bare = kind.strip_prefix("a ").unwrap_or(kind);
            format!("is {own}, no {bare}: ")
        }
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_recognized_by_what_only_it_has() {
        for (text, kind) in [
            ("# x\n piezoloop = 1\n[loop]\n", Some("a blueprint")),
            ("rate = 1\n[[sequence]]\n", Some("a plan of the bench")),
            ("[fmus.plant]\n", Some("a system of FMUs")),
            ("piezoloops = 1\nname = 'x'\n", None),
            ("", None),
        ] {
            assert_eq!(toml_kind(text), kind, "{text}");
        }
        let message = of_another_kind("piezoloop = 1", "a plan of the bench");
        assert_eq!(message, "is a blueprint, no plan of the bench: ");
        assert_eq!(of_another_kind("piezoloop = 1", "a blueprint"), "");
    }
}
