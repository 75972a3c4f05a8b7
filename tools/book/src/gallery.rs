//! The chapter of the scenes to choose from: the list of the program, with pictures.

use std::fmt::Write as _;

use hangtime_models::scenes;

use crate::highlight::escape;
use crate::open;

/// The file by which the summary names the chapter.
pub(crate) const FILE: &str = "gallery.md";

/// The groups of `hangtime list` with their scenes: picture, title, question and answer.
pub(crate) fn chapter() -> String {
    let mut text = String::from(
        "# Scenes to choose from\n\nThe scenes that come with the program, as `hangtime list` has them; `hangtime list NAME` tells all about one. The pictures show \
         the motion of least objective where a scene asks a question, and the simulated motion otherwise.\n",
    );
    let mut groups: Vec<&str> = Vec::new();
    for scene in scenes() {
        if !groups.contains(&scene.group) {
            groups.push(scene.group);
        }
    }
    for group in groups {
        let _ = write!(
            text,
            "\n## {}{}\n\n<div class=\"cards\">\n",
            group[..1].to_uppercase(),
            &group[1..]
        );
        for scene in scenes().iter().filter(|scene| scene.group == group) {
            let (name, title) = (escape(scene.name), escape(scene.title));
            let source = scene.unread.or(scene.source).unwrap_or_default();
            // No empty line, which would end the block of HTML.
            let picture = scene.picture.replace("\n", "");
            let _ = write!(
                text,
                "<div class=\"card\" id=\"scene-{name}\">{picture}<b>{}</b><span>{title}</span>",
                open::anchor(scene.name, source, &name)
            );
            let about = scene.about();
            if !about.is_empty() {
                let _ = write!(text, "<span class=\"about\">{}</span>", escape(&about));
            }
            if let Some(question) = scene.question {
                let (asked, answer) = (escape(question.asked), escape(question.answer));
                let _ = write!(text, "<i>{asked}</i><span class=\"answer\">{answer}</span>");
            }
            text.push_str("</div>\n");
        }
        text.push_str("</div>\n");
    }
    text
}
