//! Published figures that a scene reproduces: the plotted points, and what they mean.

/// The plotted points of one published figure and the parameters behind it.
#[derive(Debug, Clone, Copy)]
pub struct PublishedFigure {
    /// Name of its files, without extension.
    pub name: &'static str,
    /// What it shows, in one line.
    pub title: &'static str,
    /// Where it was published.
    pub source: &'static str,
    /// Parameters that differ from the defaults, as (name, value in the declared unit).
    pub settings: &'static [(&'static str, f64)],
    /// Time-lapse markers a second [1/s]; the first one is the start.
    pub marker_rate: f64,
    /// The plotted points, as CSV with the columns `kind`, `marker_index`, horizontal, vertical.
    pub csv: &'static str,
}

/// One time-lapse marker of a published figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PublishedMarker {
    /// Time \[s\].
    pub time: f64,
    /// Horizontal and vertical position, in the units of the axes.
    pub position: [f64; 2],
    /// Whether the figure marks it as the impact (it is the first marker after the landing).
    pub impact: bool,
}

/// Why the embedded data of a figure could not be read.
#[derive(Debug, thiserror::Error)]
pub enum PublishedDataError {
    /// Not the expected CSV.
    #[error("published data `{name}`: {source}")]
    Csv {
        /// Name of the figure.
        name: &'static str,
        /// What the reader says.
        source: csv::Error,
    },
}

/// One line of the CSV: kind, index of a time-lapse marker, position.
type Line = (String, Option<usize>, f64, f64);

impl PublishedFigure {
    /// The time-lapse markers, in order of time.
    ///
    /// # Errors
    /// [`PublishedDataError`] if the embedded CSV is damaged.
    pub fn markers(&self) -> Result<Vec<PublishedMarker>, PublishedDataError> {
        let lines = csv::Reader::from_reader(self.csv.as_bytes())
            .deserialize()
            .collect::<Result<Vec<Line>, _>>()
            .map_err(|source| PublishedDataError::Csv {
                name: self.name,
                source,
            })?;
        let impact = lines
            .iter()
            .find(|(kind, ..)| kind == "q_impact")
            .map(|&(_, _, y, z)| [y, z]);
        Ok(lines
            .iter()
            .filter_map(|&(_, index, y, z)| {
                index.map(|index| PublishedMarker {
                    time: index as f64 / self.marker_rate,
                    position: [y, z],
                    impact: impact == Some([y, z]),
                })
            })
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use crate::scenes;

    #[test]
    fn published_markers_of_every_figure_are_read_with_one_impact() {
        let figures: Vec<_> = scenes().iter().flat_map(|scene| scene.published).collect();
        assert!(!figures.is_empty());
        for figure in figures {
            let markers = figure.markers().unwrap();
            assert!(markers.len() > 10, "{}", figure.name);
            assert_eq!(markers.iter().filter(|m| m.impact).count(), 1);
            assert!(markers.windows(2).all(
                |pair| pair[0].time < pair[1].time && pair[0].position[0] < pair[1].position[0]
            ));
        }
    }
}
