//! Which pixels of a row of the right image the left one answers.

/// Where a pixel of the right image comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// What the left image shows in this column of the same row.
    Left(u32),
    /// Nothing that the left image shows lands here: it is hidden from the left eye, beyond the edge of its image, or between two pixels of a surface
    /// that the right eye sees at a steeper angle.
    Missing,
    /// Something lands here, but the surface between two other pixels that lie side by side in the left image would be in front of it.
    Covered,
}

/// A pixel of the left image, where the right one has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// Column, in pixels from the left edge.
    pub(super) x: f64,
    /// One over its depth along the view; 0 for the sky.
    pub(super) inverse_depth: f64,
}

/// Surfaces this close to each other, as a part of their inverse depth, do not cover each other: a hit is known in f32.
const TOLERANCE: f64 = 1e-5;

/// A row of as many pixels as the left image has in it, `samples` from left to right.
///
/// Of several samples that land in one pixel, the nearest is taken. It has to stand the row test: nothing between two neighbours of the left row, taken as
/// joined by a surface, is in front of it. That also rejects some pixels that are seen past an edge, and so never shows what a surface hides that
/// the left eye sees at a grazing angle.
pub(super) fn sources(samples: &[Sample]) -> Vec<Source> {
    let width = samples.len();
    let mut sources = vec![Source::Missing; width];
    for (column, sample) in (0..).zip(samples) {
        let Some(source) = pixel(sample.x, width).map(|pixel| &mut sources[pixel]) else { continue };
        match *source {
            Source::Left(other) if samples[other as usize].inverse_depth >= sample.inverse_depth => {}
            _ => *source = Source::Left(column),
        }
    }
    for (first, pair) in (0..).zip(samples.windows(2)) {
        let (mut left, mut right) = (pair[0], pair[1]);
        if left.x > right.x {
            (left, right) = (right, left);
        }
        let last = (right.x.ceil().max(0.0) as usize).min(width);
        for source in &mut sources[(left.x.max(0.0) as usize).min(last)..last] {
            let Source::Left(column) = *source else { continue };
            let sample = samples[column as usize];
            if column == first || column == first + 1 || sample.x <= left.x || sample.x >= right.x {
                continue;
            }
            // On the straight line between two points, the inverse depth is linear in the image.
            let part = (sample.x - left.x) / (right.x - left.x);
            let between = left.inverse_depth + (right.inverse_depth - left.inverse_depth) * part;
            if between > sample.inverse_depth + TOLERANCE * between {
                *source = Source::Covered;
            }
        }
    }
    sources
}

/// The pixel that a point is in; `None` beyond the edges.
fn pixel(x: f64, width: usize) -> Option<usize> {
    (x >= 0.0 && x < width as f64).then_some(x as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn row(samples: &[(f64, f64)]) -> Vec<Source> {
        let samples: Vec<Sample> =
            samples.iter().map(|&(x, depth)| Sample { x, inverse_depth: 1.0 / depth }).collect();
        sources(&samples)
    }

    #[test]
    fn a_pixel_that_nothing_lands_in_is_missing_and_what_leaves_the_image_is_dropped() {
        let found = row(&[(-0.5, 2.0), (0.5, 2.0), (1.5, 2.0), (2.5, 2.0)]);
        assert_eq!(found, [Source::Left(1), Source::Left(2), Source::Left(3), Source::Missing]);
    }

    #[test]
    fn of_several_samples_the_nearest_is_taken_in_either_order() {
        assert_eq!(row(&[(0.2, 5.0), (0.8, 2.0), (1.5, 2.0)])[0], Source::Left(1));
        assert_eq!(row(&[(0.2, 2.0), (0.8, 5.0), (1.5, 5.0)])[0], Source::Left(0));
    }

    #[test]
    fn a_background_does_not_show_through_a_surface_that_the_right_eye_sees_at_a_steeper_angle() {
        // Two pixels of a wall at depth 1 come to lie two apart; a sample of what is far behind lands between them.
        let found = row(&[(1.5, 9.0), (0.5, 1.0), (2.5, 1.0)]);
        assert_eq!(found, [Source::Left(1), Source::Covered, Source::Left(2)]);
        // In front of the wall it is seen.
        assert_eq!(row(&[(1.5, 0.5), (0.5, 1.0), (2.5, 1.0)])[1], Source::Left(0));
    }

    #[test]
    fn sky_is_behind_everything_and_covers_nothing() {
        let sky = f64::INFINITY;
        assert_eq!(row(&[(1.5, 3.0), (0.5, sky), (2.5, sky)])[1], Source::Left(0));
        assert_eq!(row(&[(1.5, sky), (0.5, 3.0), (2.5, 3.0)])[1], Source::Covered);
    }

    proptest! {
        #[test]
        fn a_sample_is_used_once_and_where_it_lands(samples in prop::collection::vec((-4.0_f64..40.0, 0.1_f64..1e6), 1..36)) {
            let found = row(&samples);
            prop_assert_eq!(found.len(), samples.len());
            for (pixel, source) in found.iter().enumerate() {
                let landed: Vec<usize> =
                    (0..samples.len()).filter(|&of| samples[of].0.floor() == pixel as f64).collect();
                match *source {
                    Source::Left(column) => {
                        prop_assert!(landed.contains(&(column as usize)));
                        let nearest = landed.iter().map(|&of| samples[of].1).fold(f64::INFINITY, f64::min);
                        prop_assert_eq!(samples[column as usize].1, nearest);
                    }
                    Source::Missing => prop_assert!(landed.is_empty()),
                    Source::Covered => prop_assert!(!landed.is_empty()),
                }
            }
        }

        #[test]
        fn of_one_plane_nothing_is_covered(slope in -0.9_f64..20.0, start in -3.0_f64..3.0, tilt in -0.01_f64..0.01) {
            // Columns move evenly, and the inverse depth is linear in them.
            let samples: Vec<(f64, f64)> =
                (0..32).map(|column| (start + (1.0 + slope) * f64::from(column), 1.0 / (1.0 + tilt * f64::from(column)))).collect();
            prop_assert!(row(&samples).iter().all(|&source| source != Source::Covered));
        }
    }
}
