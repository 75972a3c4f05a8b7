//! Text as pages and figures show it.

/// Text in HTML and SVG, as it is.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// JSON that no browser takes for markup; it reads back as the same.
pub(crate) fn embedded(json: &str) -> String {
    json.trim_end().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::embedded;

    #[test]
    fn embedded_json_cannot_end_the_script_and_reads_back_as_the_same() {
        let json = serde_json::json!({ "text": "</script><!-- & \"quoted\"" });
        let text = embedded(&json.to_string());
        assert!(!text.contains('<'));
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&text).unwrap(),
            json
        );
    }
}
