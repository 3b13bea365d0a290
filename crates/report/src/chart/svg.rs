//! Writing SVG: escaping, coordinates, paths.

use std::fmt::Write as _;

/// Text from outside, safe between tags and inside quoted attributes. Characters that XML forbids
/// are shown as `�`.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(' '),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// A coordinate to a tenth of a pixel, as short as it can be.
pub(super) fn px(x: f64) -> String {
    tenths((x.clamp(-1e5, 1e5) * 10.0).round() as i64)
}

/// An integer number of tenths: `125` → `12.5`, `-3` → `-.3`.
fn tenths(n: i64) -> String {
    let (sign, n) = (if n < 0 { "-" } else { "" }, n.unsigned_abs());
    match (n / 10, n % 10) {
        (0, 0) => "0".to_owned(),
        (complete, 0) => format!("{sign}{complete}"),
        (0, tenth) => format!("{sign}.{tenth}"),
        (complete, tenth) => format!("{sign}{complete}.{tenth}"),
    }
}

/// Path data through points in pixels; a point that is not finite is a gap, a point between two
/// gaps is a dot.
pub(super) fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut data = String::new();
    let mut last: Option<(i64, i64)> = None;
    let mut drawn = 0;
    for (x, y) in points {
        if !(x.is_finite() && y.is_finite()) {
            end_stroke(&mut data, &mut last, &mut drawn);
            continue;
        }
        let grid = |v: f64| (v.clamp(-1e5, 1e5) * 10.0).round() as i64;
        let here = (grid(x), grid(y));
        match last {
            None => {
                let _ = write!(data, "M{} {}", tenths(here.0), tenths(here.1));
            }
            Some(before) if before == here => continue,
            Some(before) => {
                step(&mut data, here.0 - before.0, here.1 - before.1);
                drawn += 1;
            }
        }
        last = Some(here);
    }
    end_stroke(&mut data, &mut last, &mut drawn);
    data
}

fn end_stroke(data: &mut String, last: &mut Option<(i64, i64)>, drawn: &mut usize) {
    if last.is_some() && *drawn == 0 {
        data.push_str("h0");
    }
    *last = None;
    *drawn = 0;
}

/// A relative line, by the shortest command.
fn step(data: &mut String, dx: i64, dy: i64) {
    let (x, y) = (tenths(dx), tenths(dy));
    let _ = match (dx, dy) {
        (0, _) => write!(data, "v{y}"),
        (_, 0) => write!(data, "h{x}"),
        _ if y.starts_with('-') => write!(data, "l{x}{y}"),
        _ => write!(data, "l{x} {y}"),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_short_and_break_at_gaps() {
        let points = [(0.0, 0.0), (1.0, -0.5), (1.0, 2.0), (f64::NAN, 1.0), (5.0, 5.04)];
        assert_eq!(path(points.into_iter()), "M0 0l1-.5v2.5M5 5h0");
        assert_eq!(path(std::iter::empty()), "");
    }

    #[test]
    fn rounding_does_not_add_up() {
        let data = path((0..1000).map(|i| (f64::from(i) * 0.04, 0.0)));
        let sum: f64 = data.split('h').skip(1).map(|s| s.parse::<f64>().unwrap()).sum();
        assert!((sum - 39.96).abs() < 0.06, "{sum}");
    }

    #[test]
    fn hostile_text_is_escaped() {
        assert_eq!(escape("<a b='\"'>&\0"), "&lt;a b=&#39;&quot;&#39;&gt;&amp;\u{fffd}");
    }
}
