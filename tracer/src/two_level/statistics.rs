//! What a structure costs a ray that is not known yet.

use super::bottom_level::BottomLevel;
use super::structure::TwoLevel;
use super::{empty_space, overlap};
use crate::aabb::Aabb;
use crate::triangle::RayTriangle;
use rayon::prelude::*;

/// Facts about a two-level structure; shares are from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoLevelStatistics {
    /// Instances, those of empty meshes included.
    pub instances: u64,
    /// Instances whose box a random ray meets, of those rays that meet the box around all instances, by the surface area heuristic (Goldsmith &
    /// Salmon 1987): BLASes that it enters where no hit ends it sooner. `None` when that box has no area.
    pub expected_entries: Option<f64>,
    /// Share of the volume of the instances' boxes, each counted, that lies in another one as well, within 0.8 % (one standard
    /// error). Boxes without thickness have no part in it; `None` when there is no other.
    pub overlap_share: Option<f64>,
    /// One per mesh.
    pub blases: Vec<BlasStatistics>,
}

/// Facts about the BLAS of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlasStatistics {
    /// Instances of the mesh.
    pub instances: u64,
    /// Triangles.
    pub triangles: u64,
    /// Share of the random rays through its box that meet the box of no leaf, within 1.6 % (one standard error). `None` when its box
    /// has no area.
    pub empty_share: Option<f64>,
}

impl<P: RayTriangle, T: BottomLevel<P>> TwoLevel<P, T> {
    /// Measures the structure: shares by samples of fixed size, so in linear time. The same on any machine and number of threads.
    pub fn statistics(&self) -> TwoLevelStatistics {
        let all = self.instances.iter().fold(Aabb::EMPTY, |all, placed| all.union(placed.bounds));
        let area = all.half_area();
        let areas: f64 = self.instances.iter().map(|placed| placed.bounds.half_area()).sum();
        let mut counts = vec![0; self.blases.len()];
        for placed in &self.instances {
            counts[placed.mesh as usize] += 1;
        }
        let blas = |(blas, instances): (&super::structure::Blas<T>, u64)| BlasStatistics {
            instances,
            triangles: blas.tree.references().len() as u64,
            empty_share: empty_space::missed_leaves(&blas.tree.bounds(), |ray| blas.tree.meets_leaf(ray)),
        };
        TwoLevelStatistics {
            instances: self.instances.len() as u64,
            expected_entries: (area > 0.0).then(|| areas / area),
            overlap_share: overlap::shared_volume(&self.tlas, &self.instances),
            blases: self.blases.par_iter().zip(counts).map(blas).collect(),
        }
    }
}
