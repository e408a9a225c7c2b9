//! The claim files that the program carries.

use super::model::ClaimSet;
use crate::error::Error;

/// A claim file of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Embedded {
    /// The paper's letter, as in the ids of its claims.
    pub letter: &'static str,
    /// Where the file lies in the repository.
    pub file: &'static str,
    /// Its text.
    pub text: &'static str,
}

/// All of them, by letter.
pub const EMBEDDED: &[Embedded] = &[
    Embedded {
        letter: "A",
        file: "configs/claims/sousa-2019.toml",
        text: include_str!("../../../configs/claims/sousa-2019.toml"),
    },
    Embedded {
        letter: "B",
        file: "configs/claims/lee-2017.toml",
        text: include_str!("../../../configs/claims/lee-2017.toml"),
    },
    Embedded {
        letter: "C",
        file: "configs/claims/calvo-lista-2026.toml",
        text: include_str!("../../../configs/claims/calvo-lista-2026.toml"),
    },
];

impl Embedded {
    /// The claims, checked.
    ///
    /// # Errors
    /// When the file is wrong; a test parses every one.
    pub fn parse(&self) -> Result<ClaimSet, Error> {
        ClaimSet::parse(self.text, self.file)
    }
}
