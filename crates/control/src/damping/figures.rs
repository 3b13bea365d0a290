//! What is known of a damped loop.

use core::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::gains::Gains;
use super::plants::{Found, Plants};
use super::{Damped, DampedPlant, Damping, DampingFigures};
use crate::loop_shape::{Shape, Shaped, margins};

impl Plants {
    /// What is known of a loop.
    pub(super) fn finished(
        &self,
        best: &Found,
        notch: Option<&Found>,
        axis_plant: &DampedPlant<'_>,
    ) -> Damped {
        let Found { law, gains, .. } = best;
        let laws = self.laws(gains);
        let (mut worst, mut gain_margin, mut phase_margin) = (0.0_f64, f64::INFINITY, PI);
        let (mut peak, mut free) = (0.0_f64, 0.0_f64);
        let (mut width, mut plants) = (PI, 0);
        for plant in &self.values {
            free = plant.iter().map(|value| value.norm()).fold(free, f64::max);
            for slope in self.slopes {
                let found = self.sensitivity(&laws, plant, slope);
                plants += usize::from(found.is_some());
                let found = found.unwrap_or((f64::INFINITY, f64::INFINITY));
                (worst, peak) = (worst.max(found.0), peak.max(found.1));
                width = width.min(self.width(&laws, plant, slope));
                let open: Vec<Complex<f64>> = laws
                    .iter()
                    .zip(plant)
                    .map(|((outer, inner), plant)| (outer - inner) * plant * slope)
                    .collect();
                let (gain, phase) = margins(&open, 1.0, true);
                (gain_margin, phase_margin) = (gain_margin.min(gain), phase_margin.min(phase));
            }
        }
        let in_hz = |angle: f64| angle / (TAU * self.period);
        let crossing = laws
            .iter()
            .zip(&self.values[self.given - 1])
            .position(|(law, plant)| ((law.0 - law.1) * plant * self.slopes[0]).norm() <= 1.0);
        let t = self.period;
        let ki = gains.ki / (t * self.slope);
        let filter = if gains.keep > 0.0 { -t / gains.keep.ln() } else { 0.0 };
        let (a, b) = (gains.kp / gains.ki * t, gains.kd / gains.ki * t * t);
        let shaped = Shaped {
            shape: Shape { name: law.loop_name(), a, b, filter },
            ki,
            sensitivity: worst,
            gain_margin,
            phase_margin,
            bandwidth: in_hz(crossing.map_or(PI, |at| self.angles[at])),
        };
        let settles = |gains: &Gains| {
            let each = self.slopes.map(|slope| self.settling(gains, slope));
            (each[0], each.into_iter().fold(0.0, f64::max))
        };
        let (settling, longest_settling) = settles(gains);
        let is_notch = *law == Damping::Notch;
        let figures = DampingFigures {
            law: law.name(),
            gain: if is_notch { 0.0 } else { gains.gain / self.slope },
            frequency: in_hz(gains.angle),
            filter_damping: law.has_damping().then_some(gains.damping),
            resonance: in_hz(self.first),
            closed_loop_bandwidth: in_hz(self.bandwidth(&laws)),
            least_closed_loop_bandwidth: in_hz(width),
            bandwidth_with_feedforward: (!is_notch)
                .then(|| in_hz(self.with_feedforward(&laws, axis_plant.leads))),
            settling,
            longest_settling,
            notch_settling: notch.map(|notch| settles(&notch.gains)),
            peak,
            undamped_peak: free,
            noise: gains.noise(),
            plants,
        };
        Damped { law: *law, shaped, figures, depth: gains.gain }
    }

    /// Up to which angle the loop with the lead and an exact inverse of the slope in front stays within 3 dB.
    pub(super) fn with_feedforward(
        &self,
        laws: &[(Complex<f64>, Complex<f64>)],
        leads: &[(f64, f64)],
    ) -> f64 {
        let slope = self.slopes[0];
        let plants = self.values[..self.given].iter();
        let widths = plants.map(|plant| {
            let each = laws.iter().zip(plant).zip(&self.back);
            self.within(each.map(|(((outer, inner), plant), back)| {
                let t = self.period;
                let square = back * back;
                let once = (Complex::new(3.0, 0.0) - back * 4.0 + square) / (2.0 * t);
                let twice = (Complex::new(1.0, 0.0) - back * 2.0 + square) / (t * t);
                let lead = leads.iter().map(|(lag, inertia)| 1.0 + once * *lag + twice * *inertia);
                let forward = lead.product::<Complex<f64>>() / slope;
                let (plant, back) = (plant * slope, outer - inner);
                ((forward + back) * plant / (1.0 + back * plant)).norm()
            }))
        });
        widths.fold(PI, f64::min)
    }
}
