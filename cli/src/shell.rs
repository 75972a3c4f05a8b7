//! What a shell and its manual know about the program: completions and pages.

use crate::arguments::{CompletionsArguments, ManArguments};
use crate::failure::{BadInput, did_you_mean};
use crate::report::Report;

/// The script that completes commands, options and their choices.
pub(crate) fn completions(mut parser: clap::Command, arguments: &CompletionsArguments) -> Report {
    let name = parser.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut parser, name, &mut script);
    Report::of(String::from_utf8_lossy(&script))
}

/// The manual page of the program, or of one of its commands.
pub(crate) fn manual(
    mut parser: clap::Command,
    arguments: &ManArguments,
) -> Result<Report, BadInput> {
    // The options that every command has, help and version, come with this.
    parser.build();
    let page = match &arguments.command {
        None => parser,
        Some(name) => parser.find_subcommand(name).cloned().ok_or_else(|| {
            let names = parser.get_subcommands().map(clap::Command::get_name);
            BadInput::new(format!(
                "there is no command `{name}`{}; --help lists them",
                did_you_mean(name, names)
            ))
        })?,
    };
    let mut text = Vec::new();
    // Writing to memory does not fail.
    let _ = clap_mangen::Man::new(page).render(&mut text);
    Ok(Report::of(String::from_utf8_lossy(&text)))
}
