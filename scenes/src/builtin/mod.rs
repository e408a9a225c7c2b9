//! Scenes that need no file: data and seeded generators, the same bits on every platform.

mod cornell;

use crate::Scene;

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Builtin {
    /// The name that [`load`](crate::load) takes.
    pub name: &'static str,
    /// What it is, in one sentence.
    pub description: &'static str,
    /// How many triangles it has.
    pub triangles: usize,
}

/// All built-in scenes, from small to large.
pub const BUILTINS: &[Builtin] = &[Builtin {
    name: "cornell",
    description: "The Cornell Box as measured at the Cornell University Program of Computer Graphics",
    triangles: 32,
}];

/// The built-in scene called `name`.
pub fn builtin(name: &str) -> Option<Scene> {
    match name {
        "cornell" => Some(cornell::scene()),
        _ => None,
    }
}
