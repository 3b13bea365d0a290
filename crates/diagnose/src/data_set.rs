//! The rows of all records for one output, in SI, on the grid of the model.

use std::ops::Range;
use std::sync::Arc;

use numerics::median;
use surround::Span;

use crate::between::Course;
use crate::thresholds::base::Thresholds;

/// One record.
#[derive(Clone, Debug)]
pub(crate) struct RecordData {
    /// Name in reports.
    pub(crate) name: String,
    /// Times of the run-in in s: rows before `rows` that are simulated, neither fitted nor judged.
    pub(crate) run_in: Vec<f64>,
    /// Rows of the record.
    pub(crate) rows: Range<usize>,
    /// Rows that are fitted, a part of `rows` from its start.
    pub(crate) training: Range<usize>,
    /// Hits of the record on the grid.
    pub(crate) hits: Range<usize>,
    /// End of the hits that the training rows need.
    pub(crate) training_hits_end: usize,
    /// The record's part of the rows of the fit.
    pub(crate) fit: Range<usize>,
    /// Inputs beside the one that is driven, row by row from the run-in on: of a black box in the model's units, else in SI.
    pub(crate) others: Vec<Vec<f64>>,
    /// Command of each row as it was logged, row by row from the run-in on.
    pub(crate) logged: Vec<f64>,
    /// Hit of each of these rows, counted from the record's first.
    pub(crate) hit_of_row: Vec<u32>,
    /// Command under which the machine rests before the first row; none: that of the first row.
    pub(crate) rest: Option<f64>,
}

impl RecordData {
    /// Number of rows from the begin of the record with the command of the first one.
    pub(crate) fn still(&self) -> usize {
        self.logged.iter().take_while(|u| **u == self.logged[0]).count()
    }

    /// Steps of the grid from each row to the next, where they are as many for all.
    fn steps_per_row(&self) -> Option<usize> {
        let mut all = self.hit_of_row.windows(2).map(|pair| (pair[1] - pair[0]) as usize);
        let first = all.next().filter(|steps| *steps > 0)?;
        all.all(|steps| steps == first).then_some(first)
    }
}

/// An auxiliary column.
#[derive(Clone, Debug)]
pub(crate) struct Auxiliary {
    /// Column.
    pub(crate) name: String,
    /// Whether it is another input of the model: a neighbour's command.
    pub(crate) is_command: bool,
    /// Values over the grid, held between rows.
    pub(crate) hits: Vec<f64>,
    /// Range of the column.
    pub(crate) span: Span,
}

impl Auxiliary {
    /// The value that changes nothing: a neighbour's zero, the middle of a temperature's range.
    pub(crate) fn zero(&self) -> f64 {
        if self.is_command { 0.0 } else { self.span.centre }
    }
}

/// All records.
#[derive(Clone, Debug)]
pub(crate) struct DataSet {
    /// Step of the grid in s.
    pub(crate) step: f64,
    /// Time of each row in s.
    pub(crate) time: Vec<f64>,
    /// Median sample time in s.
    pub(crate) sample_time: f64,
    /// Measured output of each row.
    pub(crate) y: Vec<f64>,
    /// Hit at which each row is read.
    pub(crate) row_hit: Vec<u32>,
    /// Command over the grid, held between rows.
    pub(crate) command: Vec<f64>,
    /// Commands of the other axes over the grid, where the model is no black box.
    pub(crate) others: Vec<Arc<Vec<f64>>>,
    /// Auxiliary columns.
    pub(crate) aux: Vec<Auxiliary>,
    /// Records.
    pub(crate) records: Vec<RecordData>,
    /// Rows that enter the normal equations.
    pub(crate) fit_rows: Vec<u32>,
    /// Range of the command.
    pub(crate) command_span: Span,
    /// Range of the output.
    pub(crate) output_span: Span,
    /// Whether the grid is finer than the model says.
    pub(crate) is_finer: bool,
    /// Steps of the grid over which a command is held from each row to the next, where readings are within the rows.
    pub(crate) within: Option<usize>,
}

/// One record as it comes.
pub(crate) struct RecordRows {
    pub(crate) name: String,
    pub(crate) time: Vec<f64>,
    pub(crate) command: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) aux: Vec<Vec<f64>>,
    pub(crate) others: Vec<Vec<f64>>,
    /// Rows from the start that are a run-in.
    pub(crate) run_in: usize,
    /// Part of the other rows that is fitted, 0 to 1.
    pub(crate) training: f64,
}

#[cfg(test)]
impl RecordRows {
    /// Rows of a thousandth of a second in which nothing moves, of which this part is fitted.
    pub(crate) fn still(rows: usize, training: f64) -> Self {
        Self {
            name: "a".to_owned(),
            time: (0..rows).map(|k| 1e-3 * k as f64).collect(),
            command: vec![0.0; rows],
            y: vec![0.0; rows],
            aux: Vec::new(),
            others: Vec::new(),
            run_in: 0,
            training,
        }
    }
}

impl DataSet {
    /// Puts records on a grid; `step` `None`: one hit per row.
    pub(crate) fn new(records: Vec<RecordRows>, aux: &[(String, bool)], step: Option<f64>) -> Self {
        let sample = records.iter().flat_map(|r| r.time.windows(2).map(|w| w[1] - w[0]));
        let shortest = sample.fold(f64::INFINITY, f64::min);
        let mut all = Self {
            step: step.unwrap_or(shortest),
            time: Vec::new(),
            sample_time: 0.0,
            y: Vec::new(),
            row_hit: Vec::new(),
            command: Vec::new(),
            others: Vec::new(),
            aux: Vec::new(),
            records: Vec::new(),
            fit_rows: Vec::new(),
            command_span: Span::of(records.iter().flat_map(|r| r.command.iter().copied())),
            output_span: Span::of(records.iter().flat_map(|r| r.y.iter().copied())),
            is_finer: false,
            within: None,
        };
        all.aux = aux
            .iter()
            .enumerate()
            .map(|(k, (name, is_command))| Auxiliary {
                name: name.clone(),
                is_command: *is_command,
                hits: Vec::new(),
                span: Span::of(records.iter().flat_map(|r| r.aux[k].iter().copied())),
            })
            .collect();
        for record in records {
            all.push(record, step.is_none());
        }
        if step.is_some() {
            let count = all.records.iter().map(|r| r.others.len()).min().unwrap_or(0);
            let of = |k: usize| {
                let mut hits = Vec::with_capacity(all.command.len());
                for record in &all.records {
                    spread(&record.hit_of_row, &record.others[k], &mut hits);
                }
                Arc::new(hits)
            };
            all.others = (0..count).map(of).collect();
        }
        all.choose_fit_rows();
        let rows = all.records.iter().map(|r| &all.time[r.rows.clone()]);
        let mut times: Vec<f64> = rows.flat_map(|t| t.windows(2).map(|w| w[1] - w[0])).collect();
        all.sample_time = median(&mut times).unwrap_or(all.step);
        all
    }

    fn push(&mut self, record: RecordRows, one_hit_per_row: bool) {
        let (row, hit) = (self.time.len(), self.command.len());
        let start = record.time.first().copied().unwrap_or(0.0);
        let hit_of = |k: usize, time: f64| {
            if one_hit_per_row { k } else { ((time - start) / self.step + 1e-6).floor() as usize }
        };
        let times = record.time.iter().enumerate();
        let hits: Vec<u32> = times.map(|(k, t)| hit_of(k, *t) as u32).collect();
        spread(&hits, &record.command, &mut self.command);
        for (k, aux) in self.aux.iter_mut().enumerate() {
            spread(&hits, &record.aux[k], &mut aux.hits);
        }
        let (run_in, time) = record.time.split_at(record.run_in.min(record.time.len()));
        self.row_hit.extend(hits[run_in.len()..].iter().map(|h| hit as u32 + h));
        let rows = row..row + time.len();
        let count = (record.training * rows.len() as f64).round() as usize;
        let training = rows.start..rows.start + count;
        let training_hits_end =
            training.clone().last().map_or(hit, |last| self.row_hit[last] as usize + 1);
        self.time.extend(time);
        self.y.extend(&record.y[run_in.len()..]);
        self.records.push(RecordData {
            name: record.name,
            run_in: run_in.to_vec(),
            rows,
            training,
            hits: hit..self.command.len(),
            training_hits_end,
            fit: 0..0,
            others: record.others,
            logged: record.command,
            hit_of_row: hits,
            rest: None,
        });
    }

    /// These records under the command that the log stands for when it is read so, each record from its own rest.
    pub(crate) fn played(&self, course: Course) -> Self {
        let mut all = self.clone();
        let mut others: Vec<Vec<f64>> = self.others.iter().map(|hits| hits.to_vec()).collect();
        for ((_, times), record) in self.times().zip(&self.records) {
            let steps = record.steps_per_row();
            let play = |logged: &[f64], rest: Option<f64>, hits: &mut [f64]| {
                let held = course.held(&times, logged, steps.unwrap_or(1));
                for (row, pair) in record.hit_of_row.windows(2).enumerate() {
                    let hits = &mut hits[pair[0] as usize + 1..=pair[1] as usize];
                    match steps {
                        Some(steps) => hits.copy_from_slice(&held[row * steps..][..steps]),
                        None => hits.fill(held[row]),
                    }
                }
                if let (Some(first), Some(logged)) = (hits.first_mut(), logged.first()) {
                    *first = rest.unwrap_or(*logged);
                }
            };
            play(&record.logged, record.rest, &mut all.command[record.hits.clone()]);
            for (logged, hits) in record.others.iter().zip(&mut others) {
                play(logged, None, &mut hits[record.hits.clone()]);
            }
        }
        all.others = others.into_iter().map(Arc::new).collect();
        all.command_span = Span::of(all.command.iter().copied());
        all
    }

    /// The first rows of the longest record, so many at most, all in the fit, without auxiliary columns; one hit per row.
    pub(crate) fn begin(&self, rows: usize) -> Option<Self> {
        let record = self.records.iter().max_by_key(|r| r.rows.len())?;
        let (first, run_in) = (record.rows.start, record.run_in.len());
        let count = rows.min(run_in + record.rows.len());
        let judged = first..first + count.saturating_sub(run_in);
        let rows = RecordRows {
            name: record.name.clone(),
            time: [&record.run_in, &self.time[judged.clone()]].concat(),
            command: record.logged[..count].to_vec(),
            y: [&vec![0.0; run_in][..], &self.y[judged]].concat(),
            aux: Vec::new(),
            others: record.others.iter().map(|values| values[..count].to_vec()).collect(),
            run_in,
            training: 1.0,
        };
        let mut all = Self::new(vec![rows], &[], None);
        all.records[0].rest = record.rest;
        Some(all)
    }

    /// These records on a grid with `parts` steps in the place of each.
    pub(crate) fn finer(&self, parts: usize) -> Self {
        self.in_parts(parts, 0)
    }

    /// The records on a grid with `parts` steps in the place of each, for readings within the rows of a held command, the
    /// last of which acts for a row, too; none where the model does not take one step from each row to the next.
    pub(crate) fn within_rows(&self, parts: usize) -> Option<Self> {
        let is_one = |record: &RecordData| record.steps_per_row() == Some(1);
        let are_given = self.records.iter().all(is_one) && self.aux.is_empty();
        are_given.then(|| Self { within: Some(parts), ..self.in_parts(parts, parts) })
    }

    /// The records on a grid with `parts` steps in the place of each, and so many more behind each record.
    fn in_parts(&self, parts: usize, behind: usize) -> Self {
        let mut all = self.clone();
        // A record has its rest, and its steps.
        let of_record = |r: &RecordData, values: &[f64], last: Option<&f64>| {
            let values = &values[r.hits.clone()];
            let last = last.or(values.last()).copied().into_iter();
            let last = last.flat_map(|v| std::iter::repeat_n(v, behind));
            let steps = values[1..].iter().flat_map(|v| std::iter::repeat_n(*v, parts));
            values.first().copied().into_iter().chain(steps).chain(last).collect::<Vec<f64>>()
        };
        let expand = |values: &[f64]| {
            self.records.iter().flat_map(|r| of_record(r, values, None)).collect::<Vec<f64>>()
        };
        let records = self.records.iter();
        all.command = records.flat_map(|r| of_record(r, &self.command, r.logged.last())).collect();
        all.others = self.others.iter().map(|hits| Arc::new(expand(hits))).collect();
        for (aux, given) in all.aux.iter_mut().zip(&self.aux) {
            aux.hits = expand(&given.hits);
        }
        let mut start = 0;
        for (record, given) in all.records.iter_mut().zip(&self.records) {
            let at = |hit: usize| start + (hit - given.hits.start) * parts;
            for row in given.rows.clone() {
                all.row_hit[row] = at(self.row_hit[row] as usize) as u32;
            }
            let training = given.training_hits_end;
            record.training_hits_end =
                if training > given.hits.start { at(training - 1) + 1 + behind } else { start };
            // Inputs that each record drives itself are held from their row on.
            for values in record.others.iter_mut().filter(|_| self.others.is_empty()) {
                *values = values.iter().flat_map(|v| std::iter::repeat_n(*v, parts)).collect();
            }
            record.hit_of_row.iter_mut().for_each(|hit| *hit *= parts as u32);
            let end = at(given.hits.end - 1) + 1 + behind;
            record.hits = start..end;
            start = end;
        }
        all.step /= parts as f64;
        all.is_finer = true;
        all
    }

    /// Whether the model takes several steps from row to row.
    pub(crate) fn has_steps(&self) -> bool {
        self.records.iter().any(|record| record.steps_per_row().is_some_and(|steps| steps > 1))
    }

    fn choose_fit_rows(&mut self) {
        let total: usize = self.records.iter().map(|r| r.training.len()).sum();
        let stride = total.div_ceil(Thresholds::MOST_FIT_ROWS).max(1);
        for record in &mut self.records {
            let first = self.fit_rows.len();
            self.fit_rows.extend(record.training.clone().step_by(stride).map(|row| row as u32));
            record.fit = first..self.fit_rows.len();
        }
    }

    /// These records with some of them left out of the fit and all rows of the others in it.
    pub(crate) fn without(&self, is_left_out: impl Fn(usize) -> bool) -> Self {
        let mut all = self.clone();
        for (k, record) in all.records.iter_mut().enumerate() {
            let (row, hit) = if is_left_out(k) {
                (record.rows.start, record.hits.start)
            } else {
                (record.rows.end, record.hits.end)
            };
            record.training = record.rows.start..row;
            record.training_hits_end = hit;
        }
        all.fit_rows.clear();
        all.choose_fit_rows();
        all
    }

    /// These records with all rows of each in the fit, but for those that are held out as a whole; none where this adds no row.
    pub(crate) fn with_all_rows(&self) -> Option<Self> {
        let is_left_out = |k: usize| self.records[k].training.is_empty();
        let is_split =
            |k: usize| !is_left_out(k) && self.records[k].training.end < self.records[k].rows.end;
        (0..self.records.len()).any(is_split).then(|| self.without(is_left_out))
    }

    /// Measured less simulated at the rows of the fit.
    pub(crate) fn fit_residual(&self, simulated: &[f64]) -> Vec<f64> {
        let at = |row: &u32| {
            let row = *row as usize;
            self.y[row] - simulated[self.row_hit[row] as usize]
        };
        self.fit_rows.iter().map(at).collect()
    }

    /// The simulated output at all rows.
    pub(crate) fn at_rows(&self, simulated: &[f64]) -> Vec<f64> {
        self.row_hit.iter().map(|hit| simulated[*hit as usize]).collect()
    }

    /// Measured less simulated at all rows.
    pub(crate) fn residual(&self, simulated: &[f64]) -> Vec<f64> {
        self.y.iter().zip(&self.row_hit).map(|(y, hit)| y - simulated[*hit as usize]).collect()
    }

    /// Times of all rows of each record, its run-in first, by the first row that is judged.
    pub(crate) fn times(&self) -> impl Iterator<Item = (usize, Vec<f64>)> {
        self.records.iter().map(|record| {
            let judged = &self.time[record.rows.clone()];
            (record.rows.start, [&record.run_in, judged].concat())
        })
    }

    /// Times of the hits of each record, by the record's first row.
    pub(crate) fn hit_times(&self) -> impl Iterator<Item = (usize, Vec<f64>)> {
        self.times().zip(&self.records).map(|((first, times), record)| {
            let mut all = Vec::with_capacity(record.hits.len());
            for (pair, hits) in times.windows(2).zip(record.hit_of_row.windows(2)) {
                let steps = hits[1] - hits[0];
                let part = (pair[1] - pair[0]) / f64::from(steps.max(1));
                all.extend((0..steps).map(|step| pair[0] + part * f64::from(step)));
            }
            let end = times.last().copied().unwrap_or(0.0);
            let rest = record.hits.len().saturating_sub(all.len());
            all.extend((0..rest).map(|step| end + self.step * step as f64));
            (first, all)
        })
    }

    /// Length of the longest record in s.
    pub(crate) fn longest(&self) -> f64 {
        let lengths =
            self.records.iter().map(|r| self.time[r.rows.end - 1] - self.time[r.rows.start]);
        lengths.fold(self.step, f64::max)
    }

    /// Rows of a record that are held out.
    pub(crate) fn held_out(record: &RecordData) -> Range<usize> {
        record.training.end..record.rows.end
    }
}

/// Holds the values of rows over the grid: hit n takes the row that was last before it, hit 0 is the rest under the first
/// row.
fn spread(hit_of_row: &[u32], values: &[f64], into: &mut Vec<f64>) {
    into.extend(values.first());
    for (pair, value) in hit_of_row.windows(2).zip(values) {
        into.extend(std::iter::repeat_n(*value, (pair[1] - pair[0]) as usize));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::between::{Between, Reading};

    /// Two records of twelve rows, the first with a run-in of two.
    fn records() -> DataSet {
        let record = |begin: f64, run_in: usize| RecordRows {
            command: (0..12).map(|k| begin + f64::from(k)).collect(),
            aux: vec![(0..12).map(f64::from).collect()],
            others: vec![(0..12).map(|k| begin + f64::from(k)).collect()],
            run_in,
            ..RecordRows::still(12, 0.5)
        };
        DataSet::new(vec![record(0.0, 2), record(100.0, 0)], &[("T".into(), false)], Some(1e-3))
    }

    #[test]
    fn the_commands_of_other_axes_act_as_the_own_one() {
        let own = records();
        let line = own.played(Course::given(Some(Between::Line), None));
        let finer = line.finer(4);
        assert_ne!(line.command, own.command);
        for data in [own, line, finer] {
            assert_eq!(*data.others[0], data.command);
        }
    }

    #[test]
    fn a_finer_grid_is_that_of_a_model_with_the_shorter_step() {
        let own = records();
        let finer = own.finer(4);
        assert!(finer.has_steps() && !own.has_steps());
        assert_eq!((finer.step, finer.command.len()), (2.5e-4, 2 * (11 * 4 + 1)));
        for (short, long) in finer.records.iter().zip(&own.records) {
            assert_eq!((&short.rows, &short.training), (&long.rows, &long.training));
            let last = short.training.end - 1;
            assert_eq!(short.training_hits_end, finer.row_hit[last] as usize + 1);
            for row in long.rows.clone() {
                let (at, of) = (finer.row_hit[row] as usize, own.row_hit[row] as usize);
                assert_eq!(at - short.hits.start, 4 * (of - long.hits.start));
                // Held, the same command acts at each row.
                assert_eq!(finer.command[at], own.command[of]);
                assert_eq!(finer.aux[0].hits[at], own.aux[0].hits[of]);
            }
        }
        let line = Course { between: Between::Line, reading: Reading::With, is_stepped: true };
        let played = finer.played(line);
        let second = &played.command[finer.records[1].hits.clone()];
        assert_eq!(second[..6], [100.0, 100.0, 100.25, 100.5, 100.75, 101.0]);
    }
}
