//! An estimate as tables, and its measurements beside the motions.

use std::fmt::Write as _;

use hangtime::estimation::{Estimate, EstimatedParameter, FittedExperiment};

use crate::ending::Ending;
use crate::figure::{COLOURS, Panel, Series, over_time};
use crate::settings::ChosenScene;
use crate::simulate::digits;
use crate::spreadsheet::csv_text;
use crate::table::{counted, headed, seconds, table};
use crate::task::FIT_METHOD;

/// Standard deviations between which about 95 of 100 residuals lie.
const BAND: f64 = 2.0;

/// What the motion is beside which its measurements are shown.
pub(crate) fn title(estimate: &Estimate) -> String {
    let first = estimate.experiments.first();
    format!(
        "fitted to {}",
        first.map_or("", |first| first.declared.name)
    )
}

/// Pictures and tables of the measurements beside the motions, as (name, content).
pub(crate) fn further(stem: &str, estimate: &Estimate) -> Vec<(String, String)> {
    let experiments = &estimate.experiments;
    let compared = over_time(
        "measured (dots) and computed (lines)",
        &panels(experiments, compared),
    );
    let residuals = over_time(
        "residuals in standard deviations",
        &panels(experiments, residual),
    );
    let mut further = vec![
        (format!("{stem}-measured.svg"), compared),
        (format!("{stem}-residuals.svg"), residuals),
    ];
    for fitted in experiments {
        let name = format!("{stem}-residuals-{}.csv", fitted.declared.name);
        further.push((name, residuals_csv(fitted)));
    }
    further
}

/// A panel for every quantity of every experiment.
fn panels(
    experiments: &[FittedExperiment],
    panel: fn(&FittedExperiment, usize) -> Panel,
) -> Vec<Panel> {
    let of = |fitted: &FittedExperiment| -> Vec<Panel> {
        (0..fitted.declared.quantities.len())
            .map(|k| panel(fitted, k))
            .collect()
    };
    experiments.iter().flat_map(of).collect()
}

/// A series of one colour.
fn series(line: Vec<(f64, f64)>, dots: Vec<(f64, f64)>) -> Series {
    Series {
        name: None,
        colour: COLOURS[0],
        dashed: false,
        line,
        dots,
    }
}

/// Numbers over the times of an experiment, without those that are none.
fn over(fitted: &FittedExperiment, values: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    let points = fitted.times.iter().copied().zip(values);
    points.filter(|(_, value)| value.is_finite()).collect()
}

/// What was measured beside the motion.
fn compared(fitted: &FittedExperiment, k: usize) -> Panel {
    let quantity = &fitted.declared.quantities[k];
    let line = match fitted.motion.series(quantity.name) {
        Some(values) => {
            let times = fitted.motion.trajectory.time.iter().copied();
            times.zip(values.iter().copied()).collect()
        }
        None => over(fitted, fitted.computed.iter().map(|row| row[k])),
    };
    let dots = over(fitted, fitted.measured.iter().map(|row| row[k]));
    Panel {
        title: format!("{} of {}", quantity.name, fitted.declared.name),
        label: headed(quantity.name, quantity.unit),
        series: vec![series(line, dots)],
        bounds: Vec::new(),
    }
}

/// What the motion has more, in standard deviations.
fn residual(fitted: &FittedExperiment, k: usize) -> Panel {
    let quantity = &fitted.declared.quantities[k];
    let end = fitted.times.last().copied().unwrap_or_default();
    let dots = over(fitted, fitted.residuals(k).into_iter());
    Panel {
        title: format!("{} of {}", quantity.name, fitted.declared.name),
        label: "residual".to_owned(),
        series: vec![series(vec![(0.0, 0.0), (end, 0.0)], dots)],
        bounds: vec![-BAND, BAND],
    }
}

/// Times, and of every quantity what was measured, what was computed, and the residual.
fn residuals_csv(fitted: &FittedExperiment) -> String {
    let quantities = fitted.declared.quantities;
    let mut header = vec!["t [s]".to_owned()];
    for quantity in quantities {
        for what in ["measured", "computed"] {
            header.push(headed(&format!("{} {what}", quantity.name), quantity.unit));
        }
        header.push(format!("{} residual", quantity.name));
    }
    let cell = |value: f64| match value.is_finite() {
        true => value.to_string(),
        false => String::new(),
    };
    let residuals: Vec<Vec<f64>> = (0..quantities.len()).map(|k| fitted.residuals(k)).collect();
    let rows = fitted.times.iter().enumerate().map(|(row, time)| {
        let mut cells = vec![time.to_string()];
        for (k, residuals) in residuals.iter().enumerate() {
            let computed = fitted.computed.get(row).map_or(f64::NAN, |row| row[k]);
            cells.push(cell(fitted.measured[row][k]));
            cells.push(cell(computed));
            cells.push(cell(residuals.get(row).copied().unwrap_or(f64::NAN)));
        }
        cells
    });
    csv_text(&header, rows)
}

/// The result for people.
pub(crate) fn tables(chosen: &ChosenScene, estimate: &Estimate, ending: &Ending) -> String {
    let mut text = format!("{}: {}\n\n", chosen.scene.name, chosen.scene.title);
    let _ = writeln!(text, "parameters    {}", chosen.parameters().join(", "));
    let _ = writeln!(
        text,
        "method        {FIT_METHOD}, {}",
        counted(estimate.starts, "start")
    );
    let _ = writeln!(text, "status        {}", ending.status);
    if estimate.parameters.is_empty() {
        return text;
    }
    let _ = writeln!(
        text,
        "misfit        {:.10} of {}, spread {:.4}",
        estimate.misfit,
        counted(estimate.measurements, "measurement"),
        estimate.spread()
    );
    let _ = writeln!(
        text,
        "optimality    {:.1e} standard deviations from where the gradient vanishes\n",
        estimate.distance
    );
    let rows = estimate.parameters.iter().map(|known| {
        let deviation = match known.deviation {
            Some(deviation) => format!("{deviation:.3e}"),
            None if known.at_bound => "at a bound".to_owned(),
            None => "not determined".to_owned(),
        };
        let range = format!("{}..={}", known.range.0, known.range.1);
        vec![
            headed(known.name, known.unit),
            digits(known.value),
            deviation,
            range,
        ]
    });
    let header = ["parameter", "value", "deviation", "range"];
    text += &table(header, rows);
    text.push('\n');
    text += &correlations(estimate);
    let rows = estimate.experiments.iter().flat_map(experiment_rows);
    let header = [
        "experiment",
        "quantity",
        "measurements",
        "mean residual",
        "spread",
        "largest",
    ];
    text += &table(header, rows);
    text += "  (residuals in standard deviations)\n\n";
    for known in &estimate.undetermined {
        let _ = writeln!(text, "undetermined  {}", known.text);
    }
    for note in &estimate.notes {
        let _ = writeln!(text, "note          {note}");
    }
    let _ = writeln!(
        text,
        "counts        {}, {}",
        counted(estimate.steps, "step"),
        counted(estimate.simulations, "simulation")
    );
    let _ = writeln!(text, "CPU time      {}", seconds(estimate.seconds));
    text
}

/// Correlations of all pairs of parameters, if there are several.
fn correlations(estimate: &Estimate) -> String {
    let found: Vec<&EstimatedParameter> = estimate.parameters.iter().collect();
    if found.len() < 2 {
        return String::new();
    }
    let mut header = vec!["correlation".to_owned()];
    header.extend(found.iter().map(|known| known.name.to_owned()));
    let rows = (0..found.len()).map(|i| {
        let cell = |j: usize| match estimate.correlation(i, j) {
            value if value.is_finite() => format!("{value:.4}"),
            _ => "-".to_owned(),
        };
        let mut row = vec![found[i].name.to_owned()];
        row.extend((0..found.len()).map(cell));
        row
    });
    table(header, rows) + "\n"
}

/// How large the residuals of an experiment are, a row a quantity.
fn experiment_rows(fitted: &FittedExperiment) -> Vec<Vec<String>> {
    let quantities = fitted.declared.quantities.iter().enumerate();
    let row = |(k, quantity): (usize, &hangtime::model::MeasuredQuantity)| {
        let residuals = fitted.residuals(k).into_iter();
        let known: Vec<f64> = residuals.filter(|value| value.is_finite()).collect();
        let count = known.len().max(1) as f64;
        let mean = known.iter().sum::<f64>() / count;
        let spread = (known.iter().map(|r| r * r).sum::<f64>() / count).sqrt();
        let largest = known.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
        vec![
            fitted.declared.name.to_owned(),
            quantity.name.to_owned(),
            known.len().to_string(),
            format!("{mean:.3}"),
            format!("{spread:.3}"),
            format!("{largest:.3}"),
        ]
    };
    quantities.map(row).collect()
}
