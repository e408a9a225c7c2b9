//! A structure of any kind over triangles that are prepared for one test.

use crate::accel::{Accel, BuildOptions, LeafCounts, Traversal};
use crate::alpha::RayQuery;
use crate::bvh::restart_trail::TrailBits;
use crate::bvh::{self, Bvh, BvhOptions};
use crate::error::Error;
use crate::grid::{self, Grid};
use crate::kd::{self, KdCells, KdStatistics, KdTree};
use crate::observe::Observer;
use crate::ray::{Hit, Ray};
use crate::topology::Topology;
use crate::triangle::RayTriangle;
use crate::two_level::{MaskedInstance, TwoLevel, TwoLevelStatistics};
use crate::wide::{self, NodeFormat, WideBvh};
use scenes::{Instance, Triangle};

/// The structure, and what its traversal needs beside it.
pub(crate) enum Tree<P: RayTriangle> {
    Bvh(Bvh<P>),
    Wide4(WideBvh<P, 4>),
    Wide8(WideBvh<P, 8>),
    LinkedBvh(Bvh<P>, bvh::parent_link::ParentLinks),
    Kd(KdTree<P>),
    KdWithCells(KdTree<P>, KdCells),
    Grid(Grid<P>),
    TwoLevel(TwoLevel<P>),
    TwoLevel4(TwoLevel<P, WideBvh<P, 4>>),
    TwoLevel8(TwoLevel<P, WideBvh<P, 8>>),
}

/// An expression of the structure of two levels, or another one.
macro_rules! with_levels {
    ($tree:expr, $levels:ident => $value:expr, _ => $other:expr) => {
        match $tree {
            Tree::TwoLevel($levels) => $value,
            Tree::TwoLevel4($levels) => $value,
            Tree::TwoLevel8($levels) => $value,
            _ => $other,
        }
    };
}

impl<P: RayTriangle> Tree<P> {
    /// The structure that `traversal` walks; the caller has checked the options.
    ///
    /// # Errors
    /// See [`WideBvh::collapse`], [`KdTree::build_for`] and [`Grid::build_for`].
    pub(crate) fn build(
        triangles: &[Triangle],
        traversal: Traversal,
        options: &BuildOptions,
    ) -> Result<Self, Error> {
        if traversal.accel() == Accel::TwoLevel {
            let format = traversal.node_format();
            return Self::of_instances(&[triangles.to_vec()], &[Instance::identity(0)], format, options);
        }
        let BuildOptions { traversal_cost, intersection_cost, mut kd, triangle_test: _ } = *options;
        kd.traversal_cost = traversal_cost;
        kd.intersection_cost = intersection_cost;
        let max_depth = match traversal {
            Traversal::BvhRestartTrail { bits: Some(bits), .. } => bits.max_depth(),
            _ => BvhOptions::MAX_DEPTH,
        };
        let options = BvhOptions { traversal_cost, intersection_cost, max_depth, ..BvhOptions::MOBILE };
        let sah_costs = [traversal_cost, intersection_cost];
        let bvh = || Bvh::build_for(triangles, &options);
        Ok(match traversal {
            Traversal::BvhStack | Traversal::BvhRestartTrail { .. } => Self::Bvh(bvh()),
            Traversal::WideStack { format } | Traversal::WideShortStack { format, .. } => match format {
                NodeFormat::Full4 => Self::Wide4(WideBvh::build_for(triangles, sah_costs, format)?),
                _ => Self::Wide8(WideBvh::build_for(triangles, sah_costs, format)?),
            },
            Traversal::BvhParentLink => {
                let bvh = bvh();
                let links = bvh::parent_link::ParentLinks::new(&bvh);
                Self::LinkedBvh(bvh, links)
            }
            Traversal::KdStack | Traversal::KdRestart | Traversal::KdPushDown { .. } => {
                Self::Kd(KdTree::build_for(triangles, &kd)?)
            }
            Traversal::KdBacktrack => {
                // A point on the ray cannot leave a cell of zero thickness: flat cells are not for this traversal.
                kd.flat_cells = kd::FlatCells::Forbidden;
                let tree = KdTree::build_for(triangles, &kd)?;
                let cells = KdCells::new(&tree);
                Self::KdWithCells(tree, cells)
            }
            Traversal::GridDda => Self::Grid(Grid::build_for(triangles)?),
            Traversal::TwoLevelStack { .. } | Traversal::TwoLevelShortStack { .. } => {
                unreachable!("built above")
            }
        })
    }

    /// Two levels over instances, all of which every ray sees.
    ///
    /// # Errors
    /// As [`TwoLevel::build_with`].
    pub(crate) fn of_instances(
        meshes: &[Vec<Triangle>],
        instances: &[Instance],
        format: Option<NodeFormat>,
        options: &BuildOptions,
    ) -> Result<Self, Error> {
        let instances: Vec<MaskedInstance> = instances.iter().map(|&instance| instance.into()).collect();
        let costs = [options.traversal_cost, options.intersection_cost];
        Ok(match format {
            None => Self::TwoLevel(TwoLevel::build_with(meshes, &instances, costs, ())?),
            Some(format @ NodeFormat::Full4) => {
                Self::TwoLevel4(TwoLevel::build_with(meshes, &instances, costs, format)?)
            }
            Some(format) => Self::TwoLevel8(TwoLevel::build_with(meshes, &instances, costs, format)?),
        })
    }

    /// Traces one ray.
    #[inline]
    pub(crate) fn trace<Q: RayQuery, O: Observer>(
        &self,
        traversal: Traversal,
        ray: &Ray,
        query: Q,
        observer: &mut O,
    ) -> Hit {
        match (self, traversal) {
            (Self::Bvh(bvh), Traversal::BvhRestartTrail { bits, short_stack }) => {
                let bits = bits.unwrap_or(TrailBits::fitting(bvh.depth));
                bvh::restart_trail::trace(bvh, bits, short_stack, ray, query, observer)
            }
            (Self::Bvh(bvh), _) => bvh::stack::trace(bvh, ray, query, observer),
            (Self::Wide4(bvh), Traversal::WideShortStack { short_stack, .. }) => {
                wide::short_stack::trace(bvh, short_stack, ray, query, observer)
            }
            (Self::Wide8(bvh), Traversal::WideShortStack { short_stack, .. }) => {
                wide::short_stack::trace(bvh, short_stack, ray, query, observer)
            }
            (Self::Wide4(bvh), _) => wide::stack::trace(bvh, ray, query, observer),
            (Self::Wide8(bvh), _) => wide::stack::trace(bvh, ray, query, observer),
            (Self::LinkedBvh(bvh, links), _) => bvh::parent_link::trace(bvh, links, ray, query, observer),
            (Self::Kd(tree), Traversal::KdRestart) => kd::restart::trace(tree, ray, query, observer),
            (Self::Kd(tree), Traversal::KdPushDown { short_stack }) => {
                kd::push_down::trace(tree, short_stack, ray, query, observer)
            }
            (Self::Kd(tree), _) => kd::stack::trace(tree, ray, query, observer),
            (Self::KdWithCells(tree, cells), _) => kd::backtrack::trace(tree, cells, ray, query, observer),
            (Self::Grid(grid), _) => grid::dda::trace(grid, ray, query, observer),
            (Self::TwoLevel4(levels), Traversal::TwoLevelShortStack { short_stack, .. }) => {
                levels.trace_short_stack(short_stack, ray, query, u8::MAX, observer)
            }
            (Self::TwoLevel8(levels), Traversal::TwoLevelShortStack { short_stack, .. }) => {
                levels.trace_short_stack(short_stack, ray, query, u8::MAX, observer)
            }
            (Self::TwoLevel(levels), _) => levels.trace(ray, query, u8::MAX, observer),
            (Self::TwoLevel4(levels), _) => levels.trace(ray, query, u8::MAX, observer),
            (Self::TwoLevel8(levels), _) => levels.trace(ray, query, u8::MAX, observer),
        }
    }

    /// Links and references without geometry, as a trace needs them.
    pub(crate) fn topology(&self) -> Topology {
        match self {
            Self::Bvh(bvh) | Self::LinkedBvh(bvh, _) => Topology::of_bvh(bvh),
            Self::Wide4(bvh) => Topology::of_wide(bvh),
            Self::Wide8(bvh) => Topology::of_wide(bvh),
            Self::Kd(tree) | Self::KdWithCells(tree, _) => Topology::of_kd(tree),
            Self::Grid(grid) => Topology::of_grid(grid),
            Self::TwoLevel(levels) => levels.topology(),
            Self::TwoLevel4(levels) => levels.topology(),
            Self::TwoLevel8(levels) => levels.topology(),
        }
    }

    /// Longest path from the root, in edges; 0 for a grid.
    pub(crate) fn depth(&self) -> u32 {
        match self {
            Self::Bvh(bvh) | Self::LinkedBvh(bvh, _) => bvh.depth,
            Self::Wide4(bvh) => bvh.depth(),
            Self::Wide8(bvh) => bvh.depth(),
            Self::Kd(tree) | Self::KdWithCells(tree, _) => tree.depth,
            Self::Grid(_) => 0,
            levels => with_levels!(levels, levels => levels.depth(), _ => 0),
        }
    }

    /// Entries that a full stack may take: in a binary tree the other child of each node on the path.
    pub(crate) fn stack_entries(&self) -> u32 {
        match self {
            Self::Wide4(bvh) => bvh.stack_entries(),
            Self::Wide8(bvh) => bvh.stack_entries(),
            tree => with_levels!(tree, levels => levels.stack_entries(), _ => self.depth() + 1),
        }
    }

    /// How many leaves, or cells of a grid, there are, and of which kinds.
    pub(crate) fn leaf_counts(&self) -> LeafCounts {
        match self {
            Self::Bvh(bvh) | Self::LinkedBvh(bvh, _) => {
                LeafCounts { leaves: bvh.statistics().leaves, empty: 0, flat: 0 }
            }
            Self::Wide4(bvh) => LeafCounts { leaves: bvh.statistics().leaves, empty: 0, flat: 0 },
            Self::Wide8(bvh) => LeafCounts { leaves: bvh.statistics().leaves, empty: 0, flat: 0 },
            Self::Kd(tree) | Self::KdWithCells(tree, _) => {
                let KdStatistics { leaves, empty_leaves, flat_leaves, .. } = tree.statistics();
                LeafCounts { leaves, empty: empty_leaves, flat: flat_leaves }
            }
            Self::Grid(grid) => {
                let statistics = grid.statistics();
                LeafCounts { leaves: statistics.cells, empty: statistics.empty_cells, flat: 0 }
            }
            levels => LeafCounts {
                leaves: with_levels!(levels, levels => levels.leaf_count(), _ => 0),
                empty: 0,
                flat: 0,
            },
        }
    }

    /// Facts about the two levels; `None` for any other structure.
    pub(crate) fn two_level_statistics(&self) -> Option<TwoLevelStatistics> {
        with_levels!(self, levels => Some(levels.statistics()), _ => None)
    }

    /// Half the area of each node's box or cell; `None` where nodes were not split in two, in a grid and a wide BVH, and for two levels.
    pub(crate) fn half_areas(&self) -> Option<Vec<f64>> {
        match self {
            Self::Bvh(bvh) | Self::LinkedBvh(bvh, _) => {
                Some(bvh.nodes().map(|node| node.bounds.half_area()).collect())
            }
            Self::Kd(tree) | Self::KdWithCells(tree, _) => Some(tree.half_areas()),
            _ => None,
        }
    }

    /// Expected cost of a random ray that meets the scene's box, by the surface area heuristic; `None` for a box without area, and
    /// for two levels.
    pub(crate) fn sah_cost(&self, traversal_cost: f64, intersection_cost: f64) -> Option<f64> {
        match self {
            Self::Bvh(bvh) | Self::LinkedBvh(bvh, _) => bvh.sah_cost(traversal_cost, intersection_cost),
            Self::Wide4(bvh) => bvh.sah_cost(traversal_cost, intersection_cost),
            Self::Wide8(bvh) => bvh.sah_cost(traversal_cost, intersection_cost),
            Self::Kd(tree) | Self::KdWithCells(tree, _) => tree.sah_cost(traversal_cost, intersection_cost),
            Self::Grid(grid) => grid.sah_cost(traversal_cost, intersection_cost),
            Self::TwoLevel(_) | Self::TwoLevel4(_) | Self::TwoLevel8(_) => None,
        }
    }
}
