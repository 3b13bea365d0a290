//! Segments of a wave table.

use core::f64::consts::PI;

use super::{OUT_OF_RANGE, SYNTAX, TOO_LARGE};

/// Points of all wave tables together.
pub(super) const MOST_POINTS: usize = 262_144;

/// Puts a segment into a table: `words` are those of WAV behind the table's number.
pub(super) fn segment(table: &mut Vec<f64>, words: &[&str]) -> Result<(), i32> {
    let [append, form, rest @ ..] = words else { return Err(SYNTAX) };
    let number = |word: &&str| word.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or(SYNTAX);
    let values = rest.iter().map(number).collect::<Result<Vec<f64>, i32>>()?;
    let points = match form.to_ascii_uppercase().as_str() {
        "PNT" => {
            let [_, count, points @ ..] = &values[..] else { return Err(SYNTAX) };
            if points.len() as f64 != *count {
                return Err(SYNTAX);
            }
            points.to_vec()
        }
        "SIN_P" => curve(&values, 1, |x, centre, _| {
            let up = x <= centre;
            let part = if up { x / centre } else { 1.0 + (x - centre) / (1.0 - centre) };
            0.5 * (1.0 - (PI * part).cos())
        })?,
        "RAMP" => curve(&values, 2, |x, centre, soft| match x <= centre {
            true => smooth(x / centre, soft / centre),
            false => smooth((1.0 - x) / (1.0 - centre), soft / (1.0 - centre)),
        })?,
        "LIN" => curve(&values, 0, |x, _, soft| smooth(x, soft))?,
        _ => return Err(OUT_OF_RANGE),
    };
    match *append {
        "X" => *table = points,
        "&" => table.extend(points),
        "+" if points.len() == table.len() => {
            table.iter_mut().zip(points).for_each(|(old, new)| *old += new);
        }
        _ => return Err(SYNTAX),
    }
    if table.len() > MOST_POINTS {
        table.truncate(MOST_POINTS);
        return Err(TOO_LARGE);
    }
    Ok(())
}

/// A segment of `values`: length, amplitude, offset, length of the curve, its first point, and then by `kind` speed-up
/// points (0), the centre (1) or both (2). `form`: share of the amplitude by place in the curve, centre and speed-up,
/// all as shares of its length.
fn curve(values: &[f64], kind: u8, form: impl Fn(f64, f64, f64) -> f64) -> Result<Vec<f64>, i32> {
    let [length, amplitude, offset, curve, first, rest @ ..] = values else { return Err(SYNTAX) };
    let (soft, centre) = match (kind, rest) {
        (0, [soft]) => (*soft, 0.5 * curve),
        (1, [centre]) => (0.0, *centre),
        (2, [soft, centre]) => (*soft, *centre),
        _ => return Err(SYNTAX),
    };
    let is_good = (1.0..=MOST_POINTS as f64).contains(length)
        && *curve >= 2.0
        && *first >= 0.0
        && first + curve <= length + 1.0
        && centre > 0.0
        && centre < *curve
        && (0.0..=0.5 * curve).contains(&soft);
    if !is_good {
        return Err(OUT_OF_RANGE);
    }
    let at = |k: usize| ((k as f64 - first) / curve).clamp(0.0, 1.0);
    Ok((0..*length as usize)
        .map(|k| offset + amplitude * form(at(k), centre / curve, soft / curve))
        .collect())
}

/// From 0 to 1 at a constant speed that is reached and left within `soft`.
fn smooth(x: f64, soft: f64) -> f64 {
    let speed = 1.0 / (1.0 - soft).max(0.5);
    let begin = |x: f64| 0.5 * speed * x * x / soft;
    if soft > 0.0 && x < soft {
        begin(x)
    } else if soft > 0.0 && x > 1.0 - soft {
        1.0 - begin(1.0 - x)
    } else {
        speed * (x - 0.5 * soft)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_begin_and_end_where_they_shall() {
        let mut table = Vec::new();
        let mut wave = |text: &str| {
            let done = segment(&mut table, &text.split(' ').collect::<Vec<_>>());
            done.map(|()| table.clone())
        };
        let sine = wave("X SIN_P 2000 20 10 2000 0 1000").unwrap();
        assert_eq!((sine.len(), sine[0], sine[1000]), (2000, 10.0, 30.0));
        assert!((sine[500] - 20.0).abs() < 1e-9 && sine[1999] < 10.001);
        let line = wave("& LIN 3000 -40 50 3000 0 650").unwrap();
        assert_eq!((line.len(), line[2000]), (5000, 50.0));
        assert!((line[4999] - 10.0).abs() < 1e-3 && (line[3500] - 30.0).abs() < 0.1);
        let ramp = wave("X RAMP 100 8 1 80 10 5 40").unwrap();
        assert!(ramp[..=10].iter().all(|y| *y == 1.0) && (ramp[50] - 9.0).abs() < 1e-9);
        assert!(ramp[90..].iter().all(|y| (*y - 1.0).abs() < 1e-9));
        assert_eq!(wave("X PNT 1 3 1 2 3").unwrap(), [1.0, 2.0, 3.0]);
        assert_eq!(wave("+ PNT 1 3 1 1 1").unwrap(), [2.0, 3.0, 4.0]);
        for bad in
            ["X PNT 1 4 1 2 3", "X SIN_P 10 1 0 20 0 5", "X TAN 1", "? PNT 1 1 1", "X LIN 1 2"]
        {
            assert!(wave(bad).is_err(), "{bad}");
        }
    }
}
