//! What a measurement of a frequency response gives.

use std::io::{self, Write};
use std::path::PathBuf;

use cli::Answer;
use data::CheckedBlueprint;
use identify::frequency::{Choice, FrequencyResponse as Response, Levels, Mode};
use serde::Serialize;

/// A signal by its column.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Signal {
    pub(crate) name: String,
    pub(crate) unit: Option<String>,
}

impl Signal {
    /// The signal's unit; 1 where none is known.
    pub(crate) fn unit(&self) -> &str {
        self.unit.as_deref().unwrap_or("1")
    }
}

/// What was measured.
#[derive(Serialize)]
pub(crate) struct Measured {
    pub(crate) inputs: Vec<Signal>,
    pub(crate) outputs: Vec<Signal>,
    pub(crate) sample_time_s: f64,
    pub(crate) experiments: usize,
    /// Samples of a period; `null` where the records do not repeat.
    pub(crate) period_samples: Option<usize>,
    pub(crate) periods: usize,
    pub(crate) lines: usize,
    pub(crate) from_hz: f64,
    pub(crate) to_hz: f64,
    /// Per output.
    pub(crate) levels: Vec<OutputLevels>,
    pub(crate) fit: Option<Fit>,
    pub(crate) plant: Option<Plant>,
    pub(crate) notes: Vec<String>,
    pub(crate) written: Option<PathBuf>,
    #[serde(skip)]
    pub(crate) response: Response,
    #[serde(skip)]
    pub(crate) model: Option<Choice>,
}

impl Answer for Measured {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let repeated = match self.period_samples {
            Some(samples) => format!("{} periods of {samples} samples", self.periods),
            None => "no periods".to_owned(),
        };
        writeln!(
            out,
            "{} lines from {:.4} to {:.4} Hz; {} experiments, {repeated}",
            self.lines, self.from_hz, self.to_hz, self.experiments
        )?;
        for one in &self.levels {
            let OutputLevels { name, levels, least_coherence, mean_coherence } = one;
            let or =
                |value: Option<f64>| value.map_or("unknown".to_owned(), |x| format!("{x:.3e}"));
            writeln!(
                out,
                "{name}: rms per line {:.3e}, noise {}, distortion {} (even lines {}, odd lines {}); coherence {:.4}, \
                 at least {:.4}",
                levels.output,
                or(levels.noise),
                or(levels.distortion),
                or(levels.even),
                or(levels.odd),
                mean_coherence,
                least_coherence
            )?;
        }
        if let Some(fit) = &self.fit {
            for mode in &fit.modes {
                let Mode { frequency, damping, height } = mode;
                let what = if *damping < 1.0 { "mode" } else { "real pole" };
                writeln!(
                    out,
                    "{what} {frequency:.3} Hz, damping {damping:.4}, height {height:.3e}"
                )?;
            }
            for (row, output) in fit.static_gain.iter().zip(&self.outputs) {
                let each = row.iter().zip(&self.inputs);
                let gains: Vec<String> =
                    each.map(|(gain, input)| format!("{gain:.4} from {}", input.name)).collect();
                writeln!(out, "static gain of {}: {}", output.name, gains.join(", "))?;
            }
            writeln!(
                out,
                "delay {} s; the fit leaves {:.3} times the response's own scatter",
                fit.delay_s,
                fit.misfit.sqrt()
            )?;
        }
        for note in &self.notes {
            writeln!(out, "note: {note}")?;
        }
        if let Some(plant) = &self.plant {
            if let Some(softening) = &plant.softening {
                softening.write(out)?;
            }
            for error in &plant.errors {
                writeln!(
                    out,
                    "{}: {} simulated to {:.4} {} rms, {:.2} % of its own",
                    error.record,
                    error.output,
                    error.rmse,
                    error.unit,
                    100.0 * error.relative
                )?;
            }
        }
        for file in self.written.iter().chain(self.plant.iter().map(|plant| &plant.blueprint)) {
            writeln!(out, "{}: written", file.display())?;
        }
        Ok(())
    }
}

/// How large signal, noise and distortion of an output are, rms over the lines, in its unit.
#[derive(Serialize)]
pub(crate) struct OutputLevels {
    pub(crate) name: String,
    #[serde(flatten)]
    pub(crate) levels: Levels,
    /// Least and mean coherence over the lines.
    pub(crate) least_coherence: f64,
    pub(crate) mean_coherence: f64,
}

/// The rational model that was fitted.
#[derive(Serialize)]
pub(crate) struct Fit {
    pub(crate) modes: Vec<Mode>,
    pub(crate) delay_s: f64,
    /// Mean square of what the fit leaves over the response's own variance.
    pub(crate) misfit: f64,
    /// Static gain of the fit, outputs by inputs.
    pub(crate) static_gain: Vec<Vec<f64>>,
}

/// A plant as it is written.
#[derive(Serialize)]
pub(crate) struct Plant {
    pub(crate) blueprint: PathBuf,
    pub(crate) modes: usize,
    pub(crate) delay_s: f64,
    /// How the modes follow the amplitude; `null` where they do not.
    pub(crate) softening: Option<PlantSoftening>,
    /// Per record and output.
    pub(crate) errors: Vec<PlantError>,
    #[serde(skip)]
    pub(crate) checked: CheckedBlueprint,
}

/// How the modes of a plant follow the amplitude.
#[derive(Serialize)]
pub(crate) struct PlantSoftening {
    /// Power of the amplitude.
    pub(crate) exponent: f64,
    /// Levels of the records, from the least on.
    pub(crate) levels: Vec<PlantLevel>,
    /// Per mode.
    pub(crate) modes: Vec<SofteningMode>,
}

impl PlantSoftening {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for (number, level) in (1..).zip(&self.levels) {
            let rms: Vec<String> = level.rms.iter().map(|r| format!("{r:.4}")).collect();
            let PlantLevel { experiments, .. } = level;
            writeln!(
                out,
                "level {number}: {experiments} records, rms of inputs {}",
                rms.join(", ")
            )?;
        }
        writeln!(
            out,
            "modes follow the amplitude to the power of {}; changes at level {}:",
            self.exponent,
            self.levels.len()
        )?;
        for mode in &self.modes {
            writeln!(
                out,
                "mode of small motion {:.3} Hz, damping {:.4}: frequency {:+.2} %, damping {:+.0} %",
                mode.frequency,
                mode.damping,
                100.0 * mode.frequency_shift,
                100.0 * mode.damping_growth
            )?;
        }
        Ok(())
    }
}

/// A level of excitation.
#[derive(Serialize)]
pub(crate) struct PlantLevel {
    pub(crate) experiments: usize,
    /// Per input, about its mean.
    pub(crate) rms: Vec<f64>,
}

/// A mode of small motion and its relative changes at the greatest level.
#[derive(Serialize)]
pub(crate) struct SofteningMode {
    pub(crate) frequency: f64,
    pub(crate) damping: f64,
    pub(crate) frequency_shift: f64,
    pub(crate) damping_growth: f64,
}

/// How far the plant is from a record that it was fitted to, driven by its inputs alone.
#[derive(Serialize)]
pub(crate) struct PlantError {
    pub(crate) record: String,
    pub(crate) output: String,
    pub(crate) unit: String,
    /// Root mean square of measured less simulated, the means of both taken out.
    pub(crate) rmse: f64,
    /// `rmse` over the measured output's own root mean square.
    pub(crate) relative: f64,
    /// First row that is judged: with periods the second one's, as the simulation starts at rest.
    pub(crate) from_row: usize,
}
