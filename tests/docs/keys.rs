//! Keys of GPUs and techniques.

use crate::page::{Kind, Page};
use std::path::PathBuf;

#[test]
fn every_key_of_the_built_in_descriptions_is_explained() {
    for (page, folder) in
        [("docs/your-gpu.md", "configs/gpus"), ("docs/your-technique.md", "configs/techniques")]
    {
        let page = Page::read(page);
        let explained = |key: &str| {
            page.items.iter().any(|item| matches!(&item.kind, Kind::Code { text, .. } if text == key))
        };
        for file in std::fs::read_dir(crate::root().join(folder)).expect("a folder") {
            let path: PathBuf = file.expect("a file").path();
            let table: toml::Table = std::fs::read_to_string(&path).expect("a text").parse().expect("TOML");
            for key in keys("", &toml::Value::Table(table)) {
                assert!(explained(&key), "{}: `{key}` of {} is not explained", page.name, path.display());
            }
        }
    }
}

/// Dotted keys of all figures and texts; entries of a list of tables go by its name alone.
fn keys(path: &str, value: &toml::Value) -> Vec<String> {
    match value {
        toml::Value::Table(table) if !table.contains_key("tag") => {
            let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
            table.iter().flat_map(|(key, value)| keys(&join(key), value)).collect()
        }
        toml::Value::Array(items) => items.iter().flat_map(|item| keys(path, item)).collect(),
        _ => vec![path.to_owned()],
    }
}
