//! A kernel machine over features of the command.

use data::{ComponentBlueprint, Value};
use learned::features::Features;
use learned::lssvm::{LsSvm, Pruned, Pruning, Report, Samples, Settings, prune};
use learned::{Compressor, KernelSum};
use model::Table;

use super::rms_difference;

/// A range that is mapped onto 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Becomes 0.
    pub low: f64,
    /// Becomes 1.
    pub high: f64,
}

impl Span {
    /// 0 to 1, which leaves numbers as they are.
    pub const UNIT: Self = Self { low: 0.0, high: 1.0 };

    /// From the least to the greatest of these numbers.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if high > low { Self { low, high } } else { Self::UNIT }
    }

    pub(super) fn inward(self, x: f64) -> f64 {
        (x - self.low) / (self.high - self.low)
    }

    pub(super) fn outward(self, x: f64) -> f64 {
        self.low + x * (self.high - self.low)
    }
}

/// What comes before and behind a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// From the command to inputs; it sees the scaled command.
    pub features: Features,
    /// How the command is scaled.
    pub command: Span,
    /// How the output is scaled.
    pub output: Span,
    /// Of a straight line over the scaled command, on which the machine stands: where no sample lies near, it
    /// goes on as this line does. 0 where outputs are fed back.
    pub slope: f64,
    /// What each input is divided by before σ.
    pub widths: Vec<f64>,
    /// Whether late features belong to the latest output, as in real time, and not to an earlier one.
    pub causal: bool,
}

/// How inputs are scaled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recipe {
    /// As the features give them.
    Plain,
    /// Each divided by its standard deviation over all records.
    Standardised,
}

/// A trained machine in its frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// What comes before and behind it.
    pub frame: Frame,
    /// The machine over inputs divided by the widths.
    pub machine: LsSvm,
}

impl Frame {
    /// A frame for these records of command and output.
    #[must_use]
    pub fn new(
        features: Features,
        command: Span,
        output: Span,
        recipe: Recipe,
        records: &[(&[f64], &[f64])],
    ) -> Self {
        let widths = vec![1.0; features.dimension()];
        let mut frame = Self { features, command, output, slope: 0.0, widths, causal: false };
        if recipe == Recipe::Standardised {
            let (inputs, _) = frame.raw(records);
            let d = frame.widths.len();
            let count = (inputs.len() / d).max(1) as f64;
            for k in 0..d {
                let values = || inputs.iter().skip(k).step_by(d);
                let mean = values().sum::<f64>() / count;
                let variance = values().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
                // An input that never moves carries nothing.
                frame.widths[k] = if variance > 1e-24 { variance.sqrt() } else { 1.0 };
            }
        }
        frame
    }

    /// This frame on the straight line of least error for these records.
    #[must_use]
    pub fn on_a_line(mut self, records: &[(&[f64], &[f64])]) -> Self {
        let scaled = |(u, y): (&f64, &f64)| (self.command.inward(*u), self.output.inward(*y));
        let all = || records.iter().flat_map(|(u, y)| u.iter().zip(*y).map(scaled));
        let count = all().count().max(1) as f64;
        let (u0, y0) = all().fold((0.0, 0.0), |(a, b), (u, y)| (a + u / count, b + y / count));
        let (uy, uu) = all().fold((0.0, 0.0), |(uy, uu), (u, y)| {
            (uy + (u - u0) * (y - y0), uu + (u - u0) * (u - u0))
        });
        self.slope = if uu > 0.0 { uy / uu } else { 0.0 };
        self
    }

    /// The scaled command with the stops added to it as they are weighed, from rest under the first command.
    pub(super) fn projected_command(&self, command: &[f64]) -> Vec<f64> {
        let (inputs, _) = self.bare(&self.features, &[(command, command)]);
        let d = self.features.dimension();
        // The last input is the rate.
        inputs.chunks_exact(d).map(|z| z[d - 2]).collect()
    }

    /// Inputs as these features give them and outputs, both scaled, for the commands of these records.
    pub(super) fn bare(
        &self,
        features: &Features,
        records: &[(&[f64], &[f64])],
    ) -> (Vec<f64>, Vec<f64>) {
        let plain = Self {
            features: features.clone(),
            slope: 0.0,
            widths: vec![1.0; features.dimension()],
            ..*self
        };
        plain.raw(records)
    }

    /// This frame with each width times the factor of its input's group.
    #[must_use]
    pub(crate) fn stretched(&self, group: &dyn Fn(usize) -> usize, factors: &[f64]) -> Self {
        let mut stretched = self.clone();
        for (k, width) in stretched.widths.iter_mut().enumerate() {
            *width *= factors.get(group(k)).copied().unwrap_or(1.0);
        }
        stretched
    }

    /// The samples of these records.
    ///
    /// # Errors
    /// [`learned::Error`] where samples are too few or not finite.
    pub fn samples(&self, records: &[(&[f64], &[f64])]) -> Result<Samples, learned::Error> {
        let (inputs, outputs) = self.raw(records);
        Samples::new(self.features.dimension(), inputs, outputs)
    }

    /// Samples by which an output is earlier than the command that completes its features.
    fn late(&self) -> usize {
        if self.causal { 0 } else { self.features.delay() }
    }

    fn raw(&self, records: &[(&[f64], &[f64])]) -> (Vec<f64>, Vec<f64>) {
        let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
        for (command, output) in records {
            let u: Vec<f64> = command.iter().map(|u| self.command.inward(*u)).collect();
            let y: Vec<f64> = output.iter().map(|y| self.output.inward(*y)).collect();
            // A late feature belongs to an earlier output.
            let delay = self.late();
            let d = self.widths.len();
            let all = self.features.of_record(&u, &y);
            inputs.extend_from_slice(all.get(delay * d..).unwrap_or(&[]));
            let bare = y.iter().zip(&u).map(|(y, u)| y - self.slope * u);
            outputs.extend(bare.take(y.len().saturating_sub(delay)));
        }
        for (x, k) in inputs.iter_mut().zip((0..self.widths.len()).cycle()) {
            *x /= self.widths[k];
        }
        (inputs, outputs)
    }

    /// The machine's function over features that are not divided.
    #[must_use]
    pub fn kernel_sum(&self, machine: &LsSvm) -> KernelSum {
        let sigma = machine.sigma2.sqrt();
        let widths: Vec<f64> = self.widths.iter().map(|w| w * sigma).collect();
        let d = self.widths.len();
        let centres: Vec<f64> =
            machine.centres.iter().enumerate().map(|(i, x)| x * self.widths[i % d]).collect();
        KernelSum::new(d, &centres, &machine.weights, &widths, machine.bias)
    }

    /// The response of a machine from rest with output `y0`.
    #[must_use]
    pub fn simulate(&self, machine: &LsSvm, command: &[f64], y0: f64) -> Vec<f64> {
        let mut u: Vec<f64> = command.iter().map(|u| self.command.inward(*u)).collect();
        let delay = self.late();
        // The delay is taken out: the last command is held.
        u.extend(std::iter::repeat_n(u.last().copied().unwrap_or(0.0), delay));
        let f = self.kernel_sum(machine);
        let y = self.features.simulate(&f, &u, self.output.inward(y0), 1e3);
        let position = |(y, u): (&f64, &f64)| self.output.outward(y + self.slope * u);
        y[delay..].iter().zip(&u).map(position).collect()
    }
}

impl Machine {
    /// The table of a component that runs this machine: bias and width of each input, then weight and
    /// centre of each support vector.
    ///
    /// # Errors
    /// A machine without inputs.
    pub fn table(&self) -> Result<Table, String> {
        let sigma = self.machine.sigma2.sqrt();
        let widths = &self.frame.widths;
        let d = widths.len();
        let mut rows = vec![self.machine.bias];
        rows.extend(widths.iter().map(|width| width * sigma));
        if let Features::StopOperators(stops) = &self.frame.features
            && stops.is_projected()
        {
            rows.push(0.0);
            rows.extend_from_slice(&stops.projection);
            rows.extend([0.0; 2]);
        }
        for (weight, centre) in self.machine.weights.iter().zip(self.machine.centres.chunks(d)) {
            rows.push(*weight);
            rows.extend(centre.iter().zip(widths).map(|(x, width)| x * width));
        }
        Table::new(d + 1, rows)
    }

    /// The machine of a table, in this frame, whose widths (and projection, where it has one) become those of the
    /// table.
    ///
    /// # Errors
    /// A table that has not the frame's number of inputs.
    pub fn of_table(mut frame: Frame, table: &Table) -> Result<Self, String> {
        let (d, columns) = (frame.features.dimension(), table.columns());
        let mut rows = table.values().chunks_exact(columns);
        let head = rows.next().filter(|_| columns == d + 1);
        let Some((bias, widths)) = head.and_then(|head| head.split_first()) else {
            return Err(format!("the table has {columns} columns, and {d} inputs need {}", d + 1));
        };
        frame.widths = widths.to_vec();
        if let Features::StopOperators(stops) = &mut frame.features
            && stops.is_projected()
        {
            let row = rows.next().ok_or("the table has no row with the weights of the stops")?;
            stops.projection = row[1..=stops.count].to_vec();
        }
        let (mut weights, mut centres) = (Vec::new(), Vec::new());
        for row in rows {
            weights.push(row[0]);
            centres.extend(row[1..].iter().zip(widths).map(|(x, width)| x / width));
        }
        let machine = LsSvm { dimension: d, centres, weights, bias: *bias, sigma2: 1.0 };
        Ok(Self { frame, machine })
    }

    /// The component that runs this machine on the table of the file `table`, a step in `period` s: from
    /// command to position, or as an inverse from position to command.
    #[must_use]
    pub fn component(&self, inverse: bool, table: &str, period: f64) -> ComponentBlueprint {
        let named = |forward: &str, backward: &str| {
            let component = ComponentBlueprint::new(if inverse { backward } else { forward });
            component.value("table", Value::Text(table.to_owned())).value("sample_time", period)
        };
        let component = match &self.frame.features {
            Features::StopOperators(stops) => named("lssvm-stops", "lssvm-stops-inverse")
                .value("stops", stops.count as f64)
                .value("range", stops.range)
                .value("rate_scale", stops.rate_scale)
                .value("slope", self.frame.slope)
                .value("projected", f64::from(stops.is_projected())),
            Features::Narx(narx) => named("lssvm-narx", "lssvm-inverse")
                .value("past_inputs", narx.commands as f64)
                .value("past_outputs", narx.outputs as f64),
            Features::Derivatives(derivatives) => named("gaussian-process", "gp-inverse")
                .value("inputs", self.frame.widths.len() as f64)
                .value("half", derivatives.half() as f64)
                .value("cutoff", derivatives.cutoff())
                .value("slope", self.frame.slope),
        };
        let (input, output) = (self.frame.command, self.frame.output);
        let (command, position) = if inverse { (output, input) } else { (input, output) };
        component
            .value("command_low", command.low)
            .value("command_high", command.high)
            .value("position_low", position.low)
            .value("position_high", position.high)
    }

    /// Trains on records of command and output.
    ///
    /// # Errors
    /// [`learned::Error`] where samples are too few or not finite, or the training has no exact solution.
    pub fn train(
        frame: Frame,
        records: &[(&[f64], &[f64])],
        settings: Settings,
    ) -> Result<(Self, Report), learned::Error> {
        let samples = frame.samples(records)?;
        Self::train_on(frame, &samples, settings)
    }

    /// Trains on these samples of the frame.
    ///
    /// # Errors
    /// [`learned::Error`] where a setting is not positive or the training has no exact solution.
    pub fn train_on(
        frame: Frame,
        samples: &Samples,
        settings: Settings,
    ) -> Result<(Self, Report), learned::Error> {
        let (machine, report) = LsSvm::train(samples, settings)?;
        Ok((Self { frame, machine }, report))
    }

    /// The response from rest with output `y0`, in simulation mode.
    #[must_use]
    pub fn simulate(&self, command: &[f64], y0: f64) -> Vec<f64> {
        self.frame.simulate(&self.machine, command, y0)
    }

    /// One step ahead: each output from the true outputs before it.
    ///
    /// # Errors
    /// [`learned::Error`] where samples are too few or not finite.
    pub fn one_step(&self, command: &[f64], output: &[f64]) -> Result<Vec<f64>, learned::Error> {
        let samples = self.frame.samples(&[(command, output)])?;
        let (f, mut room) = (self.machine.kernel_sum(), vec![0.0; samples.dimension()]);
        let line = |i: usize| self.frame.slope * self.frame.command.inward(command[i]);
        let value = |i| self.frame.output.outward(f.value(samples.input(i), &mut room) + line(i));
        Ok((0..samples.count()).map(value).collect())
    }

    /// Prunes as Algorithm 1 of the laser beam paper, judged by the simulation of the first record.
    ///
    /// # Errors
    /// [`learned::Error`] where a setting is out of its bounds or a training has no exact solution.
    pub fn prune(
        frame: Frame,
        records: &[(&[f64], &[f64])],
        settings: Settings,
        pruning: Pruning,
    ) -> Result<(Self, Pruned), learned::Error> {
        let judge = |machine: &LsSvm| frame.error(machine, records);
        let pruned = prune(&frame.samples(records)?, settings, pruning, judge)?;
        Ok((Self { machine: pruned.model.clone(), frame }, pruned))
    }

    /// The fewest centres whose simulation errs at most `limit`; `None` where even `most` do not.
    #[must_use]
    pub fn compress(&self, records: &[(&[f64], &[f64])], most: usize, limit: f64) -> Option<Self> {
        let judge = |machine: &LsSvm| self.frame.error(machine, records);
        let machine = Compressor::new(&self.machine, most).smallest(limit, judge)?;
        Some(Self { frame: self.frame.clone(), machine })
    }
}

impl Frame {
    /// Root mean square error of the simulations of all records, each from its first output.
    pub(crate) fn error(&self, machine: &LsSvm, records: &[(&[f64], &[f64])]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (command, output) in records {
            let Some(first) = output.first() else { continue };
            let run = self.simulate(machine, command, *first);
            sum += rms_difference(&run, output).powi(2) * output.len() as f64;
            count += output.len();
        }
        (sum / count.max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use learned::features::Narx;

    use super::*;

    #[test]
    fn a_machine_on_a_line_leads_on_where_nothing_was_shown() {
        use learned::features::StopOperators;
        let truth = |u: f64| 1.0 + 2.0 * u + 0.1 * (3.0 * u).sin();
        let u: Vec<f64> = (0..300).map(|k| 1.0 - (0.05 * f64::from(k)).cos()).collect();
        let y: Vec<f64> = u.iter().map(|u| truth(*u)).collect();
        let records = [(&u[..], &y[..])];
        let stops = StopOperators::new(4, 2.0, 1e-2);
        let features = Features::StopOperators(stops);
        let plain = Frame::new(features, Span::of(&u), Span::of(&y), Recipe::Plain, &records);
        let line = plain.clone().on_a_line(&records);
        assert!(plain.slope == 0.0 && (line.slope - 1.0).abs() < 0.1, "{}", line.slope);
        let settings = Settings { gamma: 1e6, sigma2: 0.1 };
        let error = |frame: Frame| {
            let (machine, _) = Machine::train(frame, &records, settings).unwrap();
            let inside = rms_difference(&machine.simulate(&u, y[0]), &y);
            let outside = machine.simulate(&[0.0, -0.2, -0.4, -0.6, -0.8], y[0]);
            // One step ahead is the same where nothing is fed back.
            let ahead = machine.one_step(&u, &y).unwrap();
            assert!(rms_difference(&ahead, &machine.simulate(&u, y[0])) < 1e-9);
            assert!(inside < 0.01, "{inside}");
            (outside[4] - truth(-0.8)).abs()
        };
        let (with, without) = (error(line), error(plain));
        assert!(with < 0.4 && with < 0.3 * without, "{with} {without}");
    }

    #[test]
    fn a_projection_comes_back_from_the_table() {
        use learned::features::StopOperators;
        let u: Vec<f64> = (0..200).map(|k| 1.0 - (0.07 * f64::from(k)).cos()).collect();
        let y: Vec<f64> = u.iter().map(|u| 3.0 * u + u * u).collect();
        let projection = vec![0.1, 0.0, -0.2];
        let stops = StopOperators { projection, ..StopOperators::new(3, 2.0, 1e-2) };
        let with = |stops: StopOperators| {
            let records = [(&u[..], &y[..])];
            Frame::new(
                Features::StopOperators(stops),
                Span::UNIT,
                Span::UNIT,
                Recipe::Plain,
                &records,
            )
        };
        let settings = Settings { gamma: 1e4, sigma2: 2.0 };
        let (machine, _) =
            Machine::train(with(stops.clone()), &[(&u, &y)], settings).expect("a machine");
        let table = machine.table().expect("a table");
        assert_eq!(table.rows(), machine.machine.weights.len() + 2);
        let blank = with(StopOperators { projection: vec![0.0; 3], ..stops });
        let again = Machine::of_table(blank, &table).expect("the same machine");
        assert_eq!(again.frame.features, machine.frame.features);
        let apart = rms_difference(&again.simulate(&u, y[0]), &machine.simulate(&u, y[0]));
        assert!(apart < 1e-9, "{apart}");
        let component = machine.component(false, "t.npy", 1e-2);
        assert!(component.values.iter().any(|(name, v)| name == "projected" && *v == 1.0.into()));
    }

    #[test]
    fn a_machine_comes_back_from_its_table() {
        let u: Vec<f64> = (0..200).map(|k| (0.07 * f64::from(k)).sin()).collect();
        let y: Vec<f64> = u.iter().map(|u| 3.0 * u + u * u).collect();
        let features = Features::Narx(Narx { commands: 1, outputs: 1 });
        let (command, output) = (Span::of(&u), Span::of(&y));
        let records = [(&u[..], &y[..])];
        let frame = Frame::new(features, command, output, Recipe::Standardised, &records);
        let settings = Settings { gamma: 1e4, sigma2: 2.0 };
        let (machine, _) = Machine::train(frame.clone(), &records, settings).unwrap();
        let table = machine.table().unwrap();
        let again = Machine::of_table(frame.clone(), &table).unwrap();
        let (a, b) = (machine.simulate(&u, y[0]), again.simulate(&u, y[0]));
        assert!(rms_difference(&a, &b) < 1e-9);
        let few = Table::new(3, vec![0.0; 6]).unwrap();
        assert!(Machine::of_table(frame, &few).unwrap_err().contains("3 columns"));
    }
}
