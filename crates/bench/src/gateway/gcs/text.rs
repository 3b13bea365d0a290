//! Answers of GCS 2.0.

use crate::gateway::line::Broken;

/// Where the first whole answer ends: behind a line feed without a blank before it. Before `from` there is no end.
pub(super) fn end(bytes: &[u8], from: usize) -> Option<usize> {
    let is_end = |at: &usize| bytes[*at] == b'\n' && (*at == 0 || bytes[at - 1] != b' ');
    (from..bytes.len()).find(is_end).map(|at| at + 1)
}

/// An array in GCS: its sample time in s, and its columns; none: it is none, or not whole.
pub(super) fn array(answer: &str) -> Option<(f64, Vec<Vec<f64>>)> {
    let (header, rows) = answer.split_once("# END_HEADER")?;
    let entry = |name: &str| {
        let lines = header.lines().filter_map(|line| line.trim_start_matches('#').split_once('='));
        let mut values = lines.filter(|(key, _)| key.trim() == name).map(|(_, value)| value.trim());
        values.next()
    };
    let columns = entry("DIM")?.parse::<usize>().ok()?;
    let sample_time =
        entry("SAMPLE_TIME")?.parse::<f64>().ok().filter(|t| t.is_finite() && *t > 0.0)?;
    let separator =
        entry("SEPARATOR").and_then(|code| code.parse::<u8>().ok()).map_or(' ', char::from);
    let mut table = vec![Vec::new(); columns];
    for row in rows.lines().map(str::trim).filter(|row| !row.is_empty()) {
        let mut values = row.split(separator).map(str::trim).filter(|word| !word.is_empty());
        for column in &mut table {
            column.push(values.next()?.parse::<f64>().ok().filter(|x| x.is_finite())?);
        }
        if values.next().is_some() {
            return None;
        }
    }
    let count = entry("NDATA").and_then(|count| count.parse::<usize>().ok());
    let is_complete = table.first().is_some_and(|column| count.is_none_or(|n| n == column.len()));
    is_complete.then_some((sample_time, table))
}

/// The numbers of an answer `1=+0.5 \n2=+1.5\n`, one for each of these axes in their order.
///
/// # Errors
/// Another form, other axes, or a number that is none.
pub fn numbers(answer: &str, axes: &[String]) -> Result<Vec<f64>, Broken> {
    let garbage =
        || Broken::Garbage(format!("{answer:?} where {} were asked for", axes.join(", ")));
    let lines: Vec<&str> = answer.trim_end().split('\n').map(str::trim).collect();
    if lines.len() != axes.len() {
        return Err(garbage());
    }
    let number = |(line, axis): (&&str, &String)| {
        let (name, value) = line.split_once('=')?;
        let value: f64 = value.trim().parse().ok().filter(|value: &f64| value.is_finite())?;
        (name.trim() == axis).then_some(value)
    };
    lines.iter().zip(axes).map(number).collect::<Option<_>>().ok_or_else(garbage)
}

/// What the answer to `ERR?` says about a command.
pub(super) fn error_of(answer: &str, command: &str) -> Result<(), Broken> {
    let code: i32 = answer.trim().parse().map_err(|_| {
        Broken::Garbage(format!("{answer:?} where an error's number was asked for"))
    })?;
    match code {
        0 => Ok(()),
        code => Err(Broken::Refused(format!("{command}: GCS error {code}: {}", error_text(code)))),
    }
}

/// The errors that a bench meets; the instrument's manual has all.
#[must_use]
pub fn error_text(code: i32) -> &'static str {
    match code {
        1 => "parameter syntax error",
        2 => "unknown command",
        5 => "a move was asked for with the servo off",
        7 => "position out of limits",
        10 => "stopped by a command",
        15 => "no such axis",
        17 => "parameter out of range",
        54 => "unknown parameter",
        60 => "the parameter is protected",
        66 => "voltage out of limits",
        67 => "the wave has too many points",
        72 => "the axis follows its analog input",
        73 => "the wave generator is active",
        75 => "no wave table is connected",
        _ => "see the instrument's manual",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_read_or_refused() {
        let axes = ["1".to_owned(), "X".to_owned()];
        assert_eq!(numbers("1=+0.5 \nX=-1e-3\n", &axes), Ok(vec![0.5, -1e-3]));
        for bad in [
            "",
            "\n",
            "1=0.5\n",
            "1=0.5 \nY=1\n",
            "X=1 \n1=2\n",
            "1=nan \nX=1\n",
            "1=1 \nX=\n",
            "1=1 \nX=1 \n2=1\n",
        ] {
            assert!(numbers(bad, &axes).is_err(), "{bad:?}");
        }
        assert_eq!(end(b"1=1 \n2=2\n0\n", 0), Some(9));
        assert_eq!((end(b"1=1 \n", 0), end(b"", 0), end(b"\n", 0)), (None, None, Some(1)));
        assert_eq!(end(b"1=1 \n2=2\n0\n", 5), Some(9));
        assert_eq!(error_of("0\n", ""), Ok(()));
        assert!(error_of("7\n", "MOV 1 9").unwrap_err().to_string().contains("out of limits"));
        assert!(matches!(error_of("x\n", ""), Err(Broken::Garbage(_))));
    }
    #[test]
    fn arrays_are_read_complete_or_not() {
        let good = "# REM E-727 \n# TYPE = 1 \n# SEPARATOR = 32 \n# DIM = 2 \n# SAMPLE_TIME = 5e-05 \n# NDATA = 2 \n\
                    # NAME0 = a=b \n# END_HEADER \n1.5 -2 \n+0.5 3e-1\n";
        assert_eq!(array(good), Some((5e-5, vec![vec![1.5, 0.5], vec![-2.0, 0.3]])));
        for (from, to) in [
            ("NDATA = 2", "NDATA = 3"),
            ("DIM = 2", "DIM = 3"),
            ("1.5 -2", "1.5 -2 4"),
            ("1.5 -2", "1.5"),
            ("1.5", "nan"),
            ("5e-05", "0"),
            ("# END_HEADER", ""),
        ] {
            assert_eq!(array(&good.replace(from, to)), None, "{from} -> {to}");
        }
    }
}
