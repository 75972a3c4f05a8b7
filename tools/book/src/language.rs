//! The reference of the language: what the documentation of the macro says, as a chapter.

/// Where it stands, from the root of the repository.
pub(crate) const SOURCE: &str = "runtime/src/model_macro.md";
/// The file by which the summary names the chapter.
pub(crate) const FILE: &str = "language.md";
/// All chapters that the code writes.
pub(crate) const GENERATED: [&str; 5] = [
    FILE,
    "gallery.md",
    "settings.md",
    "statuses.md",
    "columns.md",
];

/// The chapter: headings one level down, and of programs the lines that are shown.
pub(crate) fn chapter(documentation: &str) -> String {
    let mut text = String::from(
        "# The language, statement by statement\n\nWhat stands in a scene file stands between the braces of `model!` in Rust, and the other way round.\n\n",
    );
    let mut fenced = false;
    for line in documentation.lines() {
        if line.starts_with("```") {
            fenced = !fenced;
        } else if line.starts_with("# ") || line.starts_with("## ") {
            if fenced {
                // Compiled, and not shown.
                continue;
            }
            text.push('#');
        }
        text.push_str(line);
        text.push('\n');
    }
    text
}
