//! Scenes that need no file: data and seeded generators, the same bits on every platform.

mod atrium;
mod builder;
mod car;
mod chess;
mod cornell;
mod figure;
mod laboratory;
mod music_box;
mod newell;
mod numeric;
mod shapes;
mod soup;
mod stadium;
mod teapot;
mod village;

use crate::Scene;
pub use numeric::sin_cos;

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

/// All built-in scenes. Those that stand in for scenes of Lee et al. ("Fast Stereoscopic Rendering on Mobile Ray Tracing GPU
/// for Virtual Reality Applications", 2017) ask for reflection rays, and say which part of their primary hits sends one.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "cornell",
        description: "The Cornell Box as measured at the Cornell University Program of Computer Graphics",
        triangles: 32,
    },
    Builtin {
        name: "teapot",
        description: "The Utah teapot: Newell's 32 patches, tessellated",
        triangles: 16_256,
    },
    Builtin {
        name: "stadium",
        description: "A teapot in a stadium: a dense object in a large sparse one (stands in for Fairy Forest)",
        triangles: 173_696,
    },
    Builtin {
        name: "figure",
        description: "A closed scan-like figure in a box (stands in for scanned statues)",
        triangles: 100_506,
    },
    Builtin {
        name: "atrium",
        description: "A two-storey courtyard with arcades, vaults, curtains and plants (stands in for Crytek Sponza)",
        triangles: 262_176,
    },
    Builtin {
        name: "soup",
        description: "Adversarial triangles: slivers, duplicates, coplanar stacks, no area, huge and tiny coordinates",
        triangles: 10_653,
    },
    Builtin {
        name: "chess",
        description: "A full chess set on a polished board (stands in for Chess of Lee et al. 2017): 2 lights, 69.4 % of the primary hits at 512x256 reflect",
        triangles: 42_048,
    },
    Builtin {
        name: "car",
        description: "A saloon car in a studio, smooth paint and glass (stands in for BMW of Lee et al. 2017): 2 lights, 32.8 % of the primary hits at 512x256 reflect",
        triangles: 54_672,
    },
    Builtin {
        name: "laboratory",
        description: "A chemist's bench full of glassware (stands in for Chemical Lab of Lee et al. 2017): 2 lights, 90.2 % of the primary hits at 512x256 reflect",
        triangles: 98_334,
    },
    Builtin {
        name: "music-box",
        description: "An open music box, pins, comb and gears of polished metal (stands in for Music box of Lee et al. 2017): 2 lights, 54.5 % of the primary hits at 512x256 reflect",
        triangles: 106_138,
    },
    Builtin {
        name: "village",
        description: "A village behind fields of lavender, matte but for a pond (stands in for Provence of Lee et al. 2017): 1 light, 0.95 % of the primary hits at 512x256 reflect",
        triangles: 600_214,
    },
];

/// The built-in scene called `name`.
pub fn builtin(name: &str) -> Option<Scene> {
    match name {
        "cornell" => Some(cornell::scene()),
        "teapot" => Some(teapot::scene()),
        "stadium" => Some(stadium::scene()),
        "figure" => Some(figure::scene()),
        "atrium" => Some(atrium::scene()),
        "soup" => Some(soup::scene()),
        "chess" => Some(chess::scene()),
        "car" => Some(car::scene()),
        "laboratory" => Some(laboratory::scene()),
        "music-box" => Some(music_box::scene()),
        "village" => Some(village::scene()),
        _ => None,
    }
}
