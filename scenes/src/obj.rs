//! The geometry of Wavefront OBJ files: `v`, `vn`, `f`, `usemtl`, `mtllib`, read as a stream of lines.
//!
//! Order is the contract: triangles come in file order, and a polygon `v0 v1 .. vn` becomes the fan
//! `(v0, v[i-1], v[i])`. Coordinates are the f32 nearest to the decimal in the file (rounded once). Degenerate
//! triangles are kept. Negative indices count back from the last vertex read so far; positive ones may point
//! ahead. `o`, `g`, `s` and texture coordinates do not change the triangles and are skipped.
//!
//! Why not the crate tobj (4.0.5): it accepts NaN and infinite coordinates, does not say on which line an error is,
//! refuses files that are not UTF-8 and faces with a comment behind them, and takes 2.4 to
//! 2.8 times as long on scenes of 66 thousand to 1.1 million triangles. It is the twin in the tests: where both
//! accept a file, they must give the same triangles.

use crate::{Error, MAX_TRIANGLES, MAX_VERTICES, Mesh, Normals, Note};
use glam::Vec3;
use std::collections::HashMap;
use std::io::{BufRead, Read};

/// Longest line accepted, in bytes; a logical line joined by `\` counts whole.
pub const MAX_LINE: usize = 1 << 20;

/// What an OBJ file holds, before its material libraries are looked up.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjFile {
    /// All faces as one mesh; its material ids index `material_names`.
    pub mesh: Mesh,
    /// Material names in order of first use; `None` for faces before the first `usemtl`.
    pub material_names: Vec<Option<String>>,
    /// The files named by `mtllib`, in file order.
    pub libraries: Vec<String>,
    /// What the file lacks or what was skipped.
    pub notes: Vec<Note>,
}

/// Parses a whole OBJ text. `name` stands for the file in errors.
pub fn parse(bytes: &[u8], name: &str) -> Result<ObjFile, Error> {
    read(bytes, name)
}

/// Parses an OBJ text from a stream. Memory follows the geometry read so far, never the length of the stream.
pub fn read(mut input: impl BufRead, name: &str) -> Result<ObjFile, Error> {
    let mut parser = Parser::new(name);
    let mut line = Vec::new();
    while parser.next_line(&mut input, &mut line)? {
        parser.statement(&line)?;
    }
    parser.finish()
}

/// An index that must be checked once the whole file is known.
#[derive(Clone, Copy, Default)]
struct Largest {
    index: u32,
    line: u64,
}

struct Parser<'a> {
    name: &'a str,
    /// Physical lines read.
    lines: u64,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    normal_ids: Vec<Option<[u32; 3]>>,
    any_normal_id: bool,
    materials: Vec<u32>,
    material: Option<u32>,
    material_ids: HashMap<Option<String>, u32>,
    material_names: Vec<Option<String>>,
    libraries: Vec<String>,
    largest_position: Largest,
    largest_normal: Largest,
    bad_normal_line: Option<u64>,
    points_and_lines: u64,
    corners: Vec<(u32, Option<u32>)>,
}

impl<'a> Parser<'a> {
    fn new(name: &'a str) -> Self {
        Parser {
            name,
            lines: 0,
            positions: Vec::new(),
            normals: Vec::new(),
            triangles: Vec::new(),
            normal_ids: Vec::new(),
            any_normal_id: false,
            materials: Vec::new(),
            material: None,
            material_ids: HashMap::new(),
            material_names: Vec::new(),
            libraries: Vec::new(),
            largest_position: Largest::default(),
            largest_normal: Largest::default(),
            bad_normal_line: None,
            points_and_lines: 0,
            corners: Vec::new(),
        }
    }

    fn error(&self, problem: impl Into<String>, remedy: impl Into<String>) -> Error {
        Error::new(self.name, problem, remedy).at_line(self.lines)
    }

    /// Reads one logical line into `line`, without its end; false at the end of the input.
    fn next_line(&mut self, input: &mut impl BufRead, line: &mut Vec<u8>) -> Result<bool, Error> {
        line.clear();
        loop {
            let room = (MAX_LINE + 1 - line.len()) as u64;
            let read = input.by_ref().take(room).read_until(b'\n', line).map_err(|e| {
                self.error(
                    format!("reading stopped: {e}"),
                    "check that the file is whole and what its name says",
                )
            })?;
            if read == 0 {
                return Ok(!line.is_empty());
            }
            self.lines += 1;
            if line.len() > MAX_LINE {
                return Err(self.error(
                    format!("a line is longer than {MAX_LINE} bytes, so this is not an OBJ text"),
                    "give a Wavefront OBJ file",
                ));
            }
            while let Some(b'\n' | b'\r') = line.last() {
                line.pop();
            }
            if line.last() != Some(&b'\\') {
                return Ok(true);
            }
            line.pop();
            line.push(b' ');
        }
    }

    fn statement(&mut self, line: &[u8]) -> Result<(), Error> {
        let line = line.trim_ascii();
        let (keyword, rest) = split_word(line);
        match keyword {
            b"v" => self.vertex(rest),
            b"vn" => self.normal(rest),
            b"f" => self.face(rest),
            b"usemtl" => {
                self.use_material(rest);
                Ok(())
            }
            b"mtllib" => {
                let library = String::from_utf8_lossy(rest).into_owned();
                if !library.is_empty() && !self.libraries.contains(&library) {
                    self.libraries.push(library);
                }
                Ok(())
            }
            b"p" | b"l" => {
                self.points_and_lines += 1;
                Ok(())
            }
            _ if line.contains(&0) => Err(self.error(
                "a zero byte, expected text",
                "this is a binary file: give a Wavefront OBJ text, or a .gltf, .glb or .obj.zst by its own extension",
            )),
            _ => Ok(()),
        }
    }

    fn vertex(&mut self, rest: &[u8]) -> Result<(), Error> {
        let p = self.vector(rest, "v x y z")?;
        if !p.is_finite() {
            return Err(self.error(
                format!("a vertex at ({}, {}, {}), expected finite numbers that f32 can hold", p.x, p.y, p.z),
                "export the mesh again",
            ));
        }
        if self.positions.len() == MAX_VERTICES {
            let problem = format!("more than {MAX_VERTICES} vertices");
            return Err(self.error(problem, "split or simplify the mesh"));
        }
        self.positions.push(p);
        Ok(())
    }

    fn normal(&mut self, rest: &[u8]) -> Result<(), Error> {
        let n = self.vector(rest, "vn x y z")?;
        if self.normals.len() == MAX_VERTICES {
            let problem = format!("more than {MAX_VERTICES} normals");
            return Err(self.error(problem, "split or simplify the mesh"));
        }
        if !n.is_finite() {
            self.bad_normal_line.get_or_insert(self.lines);
        }
        self.normals.push(n);
        Ok(())
    }

    /// The first three numbers of a statement; further ones (weights, vertex colours) are skipped.
    fn vector(&self, rest: &[u8], form: &str) -> Result<Vec3, Error> {
        let mut words = Words(rest);
        let mut values = [0.0f32; 3];
        for value in &mut values {
            let word = words.next().unwrap_or_default();
            *value = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()).ok_or_else(|| {
                let found = if word.is_empty() { "the end of the line".into() } else { quoted(word) };
                self.error(format!("expected a number as in '{form}', found {found}"), "repair the line")
            })?;
        }
        Ok(Vec3::from_array(values))
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), Error> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        for word in Words(rest) {
            corners.push(self.corner(word)?);
        }
        if corners.len() < 3 {
            return Err(self.error(
                format!("a face with {} corners, expected at least 3", corners.len()),
                "repair or remove the face",
            ));
        }
        let added = corners.len() - 2;
        if self.triangles.len() + added > MAX_TRIANGLES {
            let problem = format!("more than {MAX_TRIANGLES} triangles");
            return Err(self.error(problem, "split or simplify the mesh"));
        }
        let material = match self.material {
            Some(id) => id,
            None => self.select(None),
        };
        for i in 2..corners.len() {
            let fan = [corners[0], corners[i - 1], corners[i]];
            self.triangles.push(fan.map(|(p, _)| p));
            let normals = match fan.map(|(_, n)| n) {
                [Some(a), Some(b), Some(c)] => Some([a, b, c]),
                _ => None,
            };
            if normals.is_some() && !self.any_normal_id {
                self.any_normal_id = true;
                self.normal_ids.resize(self.triangles.len() - 1, None);
            }
            if self.any_normal_id {
                self.normal_ids.push(normals);
            }
            self.materials.push(material);
        }
        self.corners = corners;
        Ok(())
    }

    /// A corner `p`, `p/t`, `p//n` or `p/t/n`, as position and normal index counted from 0.
    fn corner(&mut self, word: &[u8]) -> Result<(u32, Option<u32>), Error> {
        let mut parts = word.split(|&b| b == b'/');
        let position = parts.next().and_then(integer);
        let texture = parts.next().filter(|t| !t.is_empty()).map(integer);
        let normal = parts.next().filter(|n| !n.is_empty()).map(integer);
        let (Some(position), None) = (position, parts.next()) else {
            return Err(self.bad_corner(word));
        };
        if texture == Some(None) || normal == Some(None) {
            return Err(self.bad_corner(word));
        }
        let position = self.resolve(position, self.positions.len(), "vertex")?;
        if position >= self.largest_position.index {
            self.largest_position = self.largest_position.seen(position, self.lines);
        }
        let Some(Some(normal)) = normal else { return Ok((position, None)) };
        let normal = self.resolve(normal, self.normals.len(), "normal")?;
        if normal >= self.largest_normal.index {
            self.largest_normal = self.largest_normal.seen(normal, self.lines);
        }
        Ok((position, Some(normal)))
    }

    fn bad_corner(&self, word: &[u8]) -> Error {
        self.error(
            format!("expected a corner as in 'f 1/1/1 2/2/2 3/3/3', found {}", quoted(word)),
            "indices are whole numbers, from 1 or negative",
        )
    }

    fn resolve(&self, index: i64, known: usize, what: &str) -> Result<u32, Error> {
        let from_zero = if index > 0 { index - 1 } else { known as i64 + index };
        match u32::try_from(from_zero) {
            Ok(i) if index != 0 && (i as usize) < MAX_VERTICES => Ok(i),
            _ => Err(self.error(
                format!("{what} index {index}, where {known} are known so far"),
                "indices count from 1, or backwards from -1",
            )),
        }
    }

    fn use_material(&mut self, name: &[u8]) {
        let name = String::from_utf8_lossy(name).into_owned();
        self.material = Some(self.select(Some(name)));
    }

    fn select(&mut self, name: Option<String>) -> u32 {
        if let Some(&id) = self.material_ids.get(&name) {
            return id;
        }
        let id = self.material_names.len() as u32;
        self.material_names.push(name.clone());
        self.material_ids.insert(name, id);
        id
    }

    fn finish(mut self) -> Result<ObjFile, Error> {
        if self.lines == 0 {
            return Err(Error::new(self.name, "the file is empty (0 bytes)", "give a Wavefront OBJ file"));
        }
        if self.triangles.is_empty() {
            let problem = format!("no face among {} lines and {} vertices", self.lines, self.positions.len());
            return Err(Error::new(
                self.name,
                problem,
                "a scene needs at least one 'f' statement: export triangles or polygons",
            ));
        }
        self.check_largest("vertex", self.largest_position, self.positions.len())?;
        let mut notes = Vec::new();
        let normals = self.take_normals(&mut notes)?;
        if self.points_and_lines > 0 {
            let text = format!(
                "{} point or line elements were skipped: only faces are traced.",
                self.points_and_lines
            );
            notes.push(Note::Missing(text));
        }
        let mesh = Mesh {
            name: self.name.to_owned(),
            positions: self.positions,
            triangles: self.triangles,
            normals,
            materials: self.materials,
        };
        Ok(ObjFile { mesh, material_names: self.material_names, libraries: self.libraries, notes })
    }

    fn check_largest(&self, what: &str, largest: Largest, count: usize) -> Result<(), Error> {
        if (largest.index as usize) < count || largest.line == 0 {
            return Ok(());
        }
        let problem =
            format!("{what} index {}, but the whole file has {count}", u64::from(largest.index) + 1);
        Err(Error::new(self.name, problem, "the file is cut short or damaged: export it again")
            .at_line(largest.line))
    }

    fn take_normals(&mut self, notes: &mut Vec<Note>) -> Result<Option<Normals>, Error> {
        self.check_largest("normal", self.largest_normal, self.normals.len())?;
        if !self.any_normal_id {
            notes.push(Note::Missing("The file has no shading normals.".into()));
            return Ok(None);
        }
        if let Some(line) = self.bad_normal_line {
            notes.push(Note::Missing(format!(
                "The normal on line {line} is not finite, so the shading normals of the file were dropped."
            )));
            return Ok(None);
        }
        let without = self.normal_ids.iter().filter(|n| n.is_none()).count();
        if without > 0 {
            let all = self.normal_ids.len();
            notes.push(Note::Missing(format!("{without} of {all} triangles have no shading normals.")));
        }
        Ok(Some(Normals {
            vectors: std::mem::take(&mut self.normals),
            triangles: std::mem::take(&mut self.normal_ids),
        }))
    }
}

impl Largest {
    /// Keeps the line on which the largest index occurred first.
    fn seen(self, index: u32, line: u64) -> Largest {
        if self.line != 0 && index == self.index { self } else { Largest { index, line } }
    }
}

/// The words of a line, between ASCII white space.
struct Words<'a>(&'a [u8]);

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let (word, rest) = split_word(self.0);
        self.0 = rest;
        (!word.is_empty()).then_some(word)
    }
}

/// The first word of `line`, cut at `#`, and what follows it, both trimmed.
fn split_word(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii_start();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    let (word, rest) = line.split_at(end);
    if word.first() == Some(&b'#') { (&[], &[]) } else { (word, rest.trim_ascii_start()) }
}

/// A decimal integer with an optional sign, of at most 18 digits.
fn integer(text: &[u8]) -> Option<i64> {
    let (negative, digits) = match text {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(digit - b'0');
    }
    Some(if negative { -value } else { value })
}

/// A word as an error shows it: short, and printable whatever the file holds.
fn quoted(word: &[u8]) -> String {
    let shown = word[..word.len().min(24)].escape_ascii();
    if word.len() > 24 { format!("'{shown}...'") } else { format!("'{shown}'") }
}
