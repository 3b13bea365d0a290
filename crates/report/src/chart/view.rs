//! What is drawn, whatever the kind of figure: panels of curves over one horizontal axis.

use std::borrow::Cow;

use super::scale::Scale;
use crate::figure::{Band, Limit, Marker, Role};
use crate::number::{format_number, format_unit, power_of_ten};

/// A chart.
pub(super) struct Chart<'a> {
    /// The title.
    pub(super) title: &'a str,
    /// What a reader who cannot see the picture is told.
    pub(super) description: String,
    /// What kind of chart it is, for the interactive layer.
    pub(super) kind: Kind,
    /// Half a page wide.
    pub(super) compact: bool,
    /// How many samples each signal over time had.
    pub(super) samples: usize,
    /// One length per unit on both axes.
    pub(super) equal_scale: bool,
    /// The horizontal axis.
    pub(super) x: AxisView,
    /// Panels, from top to bottom.
    pub(super) panels: Vec<PanelView<'a>>,
    /// What the legend names.
    pub(super) entries: Vec<Entry>,
    /// Marked stretches of the horizontal axis.
    pub(super) bands: &'a [Band],
    /// Marked places of the horizontal axis.
    pub(super) markers: &'a [Marker],
}

impl Chart<'_> {
    /// How many samples a drawn pair of points stands for; 1 if all are drawn.
    pub(super) fn stretch(&self) -> usize {
        let mut traces = self.panels.iter().flat_map(|panel| &panel.traces);
        let points = traces.next().map_or(0, |trace| trace.x.len());
        if self.kind != Kind::Shared || points == 0 || self.samples <= points {
            return 1;
        }
        (2 * self.samples).div_ceil(points)
    }
}

/// How curves relate to the horizontal axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// All curves share their horizontal values, which increase.
    Shared,
    /// Each curve has its own horizontal values, which increase.
    Curves,
    /// Each curve runs freely.
    Free,
    /// Bars: not interactive.
    Bars,
}

/// An axis.
pub(super) struct AxisView {
    /// The quantity.
    pub(super) label: String,
    /// The unit, as printed.
    pub(super) unit: String,
    /// The range and how it is mapped.
    pub(super) scale: Scale,
}

impl AxisView {
    pub(super) fn new(label: &str, unit: &str, scale: Scale) -> Self {
        Self { label: label.to_owned(), unit: format_unit(unit), scale }
    }

    /// The axis' heading: `position [µm]`, with the offset and power of ten of the labels on
    /// `scale`, if there are.
    pub(super) fn heading(&self, scale: &Scale) -> String {
        let offset = scale.offset();
        let label = if offset == 0.0 {
            self.label.clone()
        } else {
            let sign = if offset > 0.0 { '−' } else { '+' };
            format!("{} {sign} {}", self.label, format_number(offset.abs(), 15))
        };
        let exponent = scale.exponent();
        let power = if exponent == 0 { String::new() } else { power_of_ten(exponent) };
        let unit = [power.as_str(), self.unit.as_str()];
        let unit: Vec<&str> = unit.into_iter().filter(|part| !part.is_empty()).collect();
        match (label.is_empty(), unit.is_empty()) {
            (_, true) => label,
            (true, false) => format!("[{}]", unit.join(" ")),
            (false, false) => format!("{label} [{}]", unit.join(" ")),
        }
    }
}

/// Curves that share a vertical axis.
pub(super) struct PanelView<'a> {
    /// The vertical axis.
    pub(super) y: AxisView,
    /// Height of the plot relative to the others of the chart.
    pub(super) weight: f64,
    /// Curves.
    pub(super) traces: Vec<TraceView<'a>>,
    /// Bars.
    pub(super) bars: Vec<BarsView<'a>>,
    /// Horizontal lines.
    pub(super) limits: &'a [Limit],
}

/// A curve.
pub(super) struct TraceView<'a> {
    /// Which entry of the legend it belongs to.
    pub(super) entry: usize,
    /// Horizontal values.
    pub(super) x: Cow<'a, [f64]>,
    /// Vertical values.
    pub(super) y: Cow<'a, [f64]>,
}

/// The bars of one set.
pub(super) struct BarsView<'a> {
    /// Which entry of the legend it belongs to.
    pub(super) entry: usize,
    /// Edges.
    pub(super) edges: &'a [f64],
    /// Counts.
    pub(super) counts: &'a [usize],
}

/// A curve's name and look.
pub(super) struct Entry {
    /// The name.
    pub(super) name: String,
    /// The look.
    pub(super) style: Style,
}

/// Colour and line style, as numbers of the style sheet's classes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Style {
    /// Colour, 0…7.
    pub(super) colour: usize,
    /// Line style, 0…3.
    pub(super) dash: usize,
}

const COLOURS: usize = 8;
/// Colours of curves without a role, the most legible first but for those of roles, which come late, so
/// that the same curves look the same with and without measured signals, models and references.
const FREE: [usize; COLOURS] = [1, 4, 2, 5, 6, 7, 3, 0];
/// Lengths of strokes and gaps of each line style, in pixels; the style sheet holds the same.
pub(super) const DASHES: [&[u8]; 4] = [&[], &[6, 4], &[2, 2], &[8, 3, 2, 3]];

impl Style {
    /// The classes of the style sheet; a dense curve would not show its dashes and is drawn solid.
    pub(super) fn classes(self, dashed: bool) -> String {
        format!("c{} d{}", self.colour, if dashed { self.dash } else { 0 })
    }
}

/// The looks of curves of these roles: a role's own for its first curve, then the free colours in
/// turn, each time with another line style.
pub(super) fn styles(roles: &[Role]) -> Vec<Style> {
    let own = |role: Role| match role {
        Role::Measured => Some(Style { colour: 0, dash: 0 }),
        Role::Model => Some(Style { colour: 2, dash: 1 }),
        Role::Residual => Some(Style { colour: 1, dash: 0 }),
        Role::Reference => Some(Style { colour: 3, dash: 2 }),
        Role::Other => None,
    };
    let first = |k: usize| roles.iter().position(|role| *role == roles[k]) == Some(k);
    let taken: Vec<usize> =
        roles.iter().filter_map(|role| own(*role)).map(|style| style.colour).collect();
    let free: Vec<usize> = FREE.into_iter().filter(|c| !taken.contains(c)).collect();
    let mut next = 0_usize;
    (0..roles.len())
        .map(|k| match own(roles[k]) {
            Some(style) if first(k) => style,
            _ => {
                let turn = next;
                next += 1;
                let round = turn.checked_div(free.len()).unwrap_or(0);
                Style {
                    colour: free.get(turn % free.len().max(1)).copied().unwrap_or(turn % COLOURS),
                    dash: (turn + round) % DASHES.len(),
                }
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_differ_and_roles_keep_theirs() {
        let roles = [Role::Other; 20];
        let looks = styles(&roles);
        for (i, a) in looks.iter().enumerate() {
            assert!(looks[..i].iter().all(|b| a != b), "curves alike: {a:?}");
        }
        let mixed = styles(&[Role::Other, Role::Measured, Role::Model, Role::Measured]);
        assert_eq!(mixed[1], Style { colour: 0, dash: 0 });
        assert_eq!(mixed[2], Style { colour: 2, dash: 1 });
        assert_ne!(mixed[3], mixed[1]);
        assert_eq!(mixed[0].colour, 1);
    }
}
