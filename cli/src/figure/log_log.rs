//! Charts with logarithmic axes.

use std::sync::Arc;

use kuva::prelude::{LegendPosition, LinePlot, Plot, ScatterPlot, TickFormat};

use super::{COLOURS, layout, svg};

/// One line of a chart with logarithmic axes.
pub(crate) struct Curve {
    /// Name in the legend.
    pub(crate) name: String,
    /// Index into the colours.
    pub(crate) colour: usize,
    /// Dashed instead of solid.
    pub(crate) dashed: bool,
    /// Points; those that are not positive are left out.
    pub(crate) points: Vec<(f64, f64)>,
}

/// A chart with logarithmic axes.
///
/// The logarithms of the errors are taken here: logarithmic axes of the drawing library stop at
/// 1e-10.
pub(crate) fn log_log(title: &str, x: &str, y: &str, curves: &[Curve]) -> String {
    let mut plots: Vec<Plot> = Vec::new();
    for curve in curves {
        let points: Vec<(f64, f64)> = curve
            .points
            .iter()
            .filter(|&&(x, y)| x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite())
            .map(|&(x, y)| (x, y.log10()))
            .collect();
        if points.is_empty() {
            continue;
        }
        let colour = COLOURS[curve.colour % COLOURS.len()];
        let line = LinePlot::new()
            .with_data(points.clone())
            .with_color(colour)
            .with_legend(curve.name.as_str());
        plots.push(
            if curve.dashed {
                line.with_dashed()
            } else {
                line
            }
            .into(),
        );
        plots.push(
            ScatterPlot::new()
                .with_data(points)
                .with_color(colour)
                .with_size(2.5)
                .into(),
        );
    }
    let power = TickFormat::Custom(Arc::new(|exponent: f64| format!("1e{exponent:.0}")));
    let layout = layout(&plots, title, x, y);
    if plots.is_empty() {
        // Nothing was measured, and an empty axis has no logarithms.
        return svg(plots, layout);
    }
    let layout = layout
        .with_log_x()
        .with_x_tick_format(TickFormat::Custom(Arc::new(|x: f64| {
            if x < 1e-2 {
                format!("{x:.0e}")
            } else {
                format!("{x}")
            }
        })))
        .with_y_tick_step(2.0)
        .with_y_tick_format(power)
        .with_legend_position(LegendPosition::OutsideRightTop);
    svg(plots, layout)
}
