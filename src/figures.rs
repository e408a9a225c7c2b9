//! Single figures of a GPU's description, set on the command line: `--set cache.uche.line=128`.

use anyhow::{anyhow, bail};
use toml::{Table, Value};

/// The description with each of `figures`, `KEY=VALUE`, in place of what it says. The figures count as estimates whose source is
/// the command line.
///
/// # Errors
/// When a key is not a figure of the description, or a value is not one.
pub(crate) fn with_figures(text: &str, file: &str, figures: &[String]) -> anyhow::Result<String> {
    let mut table: Table = text
        .parse()
        .map_err(|error| anyhow!("{file}: {error}; correct the file before setting figures of it"))?;
    for figure in figures {
        let Some((key, value)) = figure.split_once('=') else {
            bail!("--set {figure}: expected KEY=VALUE, such as cache.uche.line=128");
        };
        let parsed: Table = format!("value = {value}").parse().map_err(|_| {
            anyhow!("--set {figure}: '{value}' is not a value; give a number, a list such as [8, 4], or a \"text\"")
        })?;
        let mut known = Vec::new();
        keys("", &Value::Table(table.clone()), &mut known);
        let key = key.trim();
        let Some(found) = find(&mut table, key) else {
            bail!("--set {figure}: {file} has no figure '{key}'; it has: {}", known.join(", "));
        };
        found.insert("value".to_owned(), parsed["value"].clone());
        found.insert("source".to_owned(), Value::String("set on the command line".to_owned()));
        found.insert("tag".to_owned(), Value::String("estimate".to_owned()));
    }
    Ok(toml::to_string(&table)?)
}

/// The figure at a dotted key; entries of an array of tables go by their `name`.
fn find<'a>(table: &'a mut Table, key: &str) -> Option<&'a mut Table> {
    let (first, rest) = key.split_once('.').map_or((key, None), |(first, rest)| (first, Some(rest)));
    match (table.get_mut(first)?, rest) {
        (Value::Table(figure), None) => figure.contains_key("tag").then_some(figure),
        (Value::Table(inner), Some(rest)) => find(inner, rest),
        (Value::Array(entries), Some(rest)) => {
            let (name, rest) = rest.split_once('.')?;
            let mut tables = entries.iter_mut().filter_map(Value::as_table_mut);
            find(tables.find(|table| table.get("name").and_then(Value::as_str) == Some(name))?, rest)
        }
        _ => None,
    }
}

fn keys(path: &str, value: &Value, found: &mut Vec<String>) {
    let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        Value::Table(table) if table.contains_key("tag") => found.push(path.to_owned()),
        Value::Table(table) => table.iter().for_each(|(key, value)| keys(&join(key), value, found)),
        Value::Array(entries) => {
            for entry in entries {
                if let Some(name) = entry.get("name").and_then(Value::as_str) {
                    keys(&join(name), entry, found);
                }
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gpumodel::{BuiltinGpu, Gpu};

    fn adreno_540() -> &'static str {
        BuiltinGpu::named("adreno-540").expect("it is built in").toml
    }

    fn with(figures: &[&str]) -> anyhow::Result<String> {
        let figures: Vec<String> = figures.iter().map(|&figure| figure.to_owned()).collect();
        with_figures(adreno_540(), "gpu.toml", &figures)
    }

    #[test]
    fn figures_are_set_by_their_dotted_keys() {
        let text =
            with(&["cache.uche.line=128", "shader_cores.alu_lanes = 32", "paths.ssbo=[\"tp_l1\", \"uche\"]"])
                .expect("they exist");
        let gpu = Gpu::parse(&text, "set.toml").expect("it is valid");
        assert_eq!((gpu.caches[1].line_bytes, gpu.cores.alu_lanes), (128, 32.0));
        assert_eq!(gpu.paths.ssbo, [0, 1]);
        let before = Gpu::parse(adreno_540(), "gpu.toml").expect("it is valid");
        assert_eq!(
            gpu.provenance().driver + 1,
            before.provenance().driver,
            "a figure that is set is an estimate"
        );
    }

    #[test]
    fn what_is_not_a_figure_or_a_value_is_refused() {
        for (figure, expected) in [
            ("cache.uche.line", "expected KEY=VALUE"),
            ("cache.l9.line=1", "has no figure 'cache.l9.line'; it has: atomics.barrier_clocks"),
            ("cache.uche=1", "has no figure 'cache.uche'"),
            ("identity.name=\"x\"", "has no figure"),
            ("clock.mhz=fast", "is not a value"),
            ("=1", "has no figure ''"),
        ] {
            let message = with(&[figure]).expect_err("it is wrong").to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
