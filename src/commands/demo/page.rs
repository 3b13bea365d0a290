//! The page of the demo.

use std::path::Path;

use report::{Axis, KeyFigure, Report, Role, Section, TimeSeries, Verdict, XyLoop};

use super::{Demonstration, LEAST_GAIN, PAPER_PERCENT};
use crate::pages;
use crate::results::identify::Identified;
use crate::results::simulate::Simulated;

/// Names of the axes' signals in the runs.
const AXES: [(&str, &str); 2] = [("Y", "1"), ("Z", "2")];

pub(super) fn page(
    result: &Demonstration,
    identified: &Identified,
    pid: &Simulated,
    both: &Simulated,
    measured: &Path,
) -> anyhow::Result<Report> {
    let errors: Vec<String> = result
        .axes
        .iter()
        .map(|a| format!("{:.2} % on {}", a.inverse_and_pid_percent, a.axis.to_uppercase()))
        .collect();
    let sentence = format!(
        "With the inverse of the identified hysteresis as feedforward, the loop follows a 100 Hz ellipse with a largest error of {} of peak-to-peak; the paper reaches {PAPER_PERCENT} %.",
        errors.join(" and ")
    );
    let verdict = if result.reached() { Verdict::pass(sentence) } else { Verdict::fail(sentence) };
    let mut report = Report::new("demo", "From a measured log to a closed loop", verdict)
        .provenance(pages::provenance(&[("log", measured)])?);
    for axis in &result.axes {
        let name = axis.axis.to_uppercase();
        report = report
            .key_figure(
                KeyFigure::new(format!("{name}: inverse + PID"), axis.inverse_and_pid_percent, "%")
                    .at_most(PAPER_PERCENT)
                    .note("max|e| over peak-to-peak"),
            )
            .key_figure(
                KeyFigure::new(
                    format!("{name}: gain over PID alone"),
                    axis.pid_percent / axis.inverse_and_pid_percent,
                    "1",
                )
                .at_least(LEAST_GAIN)
                .note(format!("PID alone: {:.2} %", axis.pid_percent)),
            )
            .key_figure(
                KeyFigure::new(
                    format!("{name}: identified plant"),
                    axis.identified_percent,
                    "% of range",
                )
                .note(format!("held out; a straight line {:.2} %", axis.line_percent)),
            );
    }
    report = report
        .key_figure(KeyFigure::new("One doStep, two axes", result.do_step_ns, "ns").at_most(1000.0))
        .section(paths(pid, both))
        .section(errors_over_time(pid, both))
        .section(commands(both));
    for axis in &identified.axes {
        for section in pages::sections(axis) {
            report = report.section(section);
        }
    }
    Ok(report)
}

fn paths(pid: &Simulated, both: &Simulated) -> Section {
    let last = |run: &Simulated, name: &str| -> Vec<f64> {
        let values = run.signals.values(name).unwrap_or_default();
        values[values.len().saturating_sub(500)..].to_vec()
    };
    let figure = XyLoop::new("One turn of the ellipse", Axis::new("Y", "um"), Axis::new("Z", "um"))
        .measured("reference", &last(both, "reference[1]"), &last(both, "reference[2]"))
        .model("inverse + PID", &last(both, "position[1]"), &last(both, "position[2]"))
        .line(Role::Other, "PID alone", &last(pid, "position[1]"), &last(pid, "position[2]"))
        .equal_scale();
    Section::new("The path of the tool")
        .paragraph("The machine has asymmetric hysteresis, creep and 3 nm of sensor noise; the controller knows none of them. Positions are sensor readings.")
        .figure(figure)
}

fn errors_over_time(pid: &Simulated, both: &Simulated) -> Section {
    let time = both.signals.time();
    let mut figure = TimeSeries::new("Reference less position", time);
    for (axis, number) in AXES {
        figure = figure.panel(format!("error {axis}"));
        for (label, run) in [("PID alone", pid), ("inverse + PID", both)] {
            let get = |name: &str| run.signals.values(&format!("{name}[{number}]"));
            let (Some(r), Some(y)) = (get("reference"), get("position")) else { continue };
            let error: Vec<f64> = r.iter().zip(y).map(|(r, y)| r - y).collect();
            figure = figure.residual(format!("{axis}: {label}"), "um", &error);
        }
    }
    Section::new("Errors").figure(figure.caption("Judged from 0.1 s on."))
}

fn commands(both: &Simulated) -> Section {
    let mut figure = TimeSeries::new("Commands with feedforward", both.signals.time());
    for (axis, number) in AXES {
        if let Some(u) = both.signals.values(&format!("command[{number}]")) {
            figure = figure.model(format!("command {axis}"), "V", u);
        }
    }
    Section::new("Commands").figure(figure.limit(0.0, "least").limit(120.0, "greatest"))
}
