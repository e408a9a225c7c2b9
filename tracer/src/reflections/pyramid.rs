//! The least depths of ever larger squares of pixels.

/// A pyramid of least depths: level 0 is the depth buffer, and each level halves both edges of the one below, rounding up, to one texel.
///
/// Texel (`x`, `y`) of a level holds the least depth of its up to four children, (2x, 2y) to (2x + 1, 2y + 1), as far as these exist. So it
/// covers the pixels from `x * 2^level` until `(x + 1) * 2^level`, whatever the size of the image: rounding up, no row is left over at
/// odd edges (a mip chain that rounds down has to read a third row there).
///
/// Depths are along the view, in units of the scene; infinite where there is no surface. Memory: 16/3 bytes per pixel and a little.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthPyramid {
    levels: Vec<Level>,
}

#[derive(Clone, Debug, PartialEq)]
struct Level {
    width: u32,
    height: u32,
    depths: Vec<f32>,
}

impl DepthPyramid {
    /// Over a depth buffer of `width` pixels per row.
    pub(crate) fn new(width: u32, height: u32, depths: Vec<f32>) -> Self {
        let mut levels = vec![Level { width, height, depths }];
        while let Some(level) = levels.last().filter(|level| level.width > 1 || level.height > 1) {
            levels.push(level.halved());
        }
        Self { levels }
    }

    /// Number of levels: 1 for a single pixel.
    pub fn levels(&self) -> u32 {
        self.levels.len() as u32
    }

    /// Width and height of a level in texels.
    ///
    /// # Panics
    /// When there is no such level.
    pub fn size(&self, level: u32) -> [u32; 2] {
        let Level { width, height, .. } = self.levels[level as usize];
        [width, height]
    }

    /// A texel, (0, 0) at the top left.
    ///
    /// # Panics
    /// When there is no such texel.
    #[inline]
    pub fn depth(&self, level: u32, x: u32, y: u32) -> f32 {
        self.levels[level as usize].at(x, y)
    }

    /// The least depth of the image.
    pub fn nearest(&self) -> f32 {
        self.levels.last().and_then(|level| level.depths.first()).copied().unwrap_or(f32::INFINITY)
    }
}

impl Level {
    #[inline]
    fn at(&self, x: u32, y: u32) -> f32 {
        self.depths[y as usize * self.width as usize + x as usize]
    }

    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let children = |x: u32, edge: u32| [2 * x, (2 * x + 1).min(edge - 1)];
        let least = |x: u32, y: u32| {
            let rows = children(y, self.height).map(|y| children(x, self.width).map(|x| self.at(x, y)));
            rows.as_flattened().iter().copied().fold(f32::INFINITY, f32::min)
        };
        let depths = (0..height).flat_map(|y| (0..width).map(move |x| least(x, y))).collect();
        Self { width, height, depths }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn image() -> impl Strategy<Value = (u32, u32, Vec<f32>)> {
        (1..40_u32, 1..40_u32).prop_flat_map(|(width, height)| {
            let depth = prop_oneof![4 => 0.1_f32..100.0, 1 => Just(f32::INFINITY)];
            (Just(width), Just(height), prop::collection::vec(depth, (width * height) as usize))
        })
    }

    proptest! {
        #[test]
        fn each_texel_is_the_least_depth_of_the_pixels_that_it_covers((width, height, depths) in image()) {
            let pyramid = DepthPyramid::new(width, height, depths.clone());
            for level in 0..pyramid.levels() {
                let edge = 1 << level;
                prop_assert_eq!(pyramid.size(level), [width.div_ceil(edge), height.div_ceil(edge)]);
                let mut least = vec![f32::INFINITY; depths.len()];
                let [texels, rows] = pyramid.size(level);
                for (pixel, &depth) in (0..).zip(&depths) {
                    let texel = (pixel / width / edge * texels + pixel % width / edge) as usize;
                    least[texel] = least[texel].min(depth);
                }
                for (x, y) in (0..texels).flat_map(|x| (0..rows).map(move |y| (x, y))) {
                    prop_assert_eq!(pyramid.depth(level, x, y), least[(y * texels + x) as usize]);
                }
            }
            prop_assert_eq!(pyramid.size(pyramid.levels() - 1), [1, 1]);
            prop_assert_eq!(pyramid.nearest(), depths.iter().copied().fold(f32::INFINITY, f32::min));
        }
    }
}
