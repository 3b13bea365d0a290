//! Which values each run gets.

use data::{Problem, Problems, nearest};

use crate::draw::Draw;
use crate::plan::{Law, Plan, Scalar};
use crate::row::{Cell, Column, ColumnKind};

/// Something that may vary, as the FMUs or the campaign offer it.
#[derive(Clone, Debug)]
pub struct Target {
    /// Name, as in `plant.axis[1].mechanics.frequency`.
    pub name: String,
    /// What its values are.
    pub kind: ColumnKind,
    /// Unit.
    pub unit: Option<String>,
    /// The target's value where nothing varies.
    pub start: Option<f64>,
    /// Least value allowed.
    pub min: f64,
    /// Greatest value allowed.
    pub max: f64,
}

/// Something that varies.
#[derive(Clone, Debug)]
pub struct Variable {
    /// What.
    pub target: Target,
    law: Checked,
}

/// A law whose numbers are good.
#[derive(Clone, Debug)]
enum Checked {
    Normal { mean: f64, deviation: f64 },
    Uniform { low: f64, high: f64 },
    LogUniform { low: f64, high: f64 },
    Integer { low: i64, high: i64 },
    Choice(Vec<Cell>),
    Grid(Vec<Cell>),
}

/// What every run of a sweep gets.
///
/// Grids make combinations, the last grid the fastest; each combination has the plan's number of
/// runs. Run r is run r mod n of its combination, and what is drawn is drawn for that number: all
/// combinations meet the same machines, so that their difference is not that of the draw.
#[derive(Clone, Debug)]
pub struct Design {
    seed: u64,
    repeats: u64,
    runs: u64,
    variables: Vec<Variable>,
}

/// A normal draw beyond the bounds of its variable is drawn again, at most so often.
const TRIES: usize = 10_000;
/// Most runs of a sweep.
const MOST_RUNS: u64 = 100_000_000;
/// Most variables that one pattern may name.
const MOST_NAMED: usize = 10_000;

impl Design {
    /// Checks what a plan varies against what there is. A name may hold `*`, for any characters: each
    /// variable it fits is drawn for itself.
    ///
    /// # Errors
    /// Every problem: names that fit nothing, laws that do not fit the type, values out of bounds.
    pub fn new(plan: &Plan, targets: &[Target]) -> Result<Self, Problems> {
        let (mut variables, mut problems) = (Vec::<Variable>::new(), Vec::new());
        for (name, line, law) in &plan.vary {
            let place = format!("vary.\"{name}\"");
            let found: Vec<&Target> =
                targets.iter().filter(|target| data::fits_pattern(name, &target.name)).collect();
            if found.is_empty() || found.len() > MOST_NAMED {
                let near = nearest(name, targets.iter().map(|target| target.name.as_str()));
                let some = targets.iter().take(3).map(|target| target.name.as_str());
                let some: Vec<&str> = some.collect();
                let way_out = near.map_or_else(
                    || format!("there are {}, such as {}", targets.len(), some.join(", ")),
                    |near| format!("did you mean {near}?"),
                );
                problems.push(plan.problem(*line, &place, "names nothing that may vary", &way_out));
                continue;
            }
            for target in found {
                let rule = if variables.iter().any(|known| known.target.name == target.name) {
                    Err(("is varied twice".to_owned(), "name it once"))
                } else {
                    check(law, target)
                };
                match rule {
                    Ok(law) => variables.push(Variable { target: target.clone(), law }),
                    Err((rule, way_out)) => {
                        let place = match *name == target.name {
                            true => place.clone(),
                            false => format!("{place} ({})", target.name),
                        };
                        problems.push(plan.problem(*line, &place, &rule, way_out));
                    }
                }
            }
        }
        if !problems.is_empty() {
            return Err(Problems::new(problems));
        }
        let (repeats, runs) = count(plan, &variables)?;
        Ok(Design { seed: plan.seed, repeats, runs, variables })
    }

    /// Number of runs.
    #[must_use]
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// What varies.
    #[must_use]
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// The columns of what varies.
    #[must_use]
    pub fn columns(&self) -> Vec<Column> {
        let column = |variable: &Variable| {
            let target = &variable.target;
            Column::new(&target.name, target.kind, target.unit.as_deref())
        };
        self.variables.iter().map(column).collect()
    }

    /// The values of a run, in the order of the variables.
    ///
    /// # Errors
    /// A normal law that finds no value within the bounds of its variable.
    pub fn point(&self, run: u64) -> Result<Vec<Cell>, String> {
        let sample = run % self.repeats;
        let mut combination = run / self.repeats;
        let mut values = vec![Cell::Missing; self.variables.len()];
        for (value, variable) in values.iter_mut().zip(&self.variables).rev() {
            *value = match &variable.law {
                Checked::Grid(cells) => {
                    let count = cells.len() as u64;
                    let at = (combination % count) as usize;
                    combination /= count;
                    cells[at].clone()
                }
                law => draw(law, &variable.target, self.seed, sample)?,
            };
        }
        Ok(values)
    }
}

fn count(plan: &Plan, variables: &[Variable]) -> Result<(u64, u64), Problems> {
    let grids = variables.iter().filter_map(|variable| match &variable.law {
        Checked::Grid(cells) => Some(cells.len() as u64),
        _ => None,
    });
    let has_grid = grids.clone().next().is_some();
    let combinations = grids.fold(1, u64::saturating_mul);
    let repeats = match plan.runs {
        Some(runs) => runs,
        None if has_grid => 1,
        None => {
            let way_out = "add runs = 1000, or a grid under [vary]";
            return Err(plan.problem(0, "runs", "the number of runs is not said", way_out).into());
        }
    };
    let runs = combinations.saturating_mul(repeats);
    if runs > MOST_RUNS {
        let rule = format!("makes {runs} runs; at most {MOST_RUNS} are run");
        return Err(plan.problem(0, "runs", &rule, "take fewer, or shorter grids").into());
    }
    Ok((repeats, runs))
}

fn draw(law: &Checked, target: &Target, seed: u64, run: u64) -> Result<Cell, String> {
    let mut draw = Draw::new(seed, &target.name, run);
    Ok(match law {
        Checked::Normal { mean, deviation } => {
            let values = (0..TRIES).map(|_| mean + deviation * draw.normal());
            let found = values.into_iter().find(|x| (target.min..=target.max).contains(x));
            Cell::Real(found.ok_or_else(|| {
                format!(
                    "{}: no value of the normal law with mean {mean} and deviation {deviation} lies \
                     within {} to {}",
                    target.name, target.min, target.max
                )
            })?)
        }
        Checked::Uniform { low, high } => Cell::Real(draw.between(*low, *high)),
        Checked::LogUniform { low, high } => {
            let value = libm::exp(draw.between(libm::log(*low), libm::log(*high)));
            Cell::Real(value.clamp(*low, *high))
        }
        Checked::Integer { low, high } => match target.kind {
            ColumnKind::Real => Cell::Real(draw.integer(*low, *high) as f64),
            _ => Cell::Integer(draw.integer(*low, *high)),
        },
        Checked::Choice(cells) | Checked::Grid(cells) => {
            let at = draw.integer(0, cells.len() as i64 - 1);
            cells.get(at as usize).cloned().unwrap_or(Cell::Missing)
        }
    })
}

type Refusal = (String, &'static str);

/// The law with its numbers, if it fits the target.
fn check(law: &Law, target: &Target) -> Result<Checked, Refusal> {
    let shown = |kind: ColumnKind| match kind {
        ColumnKind::Real => "a real number",
        ColumnKind::Integer => "a whole number",
        ColumnKind::Truth => "true or false",
        ColumnKind::Text => "a text",
    };
    let real = || match target.kind {
        ColumnKind::Real => Ok(()),
        kind => Err((
            format!("is {}, which this law does not draw", shown(kind)),
            "take choice or grid",
        )),
    };
    let within = |value: f64| {
        let (min, max) = (target.min, target.max);
        if value.is_finite() && (min..=max).contains(&value) {
            return Ok(value);
        }
        let unit = target.unit.as_deref().unwrap_or_default();
        Err((format!("{value} {unit} is not within {min} to {max}"), "stay within its bounds"))
    };
    let spread = |part: f64| match target.start {
        Some(start) if part > 0.0 && part.is_finite() && start != 0.0 => {
            Ok((start, part * start.abs()))
        }
        Some(_) if part > 0.0 && part.is_finite() => Err((
            "has the start value 0, of which no part can be taken".to_owned(),
            "take normal or uniform",
        )),
        Some(_) => {
            Err((format!("{part} is no tolerance"), "give a number greater than 0, as 0.05"))
        }
        None => Err(("has no start value".to_owned(), "take normal or uniform")),
    };
    let ordered = |low: f64, high: f64| match low < high {
        true => Ok(()),
        false => Err((format!("{low} to {high} is no range"), "give the least value first")),
    };
    let cells = |values: &[Scalar]| -> Result<Vec<Cell>, Refusal> {
        if values.is_empty() {
            return Err(("has no value".to_owned(), "list one value or more"));
        }
        let cell = |value: &Scalar| match (target.kind, value) {
            (ColumnKind::Real, Scalar::Real(value)) => within(*value).map(Cell::Real),
            (ColumnKind::Real, Scalar::Integer(value)) => within(*value as f64).map(Cell::Real),
            (ColumnKind::Integer, Scalar::Integer(value)) => {
                within(*value as f64).map(|_| Cell::Integer(*value))
            }
            (ColumnKind::Truth, Scalar::Truth(value)) => Ok(Cell::Truth(*value)),
            (ColumnKind::Text, value) => Ok(Cell::Text(value.to_string())),
            (kind, value) => {
                Err((format!("takes {}, not {value}", shown(kind)), "correct the value"))
            }
        };
        values.iter().map(cell).collect()
    };
    Ok(match law {
        Law::Tolerance(part) => {
            real()?;
            let (mean, deviation) = spread(*part)?;
            Checked::Normal { mean, deviation }
        }
        Law::Within(part) => {
            real()?;
            let (start, half) = spread(*part)?;
            Checked::Uniform { low: within(start - half)?, high: within(start + half)? }
        }
        Law::Normal([mean, deviation]) => {
            real()?;
            if !(*deviation > 0.0 && deviation.is_finite()) {
                return Err((
                    format!("{deviation} is no standard deviation"),
                    "give a number greater than 0",
                ));
            }
            Checked::Normal { mean: within(*mean)?, deviation: *deviation }
        }
        Law::Uniform([low, high]) => {
            real()?;
            ordered(*low, *high)?;
            Checked::Uniform { low: within(*low)?, high: within(*high)? }
        }
        Law::LogUniform([low, high]) => {
            real()?;
            ordered(*low, *high)?;
            if *low <= 0.0 {
                return Err((format!("{low} has no logarithm"), "give values greater than 0"));
            }
            Checked::LogUniform { low: within(*low)?, high: within(*high)? }
        }
        Law::Integer([low, high]) => {
            if !matches!(target.kind, ColumnKind::Real | ColumnKind::Integer) {
                return Err((
                    format!("is {}, no number", shown(target.kind)),
                    "take choice or grid",
                ));
            }
            ordered(*low as f64, *high as f64)?;
            within(*low as f64)?;
            within(*high as f64)?;
            Checked::Integer { low: *low, high: *high }
        }
        Law::Choice(values) => Checked::Choice(cells(values)?),
        Law::Grid(values) => Checked::Grid(cells(values)?),
    })
}

impl Target {
    /// A target without bounds.
    pub fn new(name: impl Into<String>, kind: ColumnKind) -> Self {
        let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
        Target { name: name.into(), kind, unit: None, start: None, min, max }
    }
}

impl From<Problem> for crate::Error {
    fn from(problem: Problem) -> Self {
        crate::Error::Plan(problem.into())
    }
}

#[cfg(test)]
mod tests;
