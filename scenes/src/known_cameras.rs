//! Cameras and lights in common use for public scenes whose files carry none, keyed by file name without extension.

use crate::Camera;
use glam::Vec3;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// One entry of `data/cameras.toml`: a whole view, or only which way is up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct KnownCamera {
    pub(crate) view: Option<Camera>,
    pub(crate) up: Option<Vec3>,
    pub(crate) light: Option<Vec3>,
}

/// The entry for a scene called `stem`.
pub(crate) fn find(stem: &str) -> Option<&'static KnownCamera> {
    static TABLE: OnceLock<BTreeMap<String, KnownCamera>> = OnceLock::new();
    TABLE.get_or_init(|| table().unwrap_or_default()).get(stem)
}

/// The shipped table; a test sees to it that it can be read.
fn table() -> Result<BTreeMap<String, KnownCamera>, toml::de::Error> {
    toml::from_str(include_str!("../data/cameras.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_is_readable_and_every_view_is_valid() {
        let table = table().unwrap();
        assert!(table.len() >= 11);
        for (name, entry) in table {
            assert!(entry.view.is_some() || entry.up.is_some(), "{name} says nothing");
            if let Some(view) = entry.view {
                view.validate(&name).unwrap();
            }
        }
    }

    #[test]
    fn a_name_that_is_not_listed_has_no_camera() {
        assert!(find("sponza_crytek_262k").is_some());
        assert!(find("sponza_crytek_262k.obj").is_none() && find("").is_none());
    }
}
