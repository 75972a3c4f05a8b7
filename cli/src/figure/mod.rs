//! Figures as SVG, readable on light and on dark pages.

mod axis;
mod colours;
mod log_log;
mod plane;
mod time;

use kuva::prelude::{Layout, Plot, Theme, render_to_svg};

use colours::GREY;
pub(crate) use colours::{COLOURS, Look};
pub(crate) use log_log::{Curve, Dot, LogLog};
pub(crate) use plane::{Motion, Path, frame};
pub(crate) use time::{Panel, Series, over_time};

/// Width and height of a figure [px].
const SIZE: (f64, f64) = (900.0, 520.0);

/// Colours of text and page for a figure that is opened by itself or shown on a page.
const STYLE: &str = "<style>svg{color:#1f2430;background:#ffffff}\
    @media (prefers-color-scheme:dark){svg{color:#dfe3ea;background:#14171c}}</style>";

fn theme() -> Theme {
    let text = || "currentColor".to_owned();
    Theme {
        background: "none".into(),
        axis_color: text(),
        tick_color: text(),
        text_color: text(),
        grid_color: "#8a919e44".into(),
        legend_bg: "none".into(),
        legend_border: "none".into(),
        ..Theme::light()
    }
}

fn layout(plots: &[Plot], title: &str, x: &str, y: &str) -> Layout {
    Layout::auto_from_plots(plots)
        .with_theme(theme())
        .with_width(SIZE.0)
        .with_height(SIZE.1)
        .with_title(title)
        .with_x_label(x)
        .with_y_label(y)
}

/// A text without its middle, if it has more than `most` characters: names begin and units end it.
fn shortened(text: &str, most: usize) -> String {
    let length = text.chars().count();
    if length <= most {
        return text.to_owned();
    }
    let tail = most / 3;
    let start: String = text.chars().take(most - tail - 1).collect();
    let end: String = text.chars().skip(length - tail).collect();
    format!("{start}\u{2026}{end}")
}

fn svg(plots: Vec<Plot>, layout: Layout) -> String {
    styled(&render_to_svg(plots, layout))
}

/// The drawing with a view box, so that it scales, and with colours that follow the page.
fn styled(drawing: &str) -> String {
    let length = |name: &str| {
        let rest = drawing.split_once(name)?.1;
        rest.split_once('"').map(|(length, _)| length.to_owned())
    };
    let view = match (length(" width=\""), length(" height=\"")) {
        (Some(width), Some(height)) => format!(" viewBox=\"0 0 {width} {height}\""),
        _ => String::new(),
    };
    drawing.replacen('>', &format!("{view}>{STYLE}"), 1)
}
