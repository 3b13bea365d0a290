//! How many points a page can afford to draw.

use std::borrow::Cow;

use super::view::{Chart, Kind, TraceView};
use crate::reduce::{self, Buckets};

/// Most points of a curve.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Detail {
    /// Points over time in the interactive layer; loops, spectra and responses get half as many.
    pub(super) live: usize,
    /// Points over time in the picture.
    pub(super) wide: usize,
    /// Points over time in the picture for narrow screens.
    pub(super) narrow: usize,
}

impl Detail {
    /// From all that a figure keeps to what is still a picture.
    pub(crate) const LEVELS: [Self; 8] = [
        Self { live: 4000, wide: 1800, narrow: 500 },
        Self { live: 2400, wide: 1200, narrow: 400 },
        Self { live: 1600, wide: 900, narrow: 320 },
        Self { live: 1000, wide: 700, narrow: 260 },
        Self { live: 600, wide: 500, narrow: 200 },
        Self { live: 400, wide: 360, narrow: 160 },
        Self { live: 260, wide: 280, narrow: 130 },
        Self { live: 160, wide: 200, narrow: 100 },
    ];

    /// Most points of a curve that is not over time.
    pub(super) fn curve(self) -> usize {
        self.live / 2
    }

    /// Leaves out points until the curves of a chart have at most so many.
    pub(super) fn thin(self, chart: &mut Chart<'_>) {
        let kind = chart.kind;
        for trace in chart.panels.iter_mut().flat_map(|panel| &mut panel.traces) {
            match kind {
                Kind::Shared => self.thin_over_time(trace),
                Kind::Curves => {
                    let kept = reduce::log_extremes(&trace.x, &[&trace.y], self.curve());
                    keep(trace, &kept);
                }
                Kind::Free if trace.x.len().min(trace.y.len()) > self.curve() => {
                    let kept = reduce::shape(&trace.x, &trace.y, self.curve());
                    keep(trace, &kept);
                }
                Kind::Free | Kind::Bars => {}
            }
        }
    }

    fn thin_over_time(self, trace: &mut TraceView<'_>) {
        if let Some(buckets) = Buckets::new(trace.x.len(), self.live) {
            let times = buckets.times(&trace.x);
            trace.y = Cow::Owned(buckets.extremes(&trace.y));
            trace.x = Cow::Owned(times);
        }
    }
}

fn keep(trace: &mut TraceView<'_>, kept: &[usize]) {
    let pick = |values: &[f64]| kept.iter().filter_map(|&i| values.get(i).copied()).collect();
    (trace.x, trace.y) = (Cow::Owned(pick(&trace.x)), Cow::Owned(pick(&trace.y)));
}
