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
    TABLE.get_or_init(|| toml::from_str(include_str!("../data/cameras.toml")).unwrap_or_default()).get(stem)
}
