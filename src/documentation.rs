//! The page `documentation/index.html` inside an FMU: what the model is, its chain, its variables.

use std::fmt::Write;

use data::Blueprint;
use minijinja::{Environment, context};
use model::{Causality, Variable, VariableTable};

const PAGE: &str = r#"<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>{{ name }}</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; background: #fff }
h1 { font-size: 1.5rem; margin-bottom: 0.2rem } h2 { font-size: 1.1rem; margin-top: 1.8rem }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem } td, th { text-align: left; padding: 0.2rem 0.6rem 0.2rem 0; border-bottom: 1px solid #ddd; vertical-align: top }
td.n { font-variant-numeric: tabular-nums } code { font-size: 0.9em }
@media (prefers-color-scheme: dark) { body { color: #ddd; background: #1a1a1a } td, th { border-color: #444 } }
</style>
<h1>{{ name }}</h1>
<p>{{ description }}</p>
{% if source %}<p>Source: {{ source }}</p>{% endif %}
<p>A {{ kind }} with the internal step {{ step }} s. It is right for any communication step: the
model steps on its own grid, and its outputs are those of the last hit.</p>
<h2>Signal path</h2>
{% for axis in axes %}<p>Axis {{ loop.index }}, {{ axis.name }}: <code>{{ axis.path }}</code></p>
{% endfor %}
<h2>Variables</h2>
<table>
<tr><th>Name</th><th>What</th><th>Start</th><th>Range</th><th>Unit</th><th>Meaning</th></tr>
{% for v in variables %}<tr><td><code>{{ v.name }}</code></td><td>{{ v.what }}</td><td class="n">{{ v.start }}</td><td class="n">{{ v.range }}</td><td>{{ v.unit }}</td><td>{{ v.description }}</td></tr>
{% endfor %}</table>
</html>
"#;

/// The page of a packed blueprint.
pub(crate) fn page(blueprint: &Blueprint, period: f64, variables: &VariableTable) -> String {
    let kind = match blueprint.kind {
        model::Kind::Plant => "plant",
        model::Kind::Controller => "controller",
    };
    let axes: Vec<_> = blueprint
        .axes
        .iter()
        .map(|axis| {
            let ends =
                if kind == "plant" { ("command", "position") } else { ("reference", "command") };
            let mut path = ends.0.to_owned();
            for component in &axis.components {
                let name =
                    if component.name.is_empty() { &component.kind } else { &component.name };
                let _ = write!(path, " → {name}");
            }
            context! { name => &axis.name, path => format!("{path} → {}", ends.1) }
        })
        .collect();
    let rows: Vec<_> = variables.as_slice().iter().map(row).collect();
    let mut environment = Environment::new();
    let values = context! {
        name => &blueprint.name, description => &blueprint.description, source => &blueprint.source,
        kind, step => period.to_string(), axes, variables => rows,
    };
    // The template is ours and fixed; a failure to render it would be our defect, and the FMU is
    // still right without its page.
    environment
        .add_template("index.html", PAGE)
        .and_then(|()| environment.get_template("index.html")?.render(values))
        .unwrap_or_else(|_| String::from("<!doctype html><title>documentation</title>"))
}

fn row(v: &Variable) -> minijinja::Value {
    let what = match v.causality {
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::FixedParameter => "parameter",
        Causality::TunableParameter => "tunable parameter",
    };
    let range = match (v.min.is_finite(), v.max.is_finite()) {
        (true, true) => format!("{} … {}", v.min, v.max),
        (true, false) => format!("≥ {}", v.min),
        (false, true) => format!("≤ {}", v.max),
        (false, false) => String::new(),
    };
    let start = v.start.map(|s| s.to_string()).unwrap_or_default();
    context! { name => &v.name, what, start, range, unit => &v.unit, description => &v.description }
}
