//! Parameters and analog inputs of the emulated controller.
//!
//! The law of the servo has the form of PI's digital piezo controllers: P, an integrator with the time constant T_i
//! (output = Ts/T_i·Σ input), a differentiator with T_d (output = T_d/Ts·Δ input), each for itself; two notch filters
//! N(s) = (s² + 2·r·ω·s + ω²)/(s + ω)² with frequency and rejection r (1: off), for a bandwidth of 1.
//!
//! Source: PI, E-727 user manual E727T0005, "Control Details" and "Parameters"; how the three parts of the law come
//! together, and the filter's equation, are not printed there: r is the gain at its frequency, and 1 is no filter. The
//! analog inputs: `inputs.rs`.

use super::{
    GcsInstrument, OUT_OF_RANGE, PASSWORD, PROTECTED, READ_ONLY, SYNTAX, UNKNOWN_PARAMETER, lines,
};

/// Parameters: number, least command level for a change, type, item, name.
const PARAMETERS: [(u32, u8, &str, &str, &str); 18] = [
    (OFFSET, 1, "FLOAT", "channel", "Sensor Mech. Correction 1"),
    (GAIN, 1, "FLOAT", "channel", "Sensor Mech. Correction 2"),
    (SOURCE, 1, "INT", "axis", "ADC Channel For Target"),
    (ADDED, 1, "FLOAT", "axis", "Analog Target Offset"),
    (P, 0, "FLOAT", "axis", "Servo Loop P-Term"),
    (TI, 0, "FLOAT", "axis", "Servo Loop I-Term"),
    (TD, 0, "FLOAT", "axis", "Servo Loop D-Term"),
    (0x0700_0000, 9, "FLOAT", "axis", "Range Limit min"),
    (0x0700_0001, 9, "FLOAT", "axis", "Range Limit max"),
    (0x0800_0100, 1, "FLOAT", "axis", "Notch frequency 1"),
    (0x0800_0101, 1, "FLOAT", "axis", "Notch frequency 2"),
    (0x0800_0200, 1, "FLOAT", "axis", "Notch Rejection 1"),
    (0x0800_0201, 1, "FLOAT", "axis", "Notch Rejection 2"),
    (0x0800_0300, 1, "FLOAT", "axis", "Notch Bandwidth 1"),
    (0x0800_0301, 1, "FLOAT", "axis", "Notch Bandwidth 2"),
    (0x0E00_0200, 9, "FLOAT", "system", "Servo Update Time"),
    (0x1600_0200, 9, "INT", "system", "Data Recorder Max Points"),
    (0x1600_0300, 9, "INT", "system", "Data Recorder Chan Number"),
];
const OFFSET: u32 = 0x0200_0200;
const GAIN: u32 = 0x0200_0300;
const SOURCE: u32 = 0x0600_0500;
const ADDED: u32 = 0x0600_0501;
const P: u32 = 0x0700_0300;
const TI: u32 = 0x0700_0301;
const TD: u32 = 0x0700_0302;
/// Notch filters are below so much of the servo rate.
const MOST_NOTCH: f64 = 0.45;

type Answer = Result<String, i32>;

fn id(word: &str) -> Result<u32, i32> {
    let lower = word.to_ascii_lowercase();
    let number = match lower.strip_prefix("0x") {
        Some(hex) => u32::from_str_radix(hex, 16),
        None => lower.parse(),
    };
    number.map_err(|_| SYNTAX)
}

impl GcsInstrument {
    /// A command on parameters or analog inputs; none: it is not one.
    pub(super) fn parameter(&mut self, name: &str, words: &[&str]) -> Option<Answer> {
        let done = String::new;
        let axes = self.stage.axes.len();
        Some(match name {
            "CCL?" => Ok(format!("{}\n", self.level)),
            "CCL" => match words {
                ["0"] => {
                    self.level = 0;
                    Ok(done())
                }
                ["1", "advanced"] => {
                    self.level = 1;
                    Ok(done())
                }
                ["1", ..] => Err(PASSWORD),
                _ => Err(OUT_OF_RANGE),
            },
            "SPA?" | "SEP?" => self.ask(words),
            "SPA" => self.write(words).map(|()| done()),
            "RPA" => {
                self.stage.servos = self.stage.saved.clone();
                self.stage.inputs.now = self.stage.inputs.saved.clone();
                Ok(done())
            }
            "WPA" if words.first() == Some(&"100") => {
                self.stage.saved = self.stage.servos.clone();
                self.stage.inputs.saved = self.stage.inputs.now.clone();
                Ok(done())
            }
            "WPA" => Err(PASSWORD),
            "HPA?" => {
                let line = |(id, level, form, item, name): &(u32, u8, &str, &str, &str)| {
                    format!("0x{id:08X}= {level} 1 {form} {item} {name}")
                };
                Ok("The following parameters are valid: \n".to_owned()
                    + &lines(PARAMETERS.iter().map(line).chain(["end of help".to_owned()])))
            }
            "TSC?" => Ok(format!("{}\n", 2 * axes)),
            "TPC?" => Ok(format!("{axes}\n")),
            "TSP?" => self.inputs(words, |[_, scaled]| format!("{scaled:.6}")),
            "TNS?" => self.inputs(words, |[normalized, _]| format!("{normalized:.6}")),
            "TAD?" => self.inputs(words, |[normalized, _]| {
                format!("{:.0}", 65_535.0 * (0.005 * normalized + 0.5))
            }),
            "AOS" => self.pairs(words).map(|pairs| {
                pairs.iter().for_each(|(n, value)| self.stage.inputs.now.offsets[*n] = *value);
                done()
            }),
            "AOS?" => self.places(words).map(|places| {
                let offset = |n: &usize| self.stage.inputs.now.offsets[*n];
                lines(places.iter().map(|n| format!("{}={:+.6}", n + 1, offset(n))))
            }),
            _ => return None,
        })
    }

    /// Input signals: sensors of the axes, then analog inputs. `of`: from the value normalized and scaled.
    fn inputs(&self, words: &[&str], of: impl Fn([f64; 2]) -> String) -> Answer {
        let places = match words {
            [] => (0..2 * self.stage.axes.len()).collect(),
            _ => words.iter().map(|word| self.channel(word)).collect::<Result<Vec<_>, i32>>()?,
        };
        let line = |n: &usize| format!("{}={}", n + 1, of(self.stage.input(*n)));
        Ok(lines(places.iter().map(line)))
    }

    /// The place of an input signal.
    fn channel(&self, word: &str) -> Result<usize, i32> {
        let number = word.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
        number.filter(|n| *n < 2 * self.stage.axes.len()).ok_or(OUT_OF_RANGE)
    }

    /// The place of a parameter's item: an input signal or an axis.
    fn item(&self, word: &str, id: u32) -> Result<usize, i32> {
        match id {
            OFFSET | GAIN => self.channel(word),
            _ => Ok(self.places(&[word])?[0]),
        }
    }

    /// Items that have a parameter.
    fn items(&self, id: u32) -> usize {
        self.stage.axes.len() * if matches!(id, OFFSET | GAIN) { 2 } else { 1 }
    }

    fn ask(&self, words: &[&str]) -> Answer {
        let all: Vec<(String, u32)> = match words {
            [] => PARAMETERS
                .iter()
                .flat_map(|p| (1..=self.items(p.0)).map(|n| (n.to_string(), p.0)))
                .collect(),
            _ if words.len().is_multiple_of(2) => words
                .chunks(2)
                .map(|pair| Ok((pair[0].to_owned(), id(pair[1])?)))
                .collect::<Result<_, i32>>()?,
            _ => return Err(SYNTAX),
        };
        let line = |(item, id): &(String, u32)| {
            Ok(format!("{item} 0x{id:08X}={}", self.value(self.item(item, *id)?, *id)?))
        };
        Ok(lines(all.iter().map(line).collect::<Result<Vec<_>, i32>>()?.into_iter()))
    }

    fn value(&self, item: usize, id: u32) -> Result<String, i32> {
        let usage = &self.stage.inputs.now;
        match id {
            OFFSET => Ok(usage.scales[item][0].to_string()),
            GAIN => Ok(usage.scales[item][1].to_string()),
            SOURCE => Ok(usage.sources[item].to_string()),
            ADDED => Ok(usage.offsets[item].to_string()),
            _ => self.value_of_servo(item, id),
        }
    }

    fn value_of_servo(&self, axis: usize, id: u32) -> Result<String, i32> {
        let (servo, period) = (&self.stage.servos[axis], self.stage.period());
        let place = (id & 1) as usize;
        let notch = servo.notches[place];
        let is_off = notch.frequency <= 0.0;
        Ok(match id {
            P => servo.proportional.to_string(),
            // Zero: the integrator is off.
            TI if servo.integral == 0.0 => "0".to_owned(),
            TI => (period / servo.integral).to_string(),
            TD => (servo.derivative * period).to_string(),
            0x0700_0000 | 0x0700_0001 => self.stage.travel[axis].range()[place].to_string(),
            0x0800_0100 | 0x0800_0101 if is_off => (MOST_NOTCH / period).to_string(),
            0x0800_0100 | 0x0800_0101 => notch.frequency.to_string(),
            0x0800_0200 | 0x0800_0201 if is_off => "1".to_owned(),
            0x0800_0200 | 0x0800_0201 => notch.zeros.to_string(),
            0x0800_0300 | 0x0800_0301 => "1".to_owned(),
            0x0E00_0200 => period.to_string(),
            0x1600_0200 => super::MOST_VALUES.to_string(),
            0x1600_0300 => super::TABLES.to_string(),
            _ => return Err(UNKNOWN_PARAMETER),
        })
    }

    fn write(&mut self, words: &[&str]) -> Result<(), i32> {
        if words.is_empty() || !words.len().is_multiple_of(3) {
            return Err(SYNTAX);
        }
        for words in words.chunks(3) {
            let id = id(words[1])?;
            let item = self.item(words[0], id)?;
            let value = words[2].parse::<f64>().ok().filter(|x| x.is_finite()).ok_or(SYNTAX)?;
            let known = PARAMETERS.iter().find(|p| p.0 == id).ok_or(UNKNOWN_PARAMETER)?;
            match known.1 {
                9 => return Err(READ_ONLY),
                level if level > self.level => return Err(PROTECTED),
                _ if matches!(id, OFFSET | GAIN | SOURCE | ADDED) => {
                    self.use_input(item, id, value)?;
                }
                _ => self.set_value(item, id, value)?,
            }
        }
        Ok(())
    }

    fn use_input(&mut self, item: usize, id: u32, value: f64) -> Result<(), i32> {
        let (axes, most) = (self.stage.axes.len(), 2 * self.stage.axes.len());
        let usage = &mut self.stage.inputs.now;
        match id {
            // The scale of the sensors is that of the plant.
            OFFSET | GAIN if item < axes => return Err(READ_ONLY),
            OFFSET => usage.scales[item][0] = value,
            GAIN => usage.scales[item][1] = value,
            ADDED => usage.offsets[item] = value,
            _ if value.fract() != 0.0 || !(0.0..=most as f64).contains(&value) => {
                return Err(OUT_OF_RANGE);
            }
            _ => usage.sources[item] = value as usize,
        }
        Ok(())
    }

    fn set_value(&mut self, axis: usize, id: u32, value: f64) -> Result<(), i32> {
        let period = self.stage.period();
        let servo = &mut self.stage.servos[axis];
        let place = (id & 1) as usize;
        let notch = servo.notches[place];
        let [least, greatest] = match id {
            0x0800_0100 | 0x0800_0101 => [0.1, MOST_NOTCH / period],
            0x0800_0200 | 0x0800_0201 => [0.0, 1.0],
            // Another would be a low-pass filter too, which is not emulated.
            0x0800_0300 | 0x0800_0301 => [1.0, 1.0],
            _ => [0.0, 1e9],
        };
        if !(least..=greatest).contains(&value) {
            return Err(OUT_OF_RANGE);
        }
        let (frequency, zeros) = match notch.frequency > 0.0 {
            true => (notch.frequency, notch.zeros),
            false => (MOST_NOTCH / period, 1.0),
        };
        match id {
            P => servo.proportional = value,
            TI => servo.integral = if value == 0.0 { 0.0 } else { period / value },
            TD => servo.derivative = value / period,
            0x0800_0100 | 0x0800_0101 => self.stage.notch(axis, place, [value, zeros, 1.0]),
            0x0800_0200 | 0x0800_0201 => self.stage.notch(axis, place, [frequency, value, 1.0]),
            _ => {}
        }
        Ok(())
    }
}
