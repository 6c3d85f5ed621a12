//! The place that the text of an error begins with.

use std::ffi::OsString;
use std::path::Path;

use clap::CommandFactory;

use super::Arguments;

/// The file or flag that a message begins with; a flag with its value where the message has it. Files are those of the arguments
/// of the program, and those in folders among them.
pub fn place<'a>(message: &'a str, arguments: &[OsString]) -> Option<&'a str> {
    let arguments: Vec<String> =
        arguments.iter().map(|argument| argument.to_string_lossy().into_owned()).collect();
    let files = file_names(&arguments);
    let is_file = |text: &str| files.iter().any(|file| Path::new(text).starts_with(file));
    let mut heads = message.match_indices(": ").map(|(end, _)| &message[..end]);
    if !message.starts_with("--") {
        return heads.find(|head| is_file(head));
    }
    let flag = message.split([' ', ':']).next().unwrap_or(message);
    let has_value = |head: &&str| {
        let value = head.strip_prefix(flag).and_then(|rest| rest.strip_prefix(' '));
        value.is_some_and(|value| !value.contains(' ') || is_file(value))
    };
    heads.find(has_value).or(Some(flag))
}

/// The arguments, and values of flags, that may name a file: not the command.
fn file_names(arguments: &[String]) -> Vec<&str> {
    let program = Arguments::command();
    let is_command = |word: &str| word == "--json" || program.find_subcommand(word).is_some();
    let words = arguments.iter().skip_while(|word| is_command(word));
    let values = words.map(|word| match word.split_once('=') {
        Some((flag, value)) if flag.starts_with("--") => value,
        _ => word.as_str(),
    });
    values.filter(|value| !value.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn place_is_the_file_or_flag_at_the_begin() {
        let arguments = "plan --map mine.yaml --config=a.toml logs --record".split(' ');
        let mut arguments: Vec<OsString> = arguments.map(OsString::from).collect();
        arguments.push("of 2: b.mcap".into());
        for (message, expected) in [
            ("mine.yaml: cannot be read (gone): check the path", Some("mine.yaml")),
            ("a.toml: [local] sim_time_s is 0", Some("a.toml")),
            ("logs/one.mcap: no scans", Some("logs/one.mcap")),
            ("of 2: b.mcap: no recording", Some("of 2: b.mcap")),
            ("--record of 2: b.mcap: cannot be written", Some("--record of 2: b.mcap")),
            ("--start 1,1: lies in a closed zone", Some("--start 1,1")),
            ("--relations: a.txt: line 1", Some("--relations")),
            ("--update-map needs the pose from scans: add --set", Some("--update-map")),
            ("other.yaml: line 1", None),
            ("plan: no path", None),
            ("standard output: gone", None),
            ("no places are free", None),
        ] {
            assert_eq!(place(message, &arguments), expected, "{message}");
        }
    }
}
