//! Helpers shared by the tests of this crate.
#![allow(dead_code, reason = "each test file is its own crate and uses some of these")]

use scenes::{Triangle, Vec3};
use std::io::Read;
use std::path::{Path, PathBuf};

/// An OBJ parser that is as plain as can be: `v` and `f` lines, a fan per face, file order.
pub(crate) fn plain_triangles(text: &str) -> Vec<Triangle> {
    let mut vertices: Vec<Vec3> = Vec::new();
    let mut corners: Vec<[i64; 3]> = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let c: Vec<f32> = words.take(3).map(|w| w.parse().unwrap()).collect();
                vertices.push(Vec3::new(c[0], c[1], c[2]));
            }
            Some("f") => {
                let k: Vec<i64> = words
                    .map(|w| w.split('/').next().unwrap().parse().unwrap())
                    .map(|i: i64| if i > 0 { i - 1 } else { vertices.len() as i64 + i })
                    .collect();
                corners.extend((2..k.len()).map(|i| [k[0], k[i - 1], k[i]]));
            }
            _ => {}
        }
    }
    corners.iter().map(|t| Triangle { v: t.map(|i| vertices[i as usize]) }).collect()
}

/// The bits of all coordinates, so that -0 differs from 0.
pub(crate) fn bits(triangles: &[Triangle]) -> Vec<u32> {
    triangles.iter().flat_map(|t| t.v).flat_map(|p| p.to_array()).map(f32::to_bits).collect()
}

/// A real scene beside the workspace, or `None` after saying that the test is skipped.
pub(crate) fn real_scene(file: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes").join(file);
    if path.is_file() {
        return Some(path);
    }
    eprintln!("skipped: {file} is not beside the workspace");
    None
}

/// The decompressed text of a real scene.
pub(crate) fn text_of(path: &Path) -> String {
    let mut bytes = Vec::new();
    zstd::Decoder::new(std::fs::File::open(path).unwrap()).unwrap().read_to_end(&mut bytes).unwrap();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Writes `bytes` to `name` in a fresh folder; the folder lives as long as the first result.
pub(crate) fn file(name: &str, bytes: &[u8]) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path.to_str().unwrap().to_owned())
}
