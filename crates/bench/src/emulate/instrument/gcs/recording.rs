//! Wave generators and data recorder of the emulated controller.

use super::super::generator::{Generator, Seen};
use super::waves::{MOST_POINTS, segment};
use super::{
    ANALOG_ACTIVE, GENERATOR_ACTIVE, GcsInstrument, NO_WAVE, OUT_OF_RANGE, RECORDER_OPTION,
    RECORDER_TABLE, SYNTAX, TABLES, lines,
};

/// Triggers of the recorder: commands that move an axis, the next command.
pub(super) const MOVES: u8 = 1;
pub(super) const NEXT: u8 = 2;
const AT_ONCE: u8 = 4;

const OPTIONS: &str = "#RecordOptions \n0=Nothing \n1=Target Position of Axis \n2=Actual Position of Axis \n\
    3=Position Error of Axis \n7=Control Voltage of Output Channel \n#TriggerOptions \n0=default setting \n\
    1=any command changing position \n2=next command \n4=trigger immediately \n#Additional information \n\
    8 record tables \n32768 datapoints per table \nend of help\n";

type Answer = Result<String, i32>;

fn number<T: std::str::FromStr>(word: &str) -> Result<T, i32> {
    word.parse().map_err(|_| SYNTAX)
}

/// An answer of one line for each place, counted from 1.
fn each(places: &[usize], of: impl Fn(usize) -> String) -> String {
    lines(places.iter().map(|n| format!("{}={}", n + 1, of(*n))))
}

/// An array as GCS tells it: a header, then a row for each value.
fn array(names: &[String], period: f64, columns: &[Vec<f64>]) -> String {
    let rows = columns.first().map_or(0, Vec::len);
    let mut text = format!(
        "# REM Piezoloop \n#  \n# VERSION = 1 \n# TYPE = 1 \n# SEPARATOR = 32 \n# DIM = {} \n# SAMPLE_TIME = {period} \n# NDATA = {rows} \n#  \n",
        columns.len()
    );
    for (n, name) in names.iter().enumerate() {
        text += &format!("# NAME{n} = {name} \n");
    }
    text += "#  \n# END_HEADER \n";
    for row in 0..rows {
        let values: Vec<String> = columns.iter().map(|c| format!("{:.6}", c[row])).collect();
        text += &values.join(" ");
        text += if row + 1 == rows { "\n" } else { " \n" };
    }
    text
}

impl GcsInstrument {
    /// Places of these numbers from 1, up to `most`; of none, or of 0, all.
    fn numbered(&self, words: &[&str], most: usize, error: i32) -> Result<Vec<usize>, i32> {
        if words.is_empty() || words == ["0"] {
            return Ok((0..most).collect());
        }
        let place = |word: &&str| {
            let number = number::<usize>(word)?.checked_sub(1).filter(|n| *n < most);
            number.ok_or(error)
        };
        words.iter().map(place).collect()
    }

    /// Sets a value of each generator named in words of `width`.
    fn set(
        &mut self,
        words: &[&str],
        width: usize,
        mut set: impl FnMut(&mut Generator, &[&str]) -> Result<(), i32>,
    ) -> Answer {
        if words.is_empty() || !words.len().is_multiple_of(width) {
            return Err(SYNTAX);
        }
        for words in words.chunks(width) {
            for n in self.numbered(&words[..1], self.plays.len(), OUT_OF_RANGE)? {
                set(&mut self.stage.generators[n], &words[1..])?;
            }
        }
        Ok(String::new())
    }

    /// A command of the wave generator; none: it is not one.
    pub(super) fn generate(&mut self, name: &str, words: &[&str]) -> Option<Answer> {
        let axes = self.plays.len();
        let all = |me: &Self| me.numbered(words, axes, OUT_OF_RANGE);
        let generator = |me: &Self, n: usize| me.stage.generators[n].clone();
        Some(match name {
            "TWG?" => Ok(format!("{axes}\n")),
            "WAV" => words.split_first().ok_or(SYNTAX).and_then(|(table, words)| {
                let table = self.table(table)?;
                segment(&mut self.tables[table], words).map(|()| String::new())
            }),
            "WAV?" => {
                self.numbered(words.get(..1).unwrap_or(&[]), TABLES, OUT_OF_RANGE).map(|all| {
                    lines(all.iter().map(|n| format!("{} 1={}", n + 1, self.tables[*n].len())))
                })
            }
            "WMS?" => self
                .numbered(words, TABLES, OUT_OF_RANGE)
                .map(|all| each(&all, |_| (MOST_POINTS / TABLES).to_string())),
            "WCL" => self.numbered(words, TABLES, OUT_OF_RANGE).map(|all| {
                all.iter().for_each(|n| self.tables[*n].clear());
                String::new()
            }),
            "GWD?" => self.wave(words),
            "WSL" => self.connect(words),
            "WSL?" => all(self).map(|all| each(&all, |n| self.plays[n].to_string())),
            "WGC" => self.set(words, 2, |generator, words| {
                generator.cycles = number(words[0])?;
                Ok(())
            }),
            "WGC?" => all(self).map(|all| each(&all, |n| generator(self, n).cycles.to_string())),
            "WTR" => self.set(words, 3, |generator, words| {
                let hold = number::<u32>(words[0])?;
                if hold == 0 || !matches!(words[1], "0" | "1") {
                    return Err(OUT_OF_RANGE);
                }
                generator.hold = hold;
                Ok(())
            }),
            "WTR?" => all(self).map(|all| each(&all, |n| format!("{} 0", generator(self, n).hold))),
            "WOS" => self.set(words, 2, |generator, words| {
                generator.offset = number(words[0])?;
                Ok(())
            }),
            "WOS?" => {
                all(self).map(|all| each(&all, |n| format!("{:+.6}", generator(self, n).offset)))
            }
            "WGO" => self.go(words),
            "WGO?" => all(self)
                .map(|all| each(&all, |n| u8::from(generator(self, n).is_running()).to_string())),
            _ => return None,
        })
    }

    fn table(&self, word: &str) -> Result<usize, i32> {
        Ok(self.numbered(&[word], TABLES, OUT_OF_RANGE)?[0])
    }

    fn connect(&mut self, words: &[&str]) -> Answer {
        if self.playing() != 0 {
            return Err(GENERATOR_ACTIVE);
        }
        if words.is_empty() || !words.len().is_multiple_of(2) {
            return Err(SYNTAX);
        }
        for pair in words.chunks(2) {
            let table = number::<usize>(pair[1])?;
            if table > TABLES {
                return Err(OUT_OF_RANGE);
            }
            for n in self.numbered(&pair[..1], self.plays.len(), OUT_OF_RANGE)? {
                self.plays[n] = table;
            }
        }
        Ok(String::new())
    }

    fn go(&mut self, words: &[&str]) -> Answer {
        if words.is_empty() || !words.len().is_multiple_of(2) {
            return Err(SYNTAX);
        }
        let mut starts = Vec::new();
        for pair in words.chunks(2) {
            let mode = number::<u32>(pair[1])?;
            let all = self.numbered(&pair[..1], self.plays.len(), OUT_OF_RANGE)?;
            starts.extend(all.into_iter().map(|n| (n, mode & 1 == 1)));
        }
        let table = |me: &Self, n: usize| me.plays[n].checked_sub(1).map(|t| me.tables[t].clone());
        if starts.iter().any(|(n, on)| *on && table(self, *n).is_none_or(|t| t.is_empty())) {
            return Err(NO_WAVE);
        }
        if starts.iter().any(|(n, on)| *on && self.stage.analog(*n).is_some()) {
            return Err(ANALOG_ACTIVE);
        }
        for (n, on) in &starts {
            let table = table(self, *n);
            let generator = &mut self.stage.generators[*n];
            match on {
                true => {
                    generator.table = table.unwrap_or_default();
                    generator.start();
                }
                false => generator.stop(),
            }
        }
        if starts.iter().any(|(_, on)| *on) {
            self.stage.recorder.start();
        }
        Ok(String::new())
    }

    /// GWD? first count tables.
    fn wave(&self, words: &[&str]) -> Answer {
        let [first, count, tables @ ..] = words else { return Err(SYNTAX) };
        let (first, count) = (number::<usize>(first)?, number::<usize>(count)?);
        let tables = self.numbered(tables, TABLES, OUT_OF_RANGE)?;
        let part = |n: &usize| {
            let table = &self.tables[*n];
            let first = first.checked_sub(1).filter(|first| first + count <= table.len());
            first.map(|first| table[first..first + count].to_vec()).ok_or(OUT_OF_RANGE)
        };
        let columns = tables.iter().map(part).collect::<Result<Vec<_>, i32>>()?;
        let names: Vec<String> = tables.iter().map(|n| format!("Wave Table {}", n + 1)).collect();
        Ok(array(&names, self.stage.period(), &columns))
    }

    /// A command of the data recorder; none: it is not one.
    pub(super) fn record(&mut self, name: &str, words: &[&str]) -> Option<Answer> {
        let tables = |me: &Self| me.numbered(words, TABLES, RECORDER_TABLE);
        Some(match name {
            "TNR?" => Ok(format!("{TABLES}\n")),
            "HDR?" => Ok(OPTIONS.to_owned()),
            "RTR?" => Ok(format!("{}\n", self.stage.recorder.every)),
            "RTR" => match words {
                [every] => number::<u32>(every).and_then(|every| {
                    self.stage.recorder.every =
                        Some(every).filter(|n| *n > 0).ok_or(OUT_OF_RANGE)?;
                    Ok(String::new())
                }),
                _ => Err(SYNTAX),
            },
            "DRC" => self.configure(words),
            "DRC?" => tables(self).map(|all| {
                each(&all, |n| {
                    let (axis, seen) = self.stage.recorder.sources[n];
                    format!("{} {}", axis + 1, option_of(seen))
                })
            }),
            "DRT" => match words {
                [_, source, ..] => number::<u8>(source).and_then(|source| {
                    if !matches!(source, 0 | MOVES | NEXT | AT_ONCE) {
                        return Err(OUT_OF_RANGE);
                    }
                    self.trigger = source;
                    if source == AT_ONCE {
                        self.stage.recorder.start();
                        self.trigger = 0;
                    }
                    Ok(String::new())
                }),
                _ => Err(SYNTAX),
            },
            "DRT?" => tables(self).map(|all| each(&all, |_| format!("{} 0", self.trigger))),
            "DRL?" => tables(self)
                .map(|all| each(&all, |n| self.stage.recorder.tables[n].len().to_string())),
            "DRR?" => self.recorded(words),
            "STE" => self.pairs(words).and_then(|pairs| {
                let words: Vec<String> = pairs
                    .iter()
                    .flat_map(|(n, value)| [(n + 1).to_string(), value.to_string()])
                    .collect();
                let words: Vec<&str> = words.iter().map(String::as_str).collect();
                let answer = self.moved(&words, true)?;
                self.stage.recorder.start();
                Ok(answer)
            }),
            _ => return None,
        })
    }

    fn configure(&mut self, words: &[&str]) -> Answer {
        if words.is_empty() || !words.len().is_multiple_of(3) {
            return Err(SYNTAX);
        }
        let mut sources = self.stage.recorder.sources.clone();
        for words in words.chunks(3) {
            let seen = seen_of(number(words[2])?).ok_or(RECORDER_OPTION)?;
            let axis = self.places(&words[1..2])?[0];
            for table in self.numbered(&words[..1], TABLES, RECORDER_TABLE)? {
                sources[table] = (axis, seen);
            }
        }
        self.stage.recorder.sources = sources;
        Ok(String::new())
    }

    /// DRR? first count tables: what is not recorded yet is 0.
    fn recorded(&self, words: &[&str]) -> Answer {
        let recorder = &self.stage.recorder;
        let [first, count, tables @ ..] = words else { return Err(SYNTAX) };
        let (first, count) = (number::<usize>(first)?, number::<usize>(count)?);
        if first == 0 || count == 0 || first - 1 + count > recorder.length {
            return Err(OUT_OF_RANGE);
        }
        let tables = self.numbered(tables, TABLES, RECORDER_TABLE)?;
        let column = |n: &usize| -> Vec<f64> {
            let rest = recorder.tables[*n].iter().skip(first - 1).copied();
            rest.chain(std::iter::repeat(0.0)).take(count).collect()
        };
        let name = |n: &usize| {
            let (axis, seen) = recorder.sources[*n];
            let what = match seen {
                Seen::Nothing => "Nothing of",
                Seen::Target => "Target Position of",
                Seen::Position => "Actual Position of",
                Seen::Error | Seen::AbsoluteError => "Position Error of",
                Seen::Voltage => "Control Voltage of",
            };
            format!("{what} Axis AXIS:{}", axis + 1)
        };
        let period = self.stage.period() * f64::from(recorder.every);
        let names: Vec<String> = tables.iter().map(name).collect();
        let columns: Vec<Vec<f64>> = tables.iter().map(column).collect();
        Ok(array(&names, period, &columns))
    }
}

fn seen_of(option: u32) -> Option<Seen> {
    Some(match option {
        0 => Seen::Nothing,
        1 => Seen::Target,
        2 => Seen::Position,
        3 => Seen::Error,
        7 => Seen::Voltage,
        _ => return None,
    })
}

fn option_of(seen: Seen) -> u32 {
    match seen {
        Seen::Nothing => 0,
        Seen::Target => 1,
        Seen::Position => 2,
        Seen::Error | Seen::AbsoluteError => 3,
        Seen::Voltage => 7,
    }
}
