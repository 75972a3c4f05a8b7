//! What a shell and its manual know about the program: completions and pages.

use clap::builder::PossibleValuesParser;
use clap_complete::Shell;

use crate::Scene;
use crate::arguments::{CompletionsArguments, ManArguments};
use crate::failure::{BadInput, did_you_mean};
use crate::report::Report;
use crate::scene_file::EXTENSION;

/// A command of the program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CommandSettings {
    /// Its name.
    pub name: String,
    /// What it does.
    pub about: String,
    /// Its arguments and options, as they are typed, and what each means, with its choices and its default.
    pub options: Vec<(String, String)>,
}

/// The commands of the program and their options; those that are hidden are left out.
pub(crate) fn settings(parser: &clap::Command) -> Vec<CommandSettings> {
    let commands = parser
        .get_subcommands()
        .filter(|command| !command.is_hide_set());
    let settings = commands.map(|command| {
        let arguments = command
            .get_arguments()
            .filter(|argument| !argument.is_hide_set());
        CommandSettings {
            name: command.get_name().to_owned(),
            about: command
                .get_about()
                .map(ToString::to_string)
                .unwrap_or_default(),
            options: arguments.map(option).collect(),
        }
    });
    settings.collect()
}

/// An argument as it is typed, and what it means.
fn option(argument: &clap::Arg) -> (String, String) {
    let values = argument.get_value_names().unwrap_or_default();
    let taken = argument.get_action().takes_values();
    let values: Vec<&str> = values
        .iter()
        .filter(|_| taken)
        .map(|name| name.as_str())
        .collect();
    let typed = match argument.get_long() {
        Some(long) => [&[format!("--{long}").as_str()], &values[..]]
            .concat()
            .join(" "),
        None => values.join(" "),
    };
    let mut text = argument
        .get_help()
        .map(ToString::to_string)
        .unwrap_or_default();
    let choices = argument.get_possible_values();
    let choices = choices
        .iter()
        .filter(|choice| taken && !choice.is_hide_set());
    let choices = choices.map(|choice| match choice.get_help() {
        Some(help) => format!("`{}`: {help}", choice.get_name()),
        None => format!("`{}`", choice.get_name()),
    });
    let choices: Vec<String> = choices.collect();
    if !choices.is_empty() {
        text += &format!(" Choices: {}.", choices.join("; "));
    }
    let defaults = argument.get_default_values().iter().filter(|_| taken);
    let defaults: Vec<_> = defaults.map(|value| value.to_string_lossy()).collect();
    if !defaults.is_empty() {
        text += &format!(" Default: `{}`.", defaults.join(" "));
    }
    (typed, text)
}

/// The commands that take scenes.
const SCENE_COMMANDS: [&str; 4] = ["simulate", "solve", "chart", "explain"];

/// The script that completes commands, options and their choices, and the names of the scenes beside scene files.
pub(crate) fn completions(
    mut parser: clap::Command,
    scenes: &[Scene],
    arguments: &CompletionsArguments,
) -> Report {
    let name = parser.get_name().to_owned();
    let names: Vec<&'static str> = scenes.iter().map(|scene| scene.name).collect();
    let commands = parser.get_subcommands().map(clap::Command::get_name);
    // The parser keeps names for as long as the program runs.
    let commands: Vec<&'static str> = commands.map(|name| &*name.to_owned().leak()).collect();
    // A command line without scenes has nothing to choose from but files.
    for command in SCENE_COMMANDS.iter().filter(|_| !names.is_empty()) {
        let choices = PossibleValuesParser::new(names.clone());
        parser = parser.mut_subcommand(command, |command| {
            command.mut_args(|argument| match argument.get_id().as_str() {
                "scene" | "scenes" => argument.value_parser(choices.clone()),
                _ => argument,
            })
        });
    }
    parser = parser.mut_subcommand("man", |man| {
        man.mut_arg("command", |command| {
            command.value_parser(PossibleValuesParser::new(commands))
        })
    });
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut parser, name.as_str(), &mut script);
    let script = String::from_utf8_lossy(&script);
    let names = names.join(" ");
    // One shell offers nothing beside a list of choices, unless it is told to, and another one no such list.
    let script = match arguments.shell {
        Shell::Fish if !names.is_empty() => {
            let function = format!("__fish_{}_using_subcommand", name.replace('-', "_"));
            let lines = SCENE_COMMANDS.map(|command| {
                format!("complete -c {name} -n \"{function} {command}\" -a \"{names}\"\n")
            });
            script.into_owned() + &lines.concat()
        }
        Shell::Zsh => script.replace(
            &format!(":({names})'"),
            &format!(":{{compadd {names}; _files -g \"*.{EXTENSION}\"}}'"),
        ),
        _ => script.into_owned(),
    };
    Report::of(script)
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
