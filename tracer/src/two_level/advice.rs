//! What to change in a scene for its structure's sake: "avoid BLAS overlap, empty space and small BLASes" (Calvo Lista, "Mobile Ray
//! Tracing Demystified", Arm, Vulkanised 2026).

use super::statistics::{BlasStatistics, TwoLevelStatistics};

/// Fewest triangles of a BLAS that does not count as small, unless a caller says otherwise. To reach it costs a ray the record of the
/// instance, a transform and the root; 64 triangles are four or five levels of a tree, which is as much. The talk gives no number.
pub const SMALL_BLAS_TRIANGLES: u64 = 64;

/// Largest share of overlap that needs no word. The talk gives no number.
const LARGE_OVERLAP: f64 = 0.25;

/// Largest share of empty space that needs no word: a ball in its box has 48 %. The talk gives no number.
const MUCH_EMPTY_SPACE: f64 = 0.6;

impl TwoLevelStatistics {
    /// What the structure suffers from, and what to do about it, in sentences. BLASes of fewer than `small_blas_triangles` are small, see
    /// [`SMALL_BLAS_TRIANGLES`].
    pub fn warnings(&self, small_blas_triangles: u64) -> Vec<String> {
        let overlap = self.overlap_share.filter(|&share| share > LARGE_OVERLAP).map(|share| {
            let entries = self.expected_entries.unwrap_or(0.0);
            format!(
                "{:.0} % of the volume of the instances' boxes lies in more than one of them, and a random ray enters {entries:.1} \
                 BLASes: keep instances apart, or make one BLAS of those that interpenetrate.",
                100.0 * share
            )
        });
        [overlap, self.empty_space(), self.small_blases(small_blas_triangles)].into_iter().flatten().collect()
    }

    /// The BLASes that are in the scene, with the numbers of their meshes.
    fn placed(&self) -> impl Iterator<Item = (usize, &BlasStatistics)> {
        self.blases.iter().enumerate().filter(|(_, blas)| blas.instances > 0 && blas.triangles > 0)
    }

    fn empty_space(&self) -> Option<String> {
        let empty = |(mesh, blas): (usize, &BlasStatistics)| {
            blas.empty_share.filter(|&share| share > MUCH_EMPTY_SPACE).map(|share| (mesh, share))
        };
        let (mesh, share) = self.placed().filter_map(empty).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(format!(
            "{} of {} BLASes are mostly empty space: of the rays that enter the box of mesh {mesh}, {:.0} % meet no leaf. Split such \
             meshes into compact parts, or turn them so that their boxes fit.",
            self.placed().filter_map(empty).count(),
            self.placed().count(),
            100.0 * share
        ))
    }

    fn small_blases(&self, limit: u64) -> Option<String> {
        let is_small = |(_, blas): &(usize, &BlasStatistics)| blas.triangles < limit;
        let instances: u64 = self.placed().filter(is_small).map(|(_, blas)| blas.instances).sum();
        // A single one has none that it could be joined with.
        (instances > 1).then(|| {
            format!(
                "{} of {} BLASes, with {instances} of {} instances, have fewer than {limit} triangles: join neighbours into larger \
                 BLASes.",
                self.placed().filter(is_small).count(),
                self.placed().count(),
                self.instances
            )
        })
    }
}
