//! How long the FMUs of a run took, as answers and pages tell it.

use anyhow::bail;
use report::{Column, Section, Table, Value};
use serde::Serialize;

/// Times of a run.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct RunTimes {
    /// On the clock, from the first communication step to the end.
    wall_s: f64,
    simulated_s: f64,
    /// Seconds that were simulated in a second on the clock.
    real_time_factor: Option<f64>,
    steps: u64,
    /// Steps of which the times of the FMUs are taken: all, or where they are short some at random.
    timed_steps: u64,
    /// Of a paced run: steps that began late by more than a tenth of a step, and the most.
    late_steps: u64,
    latest_s: f64,
    fmus: Vec<FmuTimes>,
}

/// Times of one FMU.
#[derive(Clone, Debug, Serialize)]
struct FmuTimes {
    name: String,
    /// The FMU times' steps.
    calls: u64,
    timed: u64,
    mean_s: f64,
    min_s: f64,
    max_s: f64,
    /// Of all its steps, from those that were timed.
    total_s: f64,
    /// Part of the time on the clock.
    share_of_wall: Option<f64>,
    /// Part of the time that was simulated: less than 1 is faster than real time.
    share_of_real_time: Option<f64>,
    histogram: Vec<Bin>,
}

/// Steps that took less than this, and no less than half of it.
#[derive(Clone, Debug, Serialize)]
struct Bin {
    below_s: f64,
    count: u64,
}

impl From<cosim::Statistics> for RunTimes {
    fn from(statistics: cosim::Statistics) -> Self {
        let cosim::Statistics { wall, simulated, steps, timed_steps, fmus, late_steps, latest } =
            statistics;
        let part = |a: f64, b: f64| Some(a / b).filter(|part| part.is_finite());
        let fmu = |fmu: cosim::FmuTimes| FmuTimes {
            calls: fmu.calls,
            timed: fmu.timed,
            mean_s: fmu.mean,
            min_s: fmu.range.0,
            max_s: fmu.range.1,
            total_s: fmu.total(),
            share_of_wall: part(fmu.total(), wall),
            share_of_real_time: part(fmu.total(), simulated),
            histogram: fmu
                .histogram
                .iter()
                .map(|(below_s, count)| Bin { below_s: *below_s, count: *count })
                .collect(),
            name: fmu.name,
        };
        RunTimes {
            wall_s: wall,
            simulated_s: simulated,
            real_time_factor: part(simulated, wall),
            steps,
            timed_steps,
            late_steps,
            latest_s: latest,
            fmus: fmus.into_iter().map(fmu).collect(),
        }
    }
}

impl RunTimes {
    pub(crate) fn real_time_factor(&self) -> Option<f64> {
        self.real_time_factor
    }

    /// The note of a paced run that was too slow.
    pub(crate) fn note(&self) -> Option<String> {
        (self.late_steps > 0).then(|| {
            format!(
                "{} of {} steps began more than a tenth of a step too late, at most {:.3} ms: this machine \
                 does not keep the pace",
                self.late_steps,
                self.steps,
                1e3 * self.latest_s
            )
        })
    }

    /// A section of a page.
    pub(crate) fn section(&self) -> Section {
        let heads = [
            Column::new("FMU"),
            Column::new("steps"),
            Column::new("mean").unit("us"),
            Column::new("shortest").unit("us"),
            Column::new("longest").unit("us"),
            Column::new("total").unit("s"),
            Column::new("of the run").unit("%"),
            Column::new("of real time").unit("%"),
        ];
        let caption = format!(
            "Time of the FMUs' steps; the run took {:.4} s for {} s, {} of {} steps were timed",
            self.wall_s, self.simulated_s, self.timed_steps, self.steps
        );
        let mut table = Table::new(caption, heads);
        let mut bins = Table::new(
            "Distribution of the times of steps",
            [
                Column::new("FMU"),
                Column::new("from").unit("us"),
                Column::new("below").unit("us"),
                "steps".into(),
            ],
        );
        let percent = |part: Option<f64>| Value::from(part.map_or(f64::NAN, |part| 100.0 * part));
        // Pages stay small, however many FMUs there are: those that take most.
        let mut fmus: Vec<&FmuTimes> = self.fmus.iter().collect();
        fmus.sort_by(|a, b| b.total_s.total_cmp(&a.total_s));
        for fmu in fmus.into_iter().take(50) {
            table = table.row([
                Value::from(fmu.name.as_str()),
                (fmu.calls as i64).into(),
                (1e6 * fmu.mean_s).into(),
                (1e6 * fmu.min_s).into(),
                (1e6 * fmu.max_s).into(),
                fmu.total_s.into(),
                percent(fmu.share_of_wall),
                percent(fmu.share_of_real_time),
            ]);
            for bin in fmu.histogram.iter().filter(|bin| bin.count > 0) {
                bins = bins.row([
                    Value::from(fmu.name.as_str()),
                    (0.5e6 * bin.below_s).into(),
                    (1e6 * bin.below_s).into(),
                    (bin.count as i64).into(),
                ]);
            }
        }
        Section::new("Times").table(table).table(bins)
    }
}

/// The pace that a user asks for.
pub(crate) fn pace(pace: Option<f64>) -> anyhow::Result<Option<f64>> {
    match pace {
        Some(pace) if !(pace.is_finite() && (1e-6..=1e6).contains(&pace)) => {
            bail!(
                "--pace {pace}: give the seconds to simulate in a second, from 1e-6 to 1e6; 1 is real time"
            )
        }
        pace => Ok(pace),
    }
}
