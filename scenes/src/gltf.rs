//! glTF 2.0 scenes.
use crate::{Error, load::Geometry};
use std::path::Path;
pub(crate) fn load(path: &Path) -> Result<Geometry, Error> {
    Err(Error::new(path.display().to_string(), "glTF", "later"))
}
