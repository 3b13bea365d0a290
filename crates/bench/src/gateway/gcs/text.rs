//! Answers of GCS 2.0.

use crate::gateway::line::Broken;

/// Where the first whole answer ends: behind a line feed without a blank before it.
pub(super) fn end(bytes: &[u8]) -> Option<usize> {
    let is_end = |at: &usize| bytes[*at] == b'\n' && (*at == 0 || bytes[at - 1] != b' ');
    (0..bytes.len()).find(is_end).map(|at| at + 1)
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
        code => Err(Broken::Said(format!("{command}: GCS error {code}: {}", error_text(code)))),
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
        assert_eq!(end(b"1=1 \n2=2\n0\n"), Some(9));
        assert_eq!((end(b"1=1 \n"), end(b""), end(b"\n")), (None, None, Some(1)));
        assert_eq!(error_of("0\n", ""), Ok(()));
        assert!(error_of("7\n", "MOV 1 9").unwrap_err().to_string().contains("out of limits"));
        assert!(matches!(error_of("x\n", ""), Err(Broken::Garbage(_))));
    }
}
