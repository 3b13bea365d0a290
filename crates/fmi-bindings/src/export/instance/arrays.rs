//! The variables as FMI 3.0 shows them: arrays where the model has `name[1]`, `name[2]`, …

use model::{DataType, VariableTable};

use super::Instance;
use crate::export::notice::{Notice, Outcome};
use crate::export::phase::Phase;

/// Which elements a value reference of an interface with arrays stands for. The default is that of an
/// interface without: the value references are the model's own.
#[derive(Default)]
pub(super) struct Layout {
    /// By value reference: where its elements begin and end in `elements`; nowhere
    /// where the model's variable is an element of an array, but not the first.
    spans: Vec<(usize, usize)>,
    elements: Vec<u32>,
    /// By element: the value reference of its variable, and for an array its number there.
    homes: Vec<(u32, Option<usize>)>,
}

impl Layout {
    pub(super) fn of(table: &VariableTable) -> Self {
        let mut layout = Self {
            spans: vec![(0, 0); table.len()],
            elements: Vec::with_capacity(table.len()),
            homes: vec![(0, None); table.len()],
        };
        for bundle in table.bundles() {
            let reference = bundle.elements[0];
            let first = layout.elements.len();
            layout.spans[reference as usize] = (first, first + bundle.elements.len());
            for (number, element) in (1..).zip(&bundle.elements) {
                layout.homes[*element as usize] = (reference, bundle.is_array.then_some(number));
            }
            layout.elements.extend(bundle.elements);
        }
        layout
    }

    /// The elements of the variable with this value reference; none if there is no such variable.
    #[inline]
    fn elements(&self, reference: u32) -> &[u32] {
        match self.spans.get(reference as usize) {
            Some((start, end)) => &self.elements[*start..*end],
            None => &[],
        }
    }

    /// Where the model's variable is found.
    pub(super) fn home(&self, element: u32) -> (u32, Option<usize>) {
        self.homes.get(element as usize).copied().unwrap_or((element, None))
    }
}

/// Room for the elements of two lists of variables.
#[derive(Default)]
pub(super) struct Lists {
    knowns: Vec<u32>,
    unknowns: Vec<u32>,
}

impl Lists {
    pub(super) fn of(table: &VariableTable) -> Self {
        let room = || Vec::with_capacity(table.len());
        Self { knowns: room(), unknowns: room() }
    }
}

impl Instance {
    /// Reads variables of one type, arrays spread out; `write` gets position and value. Nothing is
    /// written on failure.
    #[inline]
    pub(in crate::export) fn get_arrays(
        &mut self,
        wanted: DataType,
        references: &[u32],
        count: usize,
        mut write: impl FnMut(usize, f64),
    ) -> Outcome {
        if self.progress.stale && self.progress.phase == Phase::Initialization {
            self.settle()?;
        }
        if let ([reference], 1) = (references, count)
            && let [element] = self.layout.elements(*reference)
            && self.gate(*element, wanted).is_some()
        {
            write(0, self.system.get(*element).unwrap_or(f64::NAN));
            return Ok(());
        }
        self.get_many_arrays(wanted, references, count, write)
    }

    /// Apart from the calls for one scalar, which need few registers.
    #[inline(never)]
    fn get_many_arrays(
        &self,
        wanted: DataType,
        references: &[u32],
        count: usize,
        mut write: impl FnMut(usize, f64),
    ) -> Outcome {
        self.measure(wanted, references, count, true)?;
        let mut at = 0;
        for reference in references {
            if self.time_reference == Some(*reference) {
                write(at, self.progress.time);
                at += 1;
                continue;
            }
            for element in self.layout.elements(*reference) {
                write(at, self.system.get(*element).unwrap_or(f64::NAN));
                at += 1;
            }
        }
        Ok(())
    }

    /// Sets variables of one type, arrays spread out; `read` gives the value at a position. Nothing
    /// is set on failure.
    #[inline]
    pub(in crate::export) fn set_arrays(
        &mut self,
        wanted: DataType,
        references: &[u32],
        count: usize,
        read: impl Fn(usize) -> f64,
    ) -> Outcome {
        if let ([reference], 1) = (references, count)
            && let [element] = self.layout.elements(*reference)
            && self.takes(*element, wanted, read(0))
        {
            self.system.put(*element, read(0));
            self.follow();
            return Ok(());
        }
        self.set_many_arrays(wanted, references, count, read)
    }

    /// Apart from the calls for one scalar, which need few registers.
    #[inline(never)]
    fn set_many_arrays(
        &mut self,
        wanted: DataType,
        references: &[u32],
        count: usize,
        read: impl Fn(usize) -> f64,
    ) -> Outcome {
        let mut at = 0;
        for reference in references {
            let elements = self.layout.elements(*reference);
            if elements.is_empty() || elements.len() > count - at {
                return self.measure(wanted, references, count, false);
            }
            for element in elements {
                if !self.takes(*element, wanted, read(at)) {
                    return Err(self.not_taken(*element, wanted, read(at)));
                }
                at += 1;
            }
        }
        if at < count {
            return self.measure(wanted, references, count, false);
        }
        at = 0;
        for reference in references {
            for element in self.layout.elements(*reference) {
                self.system.put(*element, read(at));
                at += 1;
            }
        }
        self.follow();
        Ok(())
    }

    /// The directional derivative of variables that may be arrays: one component of the seed and one
    /// derivative for each element.
    pub(in crate::export) fn directional_derivative_of_arrays(
        &mut self,
        knowns: &[u32],
        seed: &[f64],
        unknowns: &[u32],
        count: usize,
        write: impl FnMut(usize, f64),
    ) -> Outcome {
        let mut lists = std::mem::take(&mut self.lists);
        let done = self
            .spread(knowns, seed.len(), "seed", &mut lists.knowns)
            .and_then(|()| self.spread(unknowns, count, "sensitivity", &mut lists.unknowns))
            .and_then(|()| {
                self.directional_derivative(&lists.knowns, seed, &lists.unknowns, write)
            });
        self.lists = lists;
        done
    }

    /// The slopes of outputs that may be arrays: one order for each variable, one slope for each
    /// element.
    pub(in crate::export) fn output_slopes_of_arrays(
        &mut self,
        references: &[u32],
        orders: &[i32],
        count: usize,
        write: impl FnMut(usize, f64),
    ) -> Outcome {
        let mut lists = std::mem::take(&mut self.lists);
        let done = self
            .spread(references, count, "values", &mut lists.unknowns)
            .and_then(|()| self.output_slopes(&lists.unknowns, orders, write));
        self.lists = lists;
        done
    }

    /// Writes the elements of these variables, which must be as many as `count`.
    fn spread(
        &self,
        references: &[u32],
        count: usize,
        values: &str,
        list: &mut Vec<u32>,
    ) -> Outcome {
        list.clear();
        for reference in references {
            match self.layout.elements(*reference) {
                [] => return Err(self.unknown(*reference, "Float64")),
                elements => list.extend(elements),
            }
        }
        if list.len() == count {
            return Ok(());
        }
        Err(wrong_count(references.len(), list.len(), count, values))
    }

    /// Whether the variables have this type and, together, this number of values; time is only read.
    fn measure(
        &self,
        wanted: DataType,
        references: &[u32],
        count: usize,
        to_read: bool,
    ) -> Outcome {
        let mut sum = 0;
        for reference in references {
            sum += match self.layout.elements(*reference) {
                [] if to_read
                    && wanted == DataType::Real
                    && self.time_reference == Some(*reference) =>
                {
                    1
                }
                [] => return Err(self.unknown(*reference, self.type_name(wanted))),
                [first, ..] if self.gate(*first, wanted).is_none() => {
                    return Err(self.mismatch(*first, wanted));
                }
                elements => elements.len(),
            };
        }
        if sum == count {
            return Ok(());
        }
        Err(wrong_count(references.len(), sum, count, "values"))
    }
}

#[cold]
fn wrong_count(references: usize, sum: usize, count: usize, values: &str) -> Notice {
    Notice::error(format!(
        "{references} value references but {count} in {values}: the variables have {sum} values \
         together, an array as many as its dimension says; give exactly those"
    ))
}
