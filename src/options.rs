//! Options of a frame as tables of TOML files have them: named as on the command line of `raybudget profile`.
//!
//! `size = "256x256"` is `--size 256x256`, `force = ["mirror", "normals"]` is `--force mirror,normals`, and a key with dots, such as
//! `cache.uche.size = 65536`, is a figure of the GPU, `--set cache.uche.size=65536`. `scene` names the scene. The command line's own
//! parser reads them, so that both know the same options.

use crate::args::{DEFAULT_SCENE, FrameArgs, MachineArgs};
use anyhow::{anyhow, bail};
use clap::{CommandFactory, Parser};
use std::sync::LazyLock;
use toml::{Spanned, Value};

/// A table of options as it is read.
pub(crate) use reports::budget::RawOptions;

/// Options and their values, in the order in which they were first set.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Options(Vec<(String, String)>);

/// A frame that was asked for.
#[derive(Parser, Debug)]
#[command(name = "options", no_binary_name = true, disable_help_flag = true)]
pub(crate) struct Request {
    #[arg(long, default_value = DEFAULT_SCENE)]
    pub(crate) scene: String,
    #[command(flatten)]
    pub(crate) frame: FrameArgs,
    #[command(flatten)]
    pub(crate) machine: MachineArgs,
}

impl Options {
    /// Reads a table in the order of the file.
    pub(crate) fn read(table: &RawOptions) -> anyhow::Result<Self> {
        let mut options = Self::default();
        for (key, value) in in_order(table) {
            for (key, value) in figures_of(key, value) {
                let text = value_text(value).ok_or_else(|| {
                    anyhow!("{key}: expected text, a number or a list of these; got {}", value.type_str())
                })?;
                options.set(&key, text)?;
            }
        }
        Ok(options)
    }

    /// Sets an option, anew if it is set.
    pub(crate) fn set(&mut self, key: &str, value: String) -> anyhow::Result<()> {
        check(key)?;
        self.put(key, value);
        Ok(())
    }

    fn put(&mut self, key: &str, value: String) {
        match self.0.iter_mut().find(|(known, _)| known == key) {
            Some((_, old)) => *old = value,
            None => self.0.push((key.to_owned(), value)),
        }
    }

    /// These options, and `others` in the place of those that both set.
    pub(crate) fn with(&self, others: &Self) -> Self {
        let mut all = self.clone();
        for (key, value) in &others.0 {
            all.put(key, value.clone());
        }
        all
    }

    /// Names and values.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(key, value)| (key.as_str(), value.as_str()))
    }

    /// The value of an option.
    pub(crate) fn get(&self, key: &str) -> Option<&str> {
        self.iter().find(|&(known, _)| known == key).map(|(_, value)| value)
    }

    /// What they ask for.
    pub(crate) fn request(&self) -> anyhow::Result<Request> {
        let argument = |(key, value): (&str, &str)| match key.contains('.') {
            true => format!("--set={key}={value}"),
            false => format!("--{key}={value}"),
        };
        Request::try_parse_from(self.iter().map(argument)).map_err(|error| {
            let text = error.to_string();
            let lines = text.lines().map(str::trim).take_while(|line| !line.is_empty());
            anyhow!("{}", lines.collect::<Vec<_>>().join(" ").trim_start_matches("error: "))
        })
    }
}

/// The entries of a table in the order of the file.
pub(crate) fn in_order(table: &RawOptions) -> Vec<(&str, &Value)> {
    let mut entries: Vec<(&Spanned<String>, &Value)> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    entries.into_iter().map(|(key, value)| (key.get_ref().as_str(), value)).collect()
}

/// The entry itself; or, of a table within the table, which is what TOML makes of keys with dots, the figures in it.
pub(crate) fn figures_of<'a>(key: &str, value: &'a Value) -> Vec<(String, &'a Value)> {
    match value {
        Value::Table(table) => {
            table.iter().flat_map(|(inner, value)| figures_of(&format!("{key}.{inner}"), value)).collect()
        }
        value => vec![(key.to_owned(), value)],
    }
}

/// A value as it stands on the command line; a list is joined by commas.
pub(crate) fn value_text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Integer(number) => Some(number.to_string()),
        Value::Float(number) => Some(number.to_string()),
        Value::Array(values) => Some(values.iter().map(value_text).collect::<Option<Vec<_>>>()?.join(",")),
        Value::Boolean(_) | Value::Datetime(_) | Value::Table(_) => None,
    }
}

/// Names of all options; the command line's definition takes long to build.
static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let command = Request::command();
    let names = command.get_arguments().filter_map(clap::Arg::get_long);
    names.filter(|&name| name != "set").map(str::to_owned).collect()
});

/// Refuses a key that is no option.
fn check(key: &str) -> anyhow::Result<()> {
    if key.contains('.') || NAMES.iter().any(|name| name == key) {
        return Ok(());
    }
    bail!(
        "{key}: no such option; use one of: {}; or a figure of the GPU such as cache.uche.size",
        NAMES.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(text: &str) -> anyhow::Result<Options> {
        Options::read(&toml::from_str(text).expect("TOML"))
    }

    #[test]
    fn a_table_asks_for_what_the_command_line_would() {
        let text = "size = \"64x32\"\nforce = [\"mirror\", \"normals\"]\nct = -1.5\nspp = 2\ncache.uche.size = 65536\n\"cache.uche.line\" = 128\n";
        let read = options(text).expect("they are options");
        let keys: Vec<&str> = read.iter().map(|(key, _)| key).collect();
        assert_eq!(keys, ["size", "force", "ct", "spp", "cache.uche.size", "cache.uche.line"]);
        let Request { scene, frame, machine } = read.request().expect("they are options");
        assert_eq!(
            (scene.as_str(), frame.size.as_deref(), frame.spp),
            (DEFAULT_SCENE, Some("64x32"), Some(2))
        );
        assert_eq!((frame.ct, frame.force), (Some(-1.5), vec!["mirror".to_owned(), "normals".to_owned()]));
        assert_eq!(machine.set, ["cache.uche.size=65536", "cache.uche.line=128"]);
    }

    #[test]
    fn later_options_take_the_place_of_earlier_ones() {
        let base = options("size = \"64x64\"\ngpu = \"adreno-540\"").expect("options");
        let both = base.with(&options("gpu = \"mali-g715\"\naccel = \"kd\"").expect("options"));
        let all: Vec<(&str, &str)> = both.iter().collect();
        assert_eq!(all, [("size", "64x64"), ("gpu", "mali-g715"), ("accel", "kd")]);
    }

    #[test]
    fn what_is_no_option_is_refused_by_name() {
        for (text, expected) in [
            ("colour = 1", "colour: no such option; use one of: scene, accel"),
            ("set = \"a.b=1\"", "set: no such option"),
            ("size = true", "size: expected text, a number or a list"),
        ] {
            let message = options(text).expect_err("it is wrong").to_string();
            assert!(message.contains(expected), "{message}");
        }
        let message =
            options("accel = \"oak\"").expect("a name").request().expect_err("no such tree").to_string();
        assert!(
            message.contains("invalid value 'oak' for '--accel") && message.contains("wide-bvh"),
            "{message}"
        );
    }
}
