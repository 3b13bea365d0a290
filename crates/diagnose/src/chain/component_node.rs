//! Runs of a component over the records of a data set.

use components::mechanics::MODE;
use model::{ComponentRef, Record, TransferPath};

use super::{ComponentNode, Horizon, ends_finite, ranges};
use crate::data_set::DataSet;
use crate::error::Failed;
use crate::thresholds::fit::Thresholds;

impl ComponentNode {
    /// A component that reads its path alone, with these values in SI.
    pub(crate) fn new(component: ComponentRef, structure: Vec<f64>, values: Vec<f64>) -> Self {
        Self { component, structure, values, links: Vec::new(), reads_command: false }
    }

    /// A mode of the gain 1.
    pub(crate) fn mode(frequency: f64, damping: f64) -> Self {
        let component = ComponentRef::Static(&MODE);
        Self::new(component, Vec::new(), vec![frequency, damping, 1.0])
    }

    /// Values at this point, in SI.
    pub(crate) fn values_at(&self, theta: &[f64]) -> Vec<f64> {
        let mut values = self.values.clone();
        for link in &self.links {
            if let (Some(value), Some(q)) = (values.get_mut(link.index), theta.get(link.parameter))
            {
                *value += link.deviation * q;
            }
        }
        values
    }

    /// Runs the records of a data set side by side, from `x` to `out`, which are over its grid.
    pub(crate) fn run_records(
        &self,
        theta: &[f64],
        (data, horizon): (&DataSet, Horizon),
        x: &[f64],
        out: &mut [f64],
    ) -> Result<(), Failed> {
        let count = if self.reads_command { 2 } else { 1 };
        let (mut rest, mut at) = (out, 0);
        let mut records = Vec::with_capacity(data.records.len());
        for (_, range) in ranges(data, horizon) {
            let (out, behind) = rest[range.start - at..].split_at_mut(range.len());
            (rest, at) = (behind, range.end);
            let inputs = [&x[range.clone()], &data.command[range]];
            records.push(Record { inputs, count, out, state: Vec::new() });
        }
        self.run(theta, data.step, &mut records)
    }

    /// Adds to `out` what changes where values change from `before` to `after`, by the parts that take them. False where
    /// that is no less work than a run of the component, or it has no parts.
    pub(crate) fn add_change(
        &self,
        (before, after): (&[f64], &[f64]),
        (data, horizon): (&DataSet, Horizon),
        x: &[f64],
        out: &mut [f64],
    ) -> Result<bool, Failed> {
        let pairs = before.iter().zip(after).enumerate();
        let changed: Vec<usize> = pairs.filter(|(_, (a, b))| a != b).map(|(k, _)| k).collect();
        if changed.is_empty() {
            return Ok(true);
        }
        let parts = (0..).map_while(|number| self.component.part(&self.structure, number));
        let parts: Vec<TransferPath> = parts.collect();
        if parts.len() < 4 * changed.len() {
            return Ok(false);
        }
        let mut values = before.to_vec();
        let mut moved = vec![0.0; out.len()];
        for k in changed {
            let Some(part) = parts.iter().find(|part| part.takes.contains(&k)) else {
                return Ok(false);
            };
            for (sign, value) in [(-1.0, before[k]), (1.0, after[k])] {
                values[k] = value;
                let component = ComponentRef::Static(part.component);
                let own = part.takes.iter().map(|k| values[*k]).collect();
                let of_part = Self::new(component, part.structure.clone(), own);
                of_part.run_records(&[], (data, horizon), x, &mut moved)?;
                out.iter_mut().zip(&moved).for_each(|(sum, moved)| *sum += sign * moved);
            }
        }
        Ok(true)
    }

    /// Runs records side by side.
    fn run(&self, theta: &[f64], step: f64, records: &mut [Record<'_>]) -> Result<(), Failed> {
        let component = &self.component;
        let sizes = component.sizes(&self.structure, step);
        let mut coefficients = vec![0.0; sizes.coefficients];
        let mut outputs = vec![0.0; component.declaration().outputs.len()];
        let values = self.values_at(theta);
        component.prepare(&self.structure, &values, step, &mut coefficients).map_err(|_| Failed)?;
        for records in records.chunks_mut(Thresholds::ABREAST) {
            for record in &mut *records {
                record.state.resize(sizes.states, 0.0);
                let first = record.inputs.map(|signal| signal[0]);
                let first = &first[..record.count];
                component.rest(&coefficients, first, &mut record.state, &mut outputs);
                record.out[0] = outputs.first().copied().unwrap_or(f64::NAN);
            }
            // Shorter records end first.
            records.sort_by_key(|record| std::cmp::Reverse(record.out.len()));
            let mut next = 1;
            for under_way in (1..=records.len()).rev() {
                let records = &mut records[..under_way];
                let end = records.last().map_or(next, |shortest| shortest.out.len());
                component.step_records(&coefficients, step, next..end, records, &mut outputs);
                next = next.max(end);
            }
        }
        records.iter().try_for_each(|record| ends_finite(record.out))
    }
}
