//! What an inverse learns from: the forward model's answers to what was measured, and to waves that fill its
//! range and band.

use learned::lssvm::Samples;

use super::Frame;
use crate::error::Error;

/// Half cosine waves of random frequency and height within a range around 0 or above it. Half of the signals
/// begin at 0, the others at other levels, with the memory of a rise from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waves {
    /// Number of signals, each with random numbers of its own.
    pub count: usize,
    /// Samples of each.
    pub rows: usize,
    /// In s.
    pub period: f64,
    /// Least and greatest frequency in Hz.
    pub band: [f64; 2],
    /// Least and greatest command.
    pub range: [f64; 2],
    /// Seed of the first signal; each other one has the next.
    pub seed: usize,
}

/// The first seed above those of the papers' random signals.
pub const SEED: usize = 11;
/// The greatest command that the law of the waves is asked for.
const TOP: f64 = 10.0;

impl Waves {
    /// The signals.
    ///
    /// # Errors
    /// [`Error::Learned`] where a setting is out of bounds.
    pub fn commands(&self) -> Result<Vec<Vec<f64>>, Error> {
        (0..self.count).map(|k| self.command(k)).collect()
    }

    fn command(&self, k: usize) -> Result<Vec<f64>, Error> {
        let settings = [
            ("seed", (self.seed + k) as f64),
            ("lowest_frequency", self.band[0]),
            ("highest_frequency", self.band[1]),
            ("top", TOP),
            ("after", if (k / 2).is_multiple_of(2) { 1.0 } else { 0.7 }),
            ("sample_time", self.period),
            ("duration", 1.5 * self.rows as f64 * self.period),
        ];
        let fail = |message: String| Error::Learned { message };
        let law = signals::lookup("p1-c").map_err(|e| fail(e.to_string()))?;
        let signal = law.generate(&settings).map_err(|e| fail(e.to_string()))?;
        let wave = signal.channels.into_iter().next().map(|channel| channel.values);
        let [least, greatest] = self.range;
        // The first wave leads from 0 into the range.
        let eased = |row: usize| (row as f64 * self.period * self.band[1]).min(1.0);
        let command = |(row, u): (usize, f64)| least * eased(row) + (greatest - least) * u / TOP;
        let begin = k % 2 * (k * self.rows / (2 * self.count));
        let all = wave.unwrap_or_default().into_iter().enumerate().map(command);
        Ok(all.skip(begin).take(self.rows).collect())
    }
}

/// The forward model's answers as inputs, the commands as outputs: all rows of what was measured, and every
/// few of the waves.
#[derive(Clone, Debug, PartialEq)]
pub struct SyntheticData {
    commands: Vec<Vec<f64>>,
    answers: Vec<Vec<f64>>,
    measured: usize,
}

impl SyntheticData {
    /// The answers of `forward` to the measured commands and to the waves.
    ///
    /// # Errors
    /// [`Error::Learned`] where a setting of the waves is out of bounds.
    pub fn new(
        measured: &[&[f64]],
        waves: Option<Waves>,
        forward: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Result<Self, Error> {
        let mut commands: Vec<Vec<f64>> = measured.iter().map(|u| u.to_vec()).collect();
        commands.extend(waves.map(|waves| waves.commands()).transpose()?.unwrap_or_default());
        let answers = commands.iter().map(|u| forward(u)).collect();
        Ok(Self { commands, answers, measured: measured.iter().map(|u| u.len()).sum() })
    }

    /// Answer and command of each signal, what was measured first.
    #[must_use]
    pub fn pairs(&self) -> Vec<(&[f64], &[f64])> {
        self.answers.iter().zip(&self.commands).map(|(h, u)| (&h[..], &u[..])).collect()
    }

    /// Every `own`-th row of what was measured, and every `every`-th of the waves.
    ///
    /// # Errors
    /// [`learned::Error`] where samples are too few or not finite.
    pub fn samples(
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
