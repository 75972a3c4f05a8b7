//! Pages that open offline: everything they show is inside the file, in the order in which it is told.

use std::fmt::Write as _;

use crate::animation::{self, Animation};
use crate::figure::LogLog;
use crate::markup::{escape, prose};

/// A page of motions, figures and tables.
#[derive(Default)]
pub(crate) struct Page {
    /// Title.
    pub(crate) title: String,
    /// What it opens with, before the list of what else there is.
    pub(crate) lead: Vec<Section>,
    /// Its other sections.
    pub(crate) sections: Vec<Section>,
    /// What words and columns mean, a paragraph each, at the end.
    pub(crate) notes: Vec<String>,
    /// Other pages in the same directory.
    pub(crate) links: Vec<String>,
}

/// One section of a page.
#[derive(Default)]
pub(crate) struct Section {
    /// Heading; empty where the title of the page says it.
    pub(crate) heading: String,
    /// What it shows, in order.
    pub(crate) blocks: Vec<Block>,
    /// Files beside the page, as (file name, what it holds).
    pub(crate) files: Vec<(String, String)>,
}

/// A part of a section.
pub(crate) enum Block {
    /// One paragraph; what stands between backticks is set as code.
    Text(String),
    /// Motions that play, side by side where there is space.
    Players(Vec<Player>),
    /// A figure as SVG, and the same for narrow screens where there is one.
    Figure(Figure),
    /// A table.
    Table(Table),
    /// What is shown when it is asked for: a title, and what is in it.
    Fold(String, Vec<Block>),
}

/// A motion that plays.
pub(crate) struct Player {
    /// What moves; may be empty.
    pub(crate) caption: String,
    /// The motion.
    pub(crate) animation: Animation,
    /// The whole result as JSON, for whoever reads the page by program; may be empty.
    pub(crate) result: String,
    /// Whether it plays as soon as the page is seen, over and over.
    pub(crate) plays: bool,
}

/// A figure.
#[derive(Clone)]
pub(crate) struct Figure {
    /// As SVG.
    svg: String,
    /// As SVG for narrow screens.
    narrow: Option<String>,
}

/// A table.
#[derive(Clone, Default)]
pub(crate) struct Table {
    /// Its header.
    pub(crate) header: Vec<String>,
    /// Its rows, the first column in words.
    pub(crate) rows: Vec<Vec<String>>,
    /// Whether its rows stand close together.
    pub(crate) dense: bool,
}

/// Letters from which on a cell is prose, with lines of its own.
const PROSE: usize = 44;
/// Letters of the lines of such a cell, at least.
const LEAST_PROSE: usize = 36;
/// Width of a letter and of the space around a cell, and the width that a table may have on a screen of 1280 px.
const LETTER: usize = 8;
const AROUND: usize = 16;
const SEEN: usize = 1150;
/// Sections from which on a page has a list of them.
const CONTENTS: usize = 4;

const STYLE: &str = "\
:root{color-scheme:light dark}
body{font:16px/1.5 system-ui,sans-serif;max-width:74rem;margin:.5rem auto;padding:0 1rem;color:#1f2430;background:#ffffff}
h1,h2{line-height:1.2}
h1{font-size:1.6rem;margin:.5rem 0}
h2{font-size:1.25rem;margin:.8rem 0 .4rem}
p{margin:.5rem 0}
figure{margin:.3rem 0;overflow-x:auto}
svg{max-width:100%;height:auto}
.players{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,28rem),1fr));gap:1.5rem}
.players figcaption{font-weight:600;margin-bottom:.3rem}
.slim{display:none}
.table{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.88rem}
th,td{padding:.3rem .5rem;text-align:right;border-bottom:1px solid #8a919e66;white-space:nowrap}
th:first-child,td:first-child{text-align:left;white-space:pre}
th:first-child,td:first-child{position:sticky;left:0;background:#ffffff}
th:not(:first-child){white-space:normal;vertical-align:bottom}
.dense th,.dense td{padding:.08rem .5rem}
.wide table{font-size:.78rem}
.wide th,.wide td{padding:.25rem .3rem}
.wide td:not(:first-child){white-space:normal}
td.prose,td.prose:first-child{text-align:left;white-space:normal;min-width:18rem}
nav a,.pages a{display:inline-block;margin:0 1rem .3rem 0}
summary{cursor:pointer;margin:.5rem 0;font-weight:600}
a{color:inherit}
code{font-family:ui-monospace,monospace;font-size:.93em}
@media screen and (max-width:47rem){.two{display:none}.slim{display:inline}.players:has(figure+figure) :is(.readings,#events,#events1){display:none}table{font-size:.78rem}th,td{padding:.2rem .35rem}}
@media screen and (prefers-color-scheme:dark){body,th:first-child,td:first-child{color:#dfe3ea;background:#14171c}}
@media print{:root{color-scheme:light}body{margin:0;max-width:none}.players{grid-template-columns:1fr 1fr}figure,tr,.player{break-inside:avoid}nav,.pages,.players .panel{display:none}}
";

impl Page {
    /// The page as HTML.
    pub(crate) fn html(&self) -> String {
        let title = escape(&self.title);
        let all = || self.lead.iter().chain(&self.sections);
        let plays = |section: &Section| {
            let mut blocks = section.blocks.iter();
            blocks.any(|block| matches!(block, Block::Players(players) if !players.is_empty()))
        };
        let plays = all().any(plays);
        let player = if plays { animation::STYLE } else { "" };
        let mut html = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{player}{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
        );
        let mut writer = Writer {
            html: &mut html,
            players: 0,
        };
        for section in &self.lead {
            writer.html.push_str("<section>");
            writer.section(section);
            writer.html.push_str("</section>\n");
        }
        writer.contents(&self.sections);
        for (index, section) in self.sections.iter().enumerate() {
            let _ = write!(writer.html, "<section id=\"s{index}\">");
            writer.section(section);
            writer.html.push_str("</section>\n");
        }
        writer.links(&self.links);
        for note in &self.notes {
            let _ = writeln!(html, "<p>{}</p>", prose(note));
        }
        if plays {
            let _ = writeln!(html, "<script>\n{}</script>", animation::SCRIPT);
        }
        html + "</body>\n</html>\n"
    }
}

impl Figure {
    /// A drawing.
    pub(crate) fn of(svg: impl Into<String>) -> Self {
        Self {
            svg: svg.into(),
            narrow: None,
        }
    }

    /// A chart that can be read on narrow screens, too.
    pub(crate) fn chart(chart: &LogLog<'_>) -> Self {
        Self {
            svg: chart.svg(),
            narrow: Some(chart.narrow_svg()),
        }
    }

    /// The drawing, for a file.
    pub(crate) fn svg(&self) -> &str {
        &self.svg
    }
}

impl Block {
    /// A drawing.
    pub(crate) fn figure(svg: impl Into<String>) -> Self {
        Self::Figure(Figure::of(svg))
    }

    /// A table.
    pub(crate) fn table<H>(header: H, rows: Vec<Vec<String>>) -> Self
    where
        H: IntoIterator,
        H::Item: Into<String>,
    {
        Self::Table(Table {
            header: header.into_iter().map(Into::into).collect(),
            rows,
            dense: false,
        })
    }

    /// What is shown when it is asked for.
    pub(crate) fn folded(title: &str, inside: Self) -> Self {
        Self::Fold(title.to_owned(), vec![inside])
    }
}

impl Section {
    /// Its tables, in order, those within folds among them.
    #[cfg(test)]
    pub(crate) fn tables(&self) -> Vec<&Table> {
        fn tables(blocks: &[Block]) -> Vec<&Table> {
            let each = blocks.iter().flat_map(|block| match block {
                Block::Table(table) => vec![table],
                Block::Fold(_, blocks) => tables(blocks),
                _ => Vec::new(),
            });
            each.collect()
        }
        tables(&self.blocks)
    }
}

/// What writes a page, and counts its players.
struct Writer<'h> {
    html: &'h mut String,
    players: usize,
}

impl Writer<'_> {
    /// What else the page has.
    fn contents(&mut self, sections: &[Section]) {
        if sections.len() >= CONTENTS {
            let links = sections.iter().enumerate().map(|(index, section)| {
                format!("<a href=\"#s{index}\">{}</a>", escape(&section.heading))
            });
            let links = links.collect::<Vec<_>>().join(" ");
            let _ = writeln!(self.html, "<nav>{links}</nav>");
        }
    }

    /// What else its directory has.
    fn links(&mut self, links: &[String]) {
        if !links.is_empty() {
            let links = links.iter().map(|page| {
                let name = page.trim_end_matches(".html");
                format!("<a href=\"{}\">{}</a>", escape(page), escape(name))
            });
            let links = links.collect::<Vec<_>>().join(" ");
            let _ = writeln!(self.html, "<p class=\"pages\">Other pages: {links}</p>");
        }
    }

    fn section(&mut self, section: &Section) {
        if !section.heading.is_empty() {
            let _ = writeln!(self.html, "<h2>{}</h2>", prose(&section.heading));
        }
        for block in &section.blocks {
            self.block(block);
        }
        if !section.files.is_empty() {
            let links = section
                .files
                .iter()
                .map(|(file, what)| format!("<a href=\"{}\">{}</a>", escape(file), escape(what)));
            let _ = writeln!(
                self.html,
                "<p>Data: {}</p>",
                links.collect::<Vec<_>>().join(", ")
            );
        }
    }

    fn block(&mut self, block: &Block) {
        match block {
            Block::Text(text) if text.is_empty() => {}
            Block::Text(text) => {
                let _ = writeln!(self.html, "<p>{}</p>", prose(text));
            }
            Block::Players(players) => self.motions(players),
            Block::Figure(Figure { svg, narrow: None }) => {
                let _ = writeln!(self.html, "<figure>{svg}</figure>");
            }
            Block::Figure(Figure {
                svg,
                narrow: Some(narrow),
            }) => {
                let _ = writeln!(
                    self.html,
                    "<figure><div class=\"two\">{svg}</div>{narrow}</figure>"
                );
            }
            Block::Table(table) => table.write(self.html),
            Block::Fold(title, blocks) => {
                let _ = writeln!(self.html, "<details><summary>{}</summary>", prose(title));
                for block in blocks {
                    self.block(block);
                }
                self.html.push_str("</details>\n");
            }
        }
    }

    fn motions(&mut self, players: &[Player]) {
        self.html.push_str("<div class=\"players\">\n");
        for player in players {
            self.html.push_str("<figure>");
            if !player.caption.is_empty() {
                let caption = prose(&player.caption);
                let _ = writeln!(self.html, "<figcaption>{caption}</figcaption>");
            }
            let elements = player
                .animation
                .html(self.players, &player.result, player.plays);
            self.html.push_str(&elements);
            self.html.push_str("</figure>\n");
            self.players += 1;
        }
        self.html.push_str("</div>\n");
    }
}

impl Table {
    /// About how wide it is with one line a cell [px]; what is too wide has smaller letters, and cells of several lines.
    fn width(&self) -> usize {
        let columns = self.header.iter().enumerate().map(|(index, head)| {
            let words = head.split_whitespace().map(str::len);
            let cells = self
                .rows
                .iter()
                .filter_map(|row| Some(row.get(index)?.len()));
            let prose = |length| if length > PROSE { LEAST_PROSE } else { length };
            let letters = words.chain(cells.map(prose)).max();
            AROUND + LETTER * letters.unwrap_or_default()
        });
        columns.sum()
    }

    /// As HTML, if it has columns.
    fn write(&self, html: &mut String) {
        if self.header.is_empty() {
            return;
        }
        let row = |cell: &str, cells: &[String]| {
            let cells = cells.iter().map(|text| {
                let class = if cell == "td" && text.len() > PROSE {
                    " class=\"prose\""
                } else {
                    ""
                };
                format!("<{cell}{class}>{}</{cell}>", prose(text))
            });
            format!("<tr>{}</tr>\n", cells.collect::<String>())
        };
        let rows = self.rows.iter().map(|cells| row("td", cells));
        let _ = writeln!(
            html,
            "<div class=\"table{}{}\"><table>\n{}{}</table></div>",
            if self.dense { " dense" } else { "" },
            if self.width() > SEEN { " wide" } else { "" },
            row("th", &self.header),
            rows.collect::<String>()
        );
    }
}

#[cfg(test)]
mod tests {
    use super::{Block, Page, Section};

    fn page(lead: Vec<Block>, blocks: Vec<Block>) -> String {
        let section = |blocks| Section {
            blocks,
            ..Section::default()
        };
        Page {
            title: "a < b & \"c\"".to_owned(),
            lead: vec![section(lead)],
            sections: vec![section(blocks)],
            notes: vec!["`d` means < e".to_owned()],
            links: vec!["other.html".to_owned()],
        }
        .html()
    }

    #[test]
    fn page_with_markup_in_a_title_shows_it_as_text() {
        let page = page(Vec::new(), Vec::new());
        assert!(page.contains("<h1>a &lt; b &amp; &quot;c&quot;</h1>"));
    }

    #[test]
    fn page_has_the_order_in_which_it_is_told_and_no_backticks() {
        let text = |words: &str| Block::Text(words.to_owned());
        let rows = vec![vec!["1".to_owned()], vec!["`2`".to_owned()]];
        let table = Block::table(["x"], rows);
        let page = page(
            vec![Block::figure("<svg/>"), text("`first` words")],
            vec![
                table,
                Block::Fold("more".to_owned(), vec![text("within it")]),
            ],
        );
        let places: Vec<usize> = [
            "<svg/>",
            "<code>first</code> words",
            "<td>1</td>",
            "<td><code>2</code></td>",
            "<summary>more",
            "within it",
            "Other pages",
            "<code>d</code> means &lt; e",
        ]
        .map(|words| {
            page.find(words)
                .unwrap_or_else(|| panic!("{words}: {page}"))
        })
        .into();
        assert!(places.is_sorted(), "{places:?}");
        assert!(!page.contains('`'));
    }
}
