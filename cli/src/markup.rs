//! Text as pages and figures show it.

/// Text in HTML and SVG, as it is.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Text in HTML, where words between backticks are set as code; a backtick without another one stays away.
pub(crate) fn prose(text: &str) -> String {
    let pieces: Vec<&str> = text.split('`').collect();
    let pairs = (pieces.len() - 1) / 2;
    let pieces = pieces.into_iter().enumerate().map(|(index, piece)| {
        if index % 2 == 1 && index < 2 * pairs {
            format!("<code>{}</code>", escape(piece))
        } else {
            escape(piece)
        }
    });
    pieces.collect()
}

/// JSON that no browser takes for markup; it reads back as the same.
pub(crate) fn embedded(json: &str) -> String {
    json.trim_end().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::{embedded, prose};

    #[test]
    fn backticks_become_code_in_pairs() {
        assert_eq!(
            prose("a `b<c` d `e`"),
            "a <code>b&lt;c</code> d <code>e</code>"
        );
        assert_eq!(prose("a ` b"), "a  b");
        assert_eq!(prose("`a` b ` c"), "<code>a</code> b  c");
        assert_eq!(prose(""), "");
    }

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
