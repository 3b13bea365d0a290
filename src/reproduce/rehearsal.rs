//! What an inverse learns from beside the training signals: the forward model's answers to commands that fill
//! its range and band.

use identify::learned::Frame;
use learned::lssvm::Samples;

use crate::matching;

/// Half cosine waves of random frequency and height within a range around 0 or above it. Half of the signals
/// begin at 0, the others at other levels, with the memory of a rise from 0.
#[derive(Clone, Copy)]
pub(super) struct Waves {
    pub(super) count: usize,
    pub(super) rows: usize,
    /// In s.
    pub(super) period: f64,
    /// Least and greatest frequency in Hz.
    pub(super) band: [f64; 2],
    /// Least and greatest command.
    pub(super) range: [f64; 2],
}

/// What the seeds of the papers' random signals are below.
const SEEDS: usize = 11;
/// The greatest command that the law of the waves is asked for.
const TOP: f64 = 10.0;

impl Waves {
    pub(super) fn commands(&self) -> anyhow::Result<Vec<Vec<f64>>> {
        (0..self.count)
            .map(|k| {
                let settings = [
                    ("seed", (SEEDS + k) as f64),
                    ("lowest_frequency", self.band[0]),
                    ("highest_frequency", self.band[1]),
                    ("top", TOP),
                    ("after", if k / 2 % 2 == 0 { 1.0 } else { 0.7 }),
                    ("sample_time", self.period),
                    ("duration", 1.5 * self.rows as f64 * self.period),
                ];
                let (wave, _) = matching::signal("p1-c", &settings)?;
                let [least, greatest] = self.range;
                // The first wave leads from 0 into the range.
                let eased = |row: usize| (row as f64 * self.period * self.band[1]).min(1.0);
                let command =
                    |(row, u): (usize, &f64)| least * eased(row) + (greatest - least) * u / TOP;
                let begin = k % 2 * (k * self.rows / (2 * self.count));
                Ok(wave.iter().enumerate().map(command).skip(begin).take(self.rows).collect())
            })
            .collect()
    }
}

/// The forward model's answers as inputs, the commands as outputs: all rows of what was measured, and every
/// few of the waves.
pub(super) struct Rehearsal {
    commands: Vec<Vec<f64>>,
    answers: Vec<Vec<f64>>,
    measured: usize,
}

impl Rehearsal {
    pub(super) fn new(
        measured: &[&[f64]],
        waves: Option<Waves>,
        forward: impl Fn(&[f64]) -> Vec<f64>,
    ) -> anyhow::Result<Self> {
        let mut commands: Vec<Vec<f64>> = measured.iter().map(|u| u.to_vec()).collect();
        commands.extend(waves.map(|waves| waves.commands()).transpose()?.unwrap_or_default());
        let answers = commands.iter().map(|u| forward(u)).collect();
        Ok(Self { commands, answers, measured: measured.iter().map(|u| u.len()).sum() })
    }

    /// Answer and command of each signal, what was measured first.
    pub(super) fn pairs(&self) -> Vec<(&[f64], &[f64])> {
        self.answers.iter().zip(&self.commands).map(|(h, u)| (&h[..], &u[..])).collect()
    }

    /// Every `own`-th row of what was measured, and every `every`-th of the waves.
    pub(super) fn samples(
        &self,
        frame: &Frame,
        own: usize,
        every: usize,
    ) -> Result<Samples, learned::Error> {
        let all = frame.samples(&self.pairs())?;
        let measured = (0..self.measured).step_by(own);
        let rows: Vec<usize> =
            measured.chain((self.measured..all.count()).step_by(every)).collect();
        Ok(all.subset(&rows))
    }
}
