//! Material libraries (`.mtl`): the statements that decide which work a surface causes.
//!
//! Why not the crate tobj (4.0.5): its reader panics on `Kd 0.5`, which the format allows (one value stands for all three),
//! and gives up the whole library at the first statement it cannot read. Statements that are missing or malformed
//! here leave the default, because a scene can be traced without its materials.

use crate::{Material, Reflection};
use glam::Vec3;

/// Longest library read, in bytes.
pub const MAX_BYTES: u64 = 16 << 20;

/// The materials of a library, in file order. Never fails: what cannot be understood is skipped.
pub fn parse(bytes: &[u8]) -> Vec<Material> {
    let text = String::from_utf8_lossy(bytes);
    let mut materials: Vec<Material> = Vec::new();
    for line in text.lines() {
        let line = line.split_once('#').map_or(line, |(before, _)| before).trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        if keyword == "newmtl" {
            materials.push(Material::matte(rest, Vec3::splat(0.8)));
        } else if let Some(material) = materials.last_mut() {
            apply(material, keyword, rest);
        }
    }
    materials
}

fn apply(material: &mut Material, keyword: &str, rest: &str) {
    match keyword {
        "Kd" => set(&mut material.diffuse, colour(rest)),
        "Ks" => set(&mut material.specular, colour(rest)),
        "Ke" => set(&mut material.emission, colour(rest)),
        "Ns" => set(&mut material.roughness, number(rest).map(roughness)),
        "illum" => set(&mut material.reflection, rest.parse().ok().map(reflection)),
        "map_d" => material.alpha_tested |= !rest.is_empty(),
        "map_Kd" | "map_Ka" | "map_Ks" | "map_Ns" | "map_Ke" | "map_bump" | "map_Bump" | "bump" | "norm"
        | "disp" | "map_Pr" | "map_Pm" => material.textured |= !rest.is_empty(),
        _ => {}
    }
}

fn set<T>(slot: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *slot = value;
    }
}

fn number(text: &str) -> Option<f32> {
    text.split_whitespace().next()?.parse().ok().filter(|x: &f32| x.is_finite())
}

/// `r g b`, or `r` for a grey; spectral files and XYZ colours are not read.
fn colour(text: &str) -> Option<Vec3> {
    let mut words = text.split_whitespace();
    let red = number(words.next()?)?;
    let Some(green) = words.next() else { return Some(Vec3::splat(red)) };
    Some(Vec3::new(red, number(green)?, number(words.next()?)?))
}

/// The Beckmann roughness with the same lobe width as Phong exponent `ns` (Walter et al. 2007), square-rooted to the
/// perceptual scale of glTF.
fn roughness(ns: f32) -> f32 {
    (2.0 / (ns.max(0.0) + 2.0)).sqrt().sqrt()
}

fn reflection(illum: u32) -> Reflection {
    match illum {
        3 | 5 => Reflection::Mirror,
        4 | 6 | 7 => Reflection::Glass,
        _ => Reflection::None,
    }
}
