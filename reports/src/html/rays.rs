//! The steps of the rays of a regular sample of pixels, for the pixel that is nearest to the pointer.
//!
//! All rays of a large frame take more steps than a page has room for. The sample is thinned until it fits.

use super::packed::Packed;
use serde::Serialize;

/// Letters of base 64 that a sample may take, so that a page of a megapixel stays below 5 MB with its maps.
const MOST_LETTERS: usize = 2_000_000;

/// Rays of pixels at even distances.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RaySample {
    /// Pixels from one to the next, across and down.
    pub every: u32,
    /// The first pixel.
    pub first: [u32; 2],
    /// Pixels of the sample across and down.
    pub size: [u32; 2],
    /// Names of the sets of rays, of which each pixel has one each.
    pub sets: Vec<String>,
    /// What a step may be; an operation is its place here.
    pub operations: Vec<&'static str>,
    /// Pixel by pixel in rows, and of each set by set.
    pub rays: Vec<Ray>,
}

/// A ray of a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ray {
    /// How it ended.
    pub end: RayEnd,
    /// Operation and id of each step.
    pub steps: Vec<(u8, u32)>,
}

/// How a ray ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayEnd {
    /// There was none to cast.
    NotCast,
    /// It met nothing.
    Miss,
    /// It met this triangle of the scene.
    Hit(u32),
}

/// A sample as the page's script reads it.
#[derive(Serialize)]
struct Data<'a> {
    every: u32,
    first: [u32; 2],
    size: [u32; 2],
    sets: &'a [String],
    operations: &'a [&'static str],
    /// By ray: 0 not cast, 1 a miss, and from 2 on the triangle.
    ends: List,
    /// By ray.
    lengths: List,
    /// Of all steps.
    order: List,
    /// By operation, the ids of its steps: those of one kind are near to each other.
    ids: Vec<List>,
}

#[derive(Serialize)]
struct List {
    count: usize,
    #[serde(flatten)]
    packed: Packed,
}

impl List {
    fn new(values: &[u32]) -> Self {
        Self { count: values.len(), packed: Packed::new(values.len().max(1), values) }
    }
}

impl Data<'_> {
    fn letters(&self) -> usize {
        let Self { ends, lengths, order, ids, .. } = self;
        [ends, lengths, order].into_iter().chain(ids).map(|list| list.packed.letters()).sum()
    }
}

impl RaySample {
    fn data(&self) -> Data<'_> {
        let Self { every, first, size, sets, operations, rays } = self;
        let end = |ray: &Ray| match ray.end {
            RayEnd::NotCast => 0,
            RayEnd::Miss => 1,
            RayEnd::Hit(triangle) => triangle + 2,
        };
        let steps = || rays.iter().flat_map(|ray| &ray.steps);
        let ids = |operation: usize| {
            let of_it = steps().filter(|(of_step, _)| usize::from(*of_step) == operation);
            List::new(&of_it.map(|(_, id)| *id).collect::<Vec<_>>())
        };
        Data {
            every: *every,
            first: *first,
            size: *size,
            sets,
            operations,
            ends: List::new(&rays.iter().map(end).collect::<Vec<_>>()),
            lengths: List::new(&rays.iter().map(|ray| ray.steps.len() as u32).collect::<Vec<_>>()),
            order: List::new(&steps().map(|(operation, _)| u32::from(*operation)).collect::<Vec<_>>()),
            ids: (0..operations.len()).map(ids).collect(),
        }
    }

    /// Every second pixel of every second row.
    fn thinned(&self) -> Self {
        let [columns, rows] = self.size;
        let sets = self.sets.len();
        let kept = (0..rows)
            .step_by(2)
            .flat_map(|row| (0..columns).step_by(2).map(move |column| (row * columns + column) as usize));
        Self {
            every: 2 * self.every,
            size: self.size.map(|side| side.div_ceil(2)),
            rays: kept
                .flat_map(|pixel| self.rays[pixel * sets..(pixel + 1) * sets].iter().cloned())
                .collect(),
            ..self.clone()
        }
    }
}

/// What the page says where it has no sample.
const NONE: &str = "<p class=\"hint\">The page has no steps of rays: this frame traces lists of rays, or those of one pixel are too many.</p>\n";

/// What the script fills, and the data; a sentence where no sample of rays was kept, or one pixel's are too many.
pub(super) fn write(sample: Option<&RaySample>) -> String {
    let Some(sample) = sample.filter(|sample| !sample.rays.is_empty()) else { return NONE.to_owned() };
    let mut thinned = sample.clone();
    loop {
        let data = thinned.data();
        if data.letters() <= MOST_LETTERS {
            return shown(&data);
        }
        if thinned.size == [1, 1] {
            return NONE.to_owned();
        }
        thinned = thinned.thinned();
    }
}

fn shown(data: &Data<'_>) -> String {
    let which = match data.every {
        1 => "every pixel".to_owned(),
        every => format!("one pixel in {every}, across and down"),
    };
    let json = serde_json::to_string(data).expect("strings and whole numbers").replace('<', "\\u003c");
    format!(
        "<h3>Rays of the nearest sampled pixel</h3>\n<div id=\"rays\"></div>\n\
         <p class=\"hint\">The page has the steps of {which}. A node is fetched and tested by its number, with the next one where they come in pairs; a push or pop moves the stack entry at a \
         depth; a triangle is tested by its place in the structure's list of references.</p>\n\
         <script type=\"application/json\" id=\"ray-data\">{json}</script>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(size: [u32; 2], steps: usize) -> RaySample {
        // Noise: products alone have equal differences, which take no room.
        let noise = |n: u32| {
            let n = (n + 1).wrapping_mul(2_654_435_761);
            let n = (n ^ (n >> 15)).wrapping_mul(2_246_822_519);
            (n ^ (n >> 13)) % 100_003
        };
        let ray = |place: u32| Ray {
            end: RayEnd::Hit(place),
            steps: (0..steps as u32).map(|step| (0, noise(1000 * place + step))).collect(),
        };
        RaySample {
            every: 4,
            first: [2, 2],
            size,
            sets: vec!["primary".into()],
            operations: vec!["node"],
            rays: (0..size[0] * size[1]).map(ray).collect(),
        }
    }

    #[test]
    fn a_thinned_sample_keeps_every_second_pixel_of_every_second_row() {
        let thin = sample([3, 4], 1).thinned();
        assert_eq!((thin.every, thin.first, thin.size), (8, [2, 2], [2, 2]));
        let ends: Vec<RayEnd> = thin.rays.iter().map(|ray| ray.end).collect();
        assert_eq!(ends, [0, 2, 6, 8].map(RayEnd::Hit));
    }

    #[test]
    fn a_sample_is_thinned_until_it_fits_and_the_page_says_so() {
        let small = write(Some(&sample([4, 4], 10)));
        assert!(small.contains("one pixel in 4, across and down"));
        let large = write(Some(&sample([64, 64], 1000)));
        assert!(large.len() < MOST_LETTERS + 2000, "{}", large.len());
        assert!(!large.contains("one pixel in 4,") && large.contains("one pixel in "));
        assert!(write(None).contains("no steps of rays"));
    }
}
