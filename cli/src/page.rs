//! Pages that open offline: everything they show is inside the file.

use std::fmt::Write as _;

use crate::animation::{self, Animation};
use crate::markup::escape;

/// A page of figures and tables.
#[derive(Default)]
pub(crate) struct Page {
    /// Title.
    pub(crate) title: String,
    /// What the page is about, one paragraph.
    pub(crate) introduction: String,
    /// Its sections.
    pub(crate) sections: Vec<Section>,
    /// Other pages in the same directory.
    pub(crate) links: Vec<String>,
}

/// One section of a page.
#[derive(Default)]
pub(crate) struct Section {
    /// Heading.
    pub(crate) heading: String,
    /// One paragraph, possibly empty.
    pub(crate) text: String,
    /// A motion that plays, with the result that it shows as JSON.
    pub(crate) animation: Option<(Animation, String)>,
    /// Figures as SVG.
    pub(crate) figures: Vec<String>,
    /// Header of the table.
    pub(crate) header: Vec<String>,
    /// Rows of the table, the first column in words.
    pub(crate) rows: Vec<Vec<String>>,
    /// What is shown when it is asked for.
    pub(crate) folds: Vec<Fold>,
    /// Files beside the page, as (file name, what it holds).
    pub(crate) files: Vec<(String, String)>,
}

/// A part of a section that is closed at first.
#[derive(Default)]
pub(crate) struct Fold {
    /// What is in it.
    pub(crate) title: String,
    /// Figures as SVG.
    pub(crate) figures: Vec<String>,
    /// Header of the table.
    pub(crate) header: Vec<String>,
    /// Rows of the table, the first column in words.
    pub(crate) rows: Vec<Vec<String>>,
}

/// Letters from which on a cell is prose, with lines of its own.
const PROSE: usize = 60;
/// Sections from which on a page begins with a list of them.
const CONTENTS: usize = 4;

const STYLE: &str = "\
:root{color-scheme:light dark}
body{font:16px/1.5 system-ui,sans-serif;max-width:74rem;margin:2rem auto;padding:0 1rem;color:#1f2430;background:#ffffff}
h1,h2{line-height:1.2}
figure{margin:1.5rem 0;overflow-x:auto}
svg{max-width:100%;height:auto}
svg.chart{min-width:46rem}
.table{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.88rem}
th,td{padding:.3rem .5rem;text-align:right;border-bottom:1px solid #8a919e66;white-space:nowrap}
th:first-child,td:first-child{text-align:left;white-space:pre}
th:first-child,td:first-child{position:sticky;left:0;background:#ffffff}
th:not(:first-child){white-space:normal;vertical-align:bottom}
td.prose{text-align:left;white-space:normal;min-width:22rem}
nav a,.pages a{display:inline-block;margin:0 1rem .3rem 0}
summary{cursor:pointer;margin:.5rem 0;font-weight:600}
a{color:inherit}
@media (prefers-color-scheme:dark){body,th:first-child,td:first-child{color:#dfe3ea;background:#14171c}}
";

impl Page {
    /// The page as HTML.
    pub(crate) fn html(&self) -> String {
        let title = escape(&self.title);
        let plays = self.sections.iter().any(|s| s.animation.is_some());
        let player = if plays { animation::STYLE } else { "" };
        let mut html = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{STYLE}{player}</style>\n</head>\n<body>\n\
             <h1>{title}</h1>\n<p>{}</p>\n",
            escape(&self.introduction)
        );
        if self.sections.len() >= CONTENTS {
            let links = self.sections.iter().enumerate().map(|(index, section)| {
                format!("<a href=\"#s{index}\">{}</a>", escape(&section.heading))
            });
            let _ = writeln!(html, "<nav>{}</nav>", links.collect::<Vec<_>>().join(" "));
        }
        if !self.links.is_empty() {
            let links = self.links.iter().map(|page| {
                let name = page.trim_end_matches(".html");
                format!("<a href=\"{}\">{}</a>", escape(page), escape(name))
            });
            let links = links.collect::<Vec<_>>().join(" ");
            let _ = writeln!(html, "<p class=\"pages\">Other pages: {links}</p>");
        }
        for (index, section) in self.sections.iter().enumerate() {
            let _ = write!(html, "<section id=\"s{index}\">");
            section.write(&mut html);
            html.push_str("</section>\n");
        }
        html + "</body>\n</html>\n"
    }
}

impl Section {
    fn write(&self, html: &mut String) {
        let _ = writeln!(html, "<h2>{}</h2>", escape(&self.heading));
        if !self.text.is_empty() {
            let _ = writeln!(html, "<p>{}</p>", escape(&self.text));
        }
        if let Some((animation, result)) = &self.animation {
            html.push_str(&animation.html(result));
        }
        write_table(html, &self.header, &self.rows);
        for figure in &self.figures {
            let _ = writeln!(html, "<figure>{figure}</figure>");
        }
        for fold in &self.folds {
            let _ = writeln!(html, "<details><summary>{}</summary>", escape(&fold.title));
            for figure in &fold.figures {
                let _ = writeln!(html, "<figure>{figure}</figure>");
            }
            write_table(html, &fold.header, &fold.rows);
            html.push_str("</details>\n");
        }
        if !self.files.is_empty() {
            let links = self
                .files
                .iter()
                .map(|(file, what)| format!("<a href=\"{}\">{}</a>", escape(file), escape(what)));
            let _ = writeln!(
                html,
                "<p>Data: {}</p>",
                links.collect::<Vec<_>>().join(", ")
            );
        }
    }
}

/// A table, if it has columns.
fn write_table(html: &mut String, header: &[String], rows: &[Vec<String>]) {
    if header.is_empty() {
        return;
    }
    let row = |cell: &str, cells: &[String]| {
        let cells = cells.iter().map(|text| {
            let class = if text.len() > PROSE {
                " class=\"prose\""
            } else {
                ""
            };
            format!("<{cell}{class}>{}</{cell}>", escape(text))
        });
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let rows = rows.iter().map(|cells| row("td", cells));
    let _ = writeln!(
        html,
        "<div class=\"table\"><table>\n{}{}</table></div>",
        row("th", header),
        rows.collect::<String>()
    );
}

#[cfg(test)]
mod tests {
    use super::Page;

    #[test]
    fn page_with_markup_in_a_title_shows_it_as_text() {
        let page = Page {
            title: "a < b & \"c\"".to_owned(),
            introduction: String::new(),
            ..Page::default()
        };
        assert!(
            page.html()
                .contains("<h1>a &lt; b &amp; &quot;c&quot;</h1>")
        );
    }
}
