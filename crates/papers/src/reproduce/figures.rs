//! Figures of a reproduction: what the machine and the loops did.

use report::{Axis, Figure, Role, TimeSeries, XyLoop};

use super::control::Tracked;

/// Figures under a heading.
pub(crate) struct Chapter {
    pub(crate) heading: String,
    /// What is to be seen.
    pub(crate) text: String,
    pub(crate) figures: Vec<Figure>,
}

impl Chapter {
    pub(crate) fn new(heading: impl Into<String>, text: impl Into<String>) -> Self {
        Self { heading: heading.into(), text: text.into(), figures: Vec::new() }
    }

    pub(crate) fn figure(mut self, figure: impl Into<Figure>) -> Self {
        self.figures.push(figure.into());
        self
    }
}

/// Runs over the same references.
pub(crate) struct Runs<'a> {
    /// Name and run of each controller.
    pub(crate) runs: Vec<(&'a str, &'a Tracked)>,
    /// Sample time in s.
    pub(crate) period: f64,
    /// First row that is judged.
    pub(crate) from: usize,
    /// Unit of the positions.
    pub(crate) unit: &'a str,
}

impl Runs<'_> {
    fn time(&self) -> Vec<f64> {
        let rows = self.runs.first().map_or(0, |(_, run)| run.rows());
        (0..rows).map(|k| k as f64 * self.period).collect()
    }

    /// Reference and positions of an axis, the errors and the commands below.
    pub(crate) fn tracking(&self, title: impl Into<String>, axis: usize) -> TimeSeries {
        let time = self.time();
        let mut figure = TimeSeries::new(title, &time).panel("position");
        if let Some((_, first)) = self.runs.first() {
            figure = figure.reference("reference", self.unit, &first.reference[axis]);
        }
        for (name, run) in &self.runs {
            figure = figure.other(*name, self.unit, &run.position[axis]);
        }
        figure = figure.panel("error");
        for (name, run) in &self.runs {
            figure = figure.other(*name, self.unit, &run.error[axis]);
        }
        figure = figure.panel("command");
        for (name, run) in &self.runs {
            figure = figure.other(*name, "V", &run.command[axis]);
        }
        self.judged(figure)
    }

    /// Errors of an axis.
    pub(crate) fn errors(&self, title: impl Into<String>, axis: usize) -> TimeSeries {
        let time = self.time();
        let figure = self.runs.iter().fold(TimeSeries::new(title, &time), |figure, (name, run)| {
            figure.other(*name, self.unit, &run.error[axis])
        });
        self.judged(figure)
    }

    /// Distances from the reference in the plane of two axes.
    pub(crate) fn distances(&self, title: impl Into<String>, axes: [usize; 2]) -> TimeSeries {
        let time = self.time();
        let mut figure = TimeSeries::new(title, &time).panel("distance from the reference");
        for (name, run) in &self.runs {
            let [a, b] = axes.map(|axis| &run.error[axis]);
            let distance: Vec<f64> = a.iter().zip(b).map(|(a, b)| a.hypot(*b)).collect();
            figure = figure.other(*name, self.unit, &distance);
        }
        self.judged(figure)
    }

    fn judged(&self, figure: TimeSeries) -> TimeSeries {
        let end = self.runs.first().map_or(0, |(_, run)| run.rows()) as f64 * self.period;
        if self.from == 0 {
            figure
        } else {
            figure.band(self.from as f64 * self.period, end, "judged")
        }
    }

    /// Paths in the plane of two axes, the rows that are judged.
    pub(crate) fn paths(&self, title: impl Into<String>, axes: [(usize, &str); 2]) -> XyLoop {
        let [(x, x_name), (y, y_name)] = axes;
        let axis = |name: &str| Axis::new(name, self.unit);
        let mut figure = XyLoop::new(title, axis(x_name), axis(y_name)).equal_scale();
        if let Some((_, first)) = self.runs.first() {
            let part = |at: usize| &first.reference[at][self.from..];
            figure = figure.line(Role::Reference, "reference", part(x), part(y));
        }
        for (name, run) in &self.runs {
            let part = |at: usize| &run.position[at][self.from..];
            figure = figure.line(Role::Other, *name, part(x), part(y));
        }
        figure
    }

    /// Position over reference of an axis: a straight line where the loop is taken out.
    pub(crate) fn straightness(&self, title: impl Into<String>, axis: usize) -> XyLoop {
        let name = |what: &str| Axis::new(what, self.unit);
        let figure = XyLoop::new(title, name("reference"), name("position"));
        self.runs.iter().fold(figure, |figure, (name, run)| {
            let (r, y) = (&run.reference[axis][self.from..], &run.position[axis][self.from..]);
            figure.line(Role::Other, *name, r, y)
        })
    }

    /// The machine's own loop: position over command of an axis, the rows that are judged.
    pub(crate) fn loops(&self, title: impl Into<String>, axis: usize) -> XyLoop {
        let figure =
            XyLoop::new(title, Axis::new("command", "V"), Axis::new("position", self.unit));
        self.runs.iter().fold(figure, |figure, (name, run)| {
            let (u, y) = (&run.command[axis][self.from..], &run.position[axis][self.from..]);
            figure.line(Role::Other, *name, u, y)
        })
    }
}

/// A machine's answers to commands without control: position over command, each with its name.
pub(crate) fn open_loop(
    title: impl Into<String>,
    unit: &str,
    answers: &[(&str, &[f64], &[f64])],
) -> XyLoop {
    let figure = XyLoop::new(title, Axis::new("command", "V"), Axis::new("position", unit));
    answers.iter().fold(figure, |figure, (name, u, y)| {
        let rows = u.len().min(y.len());
        figure.line(Role::Other, *name, &u[..rows], &y[..rows])
    })
}

/// Normalised positions over the normalised command.
pub(crate) fn over(
    title: impl Into<String>,
    command: &[f64],
    [measured, model]: [(&str, &[f64]); 2],
) -> XyLoop {
    XyLoop::new(title, Axis::new("command", "1"), Axis::new("position", "1"))
        .measured(measured.0, command, measured.1)
        .model(model.0, command, model.1)
}

/// Measured and simulated positions of a record, the error below.
pub(crate) fn model(
    title: impl Into<String>,
    unit: &str,
    period: f64,
    measured: &[f64],
    models: &[(&str, &[f64])],
) -> TimeSeries {
    let time: Vec<f64> = (0..measured.len()).map(|k| k as f64 * period).collect();
    let mut figure =
        TimeSeries::new(title, &time).panel("position").measured("machine", unit, measured);
    for (k, (name, simulated)) in models.iter().enumerate() {
        let role = if k == 0 { Role::Model } else { Role::Other };
        figure = figure.signal(role, *name, unit, simulated);
    }
    figure = figure.panel("error");
    for (k, (name, simulated)) in models.iter().enumerate() {
        let errors: Vec<f64> = measured.iter().zip(*simulated).map(|(y, s)| y - s).collect();
        let role = if k == 0 { Role::Residual } else { Role::Other };
        figure = figure.signal(role, format!("machine − {name}"), unit, &errors);
    }
    figure
}
