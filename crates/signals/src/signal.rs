//! A generated signal.

/// Channels on the grid t = n·T, n = 0 … N − 1; all channels have N values.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Sample time T in s.
    pub period: f64,
    /// The channels, in the order of the declaration.
    pub channels: Vec<Channel>,
}

/// One channel of a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name.
    pub name: String,
    /// Unit of the values.
    pub unit: String,
    /// Value n acts from n·T until (n + 1)·T.
    pub values: Vec<f64>,
}

impl Signal {
    /// Number of samples N.
    #[must_use]
    pub fn len(&self) -> usize {
        self.channels.first().map_or(0, |channel| channel.values.len())
    }

    /// Whether there is no sample; never so for a generated signal.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Time of sample `n` in s: n·T, not a running sum.
    #[must_use]
    pub fn time(&self, n: usize) -> f64 {
        n as f64 * self.period
    }

    /// Length of the record in s: N·T.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.time(self.len())
    }

    /// The channel of this name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }
}

impl Channel {
    /// Least value.
    #[must_use]
    pub fn minimum(&self) -> f64 {
        self.values.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Greatest value.
    #[must_use]
    pub fn maximum(&self) -> f64 {
        self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Crest factor of the alternating part, max|x − x̄| / rms(x − x̄); `None` for a constant.
    #[must_use]
    pub fn crest_factor(&self) -> Option<f64> {
        let count = self.values.len() as f64;
        let mean = self.values.iter().sum::<f64>() / count;
        let peak = self.values.iter().map(|x| (x - mean).abs()).fold(0.0, f64::max);
        let square = self.values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count;
        let constant = peak <= 1e-12 * mean.abs() || square == 0.0;
        (!constant).then(|| peak / libm::sqrt(square))
    }

    /// This shape as another quantity: values times `gain`, under another name and unit. A
    /// voltage becomes a reference position in this way.
    #[must_use]
    pub fn scaled(&self, gain: f64, name: &str, unit: &str) -> Self {
        let values = self.values.iter().map(|x| gain * x).collect();
        Self { name: name.to_owned(), unit: unit.to_owned(), values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(values: &[f64]) -> Channel {
        Channel { name: "u".into(), unit: "V".into(), values: values.to_vec() }
    }

    #[test]
    fn crest_factors_of_known_shapes() {
        assert_eq!(channel(&[1.0, 3.0, 1.0, 3.0]).crest_factor(), Some(1.0));
        assert_eq!(channel(&[7.3; 10]).crest_factor(), None);
        let sine = |n| libm::sin(2.0 * std::f64::consts::PI * f64::from(n) / 400.0);
        let sine: Vec<f64> = (0..400).map(sine).collect();
        let crest = channel(&sine).crest_factor().unwrap_or(0.0);
        assert!((crest - std::f64::consts::SQRT_2).abs() < 1e-12, "{crest}");
    }

    #[test]
    fn a_scaled_channel_has_its_own_name_and_unit() {
        let reference = channel(&[0.0, 30.0]).scaled(0.2, "r", "um");
        assert_eq!((reference.name.as_str(), reference.unit.as_str()), ("r", "um"));
        assert_eq!((reference.minimum(), reference.maximum()), (0.0, 6.0));
    }
}
