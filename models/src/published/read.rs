//! Reading the embedded tables.

use serde::de::DeserializeOwned;

use hangtime_cli::PublishedDataError;

/// The rows of the table `name`, without its header.
pub(super) fn rows<Row: DeserializeOwned>(
    name: &'static str,
    csv: &'static str,
) -> Result<Vec<Row>, PublishedDataError> {
    csv::Reader::from_reader(csv.as_bytes())
        .into_deserialize()
        .collect::<Result<Vec<Row>, _>>()
        .map_err(|source| PublishedDataError::Csv { name, source })
}
