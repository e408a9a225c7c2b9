//! The closed set of structures and traversals: the one place where names become types.

use crate::alpha::{AlphaMode, AlphaQuery, AlphaTest, AlphaTests};
use crate::audit;
use crate::bvh::restart_trail::{MAX_SHORT_STACK, TrailBits};
use crate::bvh::{self, BvhOptions};
use crate::error::Error;
use crate::kd::KdOptions;
use crate::observe::{DECIDED_BY_MICROMAP, LoopStructure, NodeFetch, Observer};
use crate::ray::{Hit, Query, Ray};
use crate::topology::Topology;
use crate::tree::Tree;
use crate::triangle::{PreparedTriangle, TriangleTest, WatertightTriangle};
use crate::two_level::TwoLevelStatistics;
use crate::wide::NodeFormat;
use crate::wide::short_stack::DRIVER_ENTRIES;
use scenes::{Instance, Triangle};
use serde::{Deserialize, Serialize};

/// Kind of acceleration structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Accel {
    /// Bounding volume hierarchy.
    Bvh,
    /// Bounding volume hierarchy of four or eight children per node.
    WideBvh,
    /// kd-tree.
    Kd,
    /// Uniform grid.
    Grid,
    /// A BVH over the instances of a scene, each of which leads into the BVH of its mesh.
    TwoLevel,
}

impl Accel {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Accel::Bvh => "bvh",
            Accel::WideBvh => "wide-bvh",
            Accel::Kd => "kd",
            Accel::Grid => "grid",
            Accel::TwoLevel => "two-level",
        }
    }
}

/// A traversal, and with it the structure that it walks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Traversal {
    /// BVH, full stack, nearer child first.
    BvhStack,
    /// BVH, parent links, no stack.
    BvhParentLink,
    /// BVH, restart trail with a short stack of 0 to [`MAX_SHORT_STACK`] entries.
    BvhRestartTrail {
        /// Width of the trail; `None` for the narrowest that the tree's depth allows.
        bits: Option<TrailBits>,
        /// Entries of the short stack.
        short_stack: u32,
    },
    /// Wide BVH, full stack, nearest child first.
    WideStack {
        /// What its nodes hold.
        format: NodeFormat,
    },
    /// Wide BVH, short stack of nodes with their children still to visit; climbs by parent links where entries are lost.
    WideShortStack {
        /// What its nodes hold.
        format: NodeFormat,
        /// Entries of the short stack.
        short_stack: u32,
    },
    /// kd-tree, full stack.
    KdStack,
    /// kd-tree, restart at the root after each leaf.
    KdRestart,
    /// kd-tree, restart at the lowest node that holds the rest of the ray, with a short stack.
    KdPushDown {
        /// Entries of the short stack; 0 as in Sousa et al. 2019.
        short_stack: u32,
    },
    /// kd-tree, climb by parent links.
    KdBacktrack,
    /// Uniform grid, 3D-DDA from cell to cell.
    GridDda,
    /// Two levels, a full stack through both, nearer child first.
    TwoLevelStack {
        /// What the nodes of both levels hold; `None` for binary ones.
        format: Option<NodeFormat>,
    },
    /// Two levels of wide nodes, a short stack through both, as [`Self::WideShortStack`].
    TwoLevelShortStack {
        /// What the nodes of both levels hold.
        format: NodeFormat,
        /// Entries of the short stack.
        short_stack: u32,
    },
}

/// Where a traversal keeps the nodes that it has still to visit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StackUse {
    /// Nowhere.
    None,
    /// A full stack, too large for registers: in memory private to the lane.
    Memory,
    /// A short stack in registers.
    Registers,
}

impl Traversal {
    /// One of each, in its plainest form.
    pub const ALL: [Traversal; 12] = [
        Traversal::BvhStack,
        Traversal::BvhParentLink,
        Traversal::BvhRestartTrail { bits: None, short_stack: 0 },
        Traversal::WideStack { format: NodeFormat::Compressed8 },
        Traversal::WideShortStack { format: NodeFormat::Adreno8, short_stack: DRIVER_ENTRIES },
        Traversal::KdStack,
        Traversal::KdRestart,
        Traversal::KdPushDown { short_stack: 0 },
        Traversal::KdBacktrack,
        Traversal::GridDda,
        Traversal::TwoLevelStack { format: None },
        Traversal::TwoLevelShortStack { format: NodeFormat::Adreno8, short_stack: DRIVER_ENTRIES },
    ];

    /// The structure that it walks.
    pub fn accel(self) -> Accel {
        match self {
            Traversal::BvhStack | Traversal::BvhParentLink | Traversal::BvhRestartTrail { .. } => Accel::Bvh,
            Traversal::WideStack { .. } | Traversal::WideShortStack { .. } => Accel::WideBvh,
            Traversal::KdStack
            | Traversal::KdRestart
            | Traversal::KdPushDown { .. }
            | Traversal::KdBacktrack => Accel::Kd,
            Traversal::GridDda => Accel::Grid,
            Traversal::TwoLevelStack { .. } | Traversal::TwoLevelShortStack { .. } => Accel::TwoLevel,
        }
    }

    /// Its name on the command line, without the structure's.
    pub fn name(self) -> &'static str {
        match self {
            Traversal::BvhStack
            | Traversal::WideStack { .. }
            | Traversal::KdStack
            | Traversal::TwoLevelStack { .. } => "stack",
            Traversal::WideShortStack { .. } | Traversal::TwoLevelShortStack { .. } => "short-stack",
            Traversal::BvhParentLink => "parent-link",
            Traversal::BvhRestartTrail { .. } => "restart-trail",
            Traversal::KdRestart => "restart",
            Traversal::KdPushDown { .. } => "push-down",
            Traversal::KdBacktrack => "backtrack",
            Traversal::GridDda => "dda",
        }
    }

    /// The traversal of that name over that structure, in its plainest form.
    ///
    /// # Errors
    /// Names the traversals that the structure has.
    pub fn named(accel: Accel, name: &str) -> Result<Self, Error> {
        let of_accel = || Self::ALL.into_iter().filter(|traversal| traversal.accel() == accel);
        of_accel().find(|traversal| traversal.name() == name).ok_or_else(|| {
            let names: Vec<_> = of_accel().map(Self::name).collect();
            let accel = accel.name();
            Error::Options(format!(
                "--accel {accel} has no traversal '{name}'; use one of: {}",
                names.join(", ")
            ))
        })
    }

    /// How many records a node step reads.
    pub fn node_fetch(self) -> NodeFetch {
        match self {
            Traversal::BvhStack
            | Traversal::BvhRestartTrail { .. }
            | Traversal::TwoLevelStack { format: None } => NodeFetch::Pair,
            _ => NodeFetch::Single,
        }
    }

    /// How its shader loops.
    pub fn loop_structure(self) -> LoopStructure {
        match self {
            Traversal::BvhParentLink => LoopStructure::SingleLoop,
            Traversal::WideShortStack { .. } | Traversal::TwoLevelShortStack { .. } => LoopStructure::IfIf,
            _ => LoopStructure::WhileWhile,
        }
    }

    /// What the nodes of its wide BVH, or of two wide levels, hold; `None` for any other structure.
    pub fn node_format(self) -> Option<NodeFormat> {
        match self {
            Traversal::WideStack { format }
            | Traversal::WideShortStack { format, .. }
            | Traversal::TwoLevelShortStack { format, .. } => Some(format),
            Traversal::TwoLevelStack { format } => format,
            _ => None,
        }
    }

    /// Entries of its short stack; 0 without one.
    pub fn short_stack(self) -> u32 {
        match self {
            Traversal::BvhRestartTrail { short_stack, .. }
            | Traversal::WideShortStack { short_stack, .. }
            | Traversal::TwoLevelShortStack { short_stack, .. }
            | Traversal::KdPushDown { short_stack } => short_stack,
            _ => 0,
        }
    }

    /// Where its stack is.
    pub fn stack_use(self) -> StackUse {
        match self {
            Traversal::BvhStack
            | Traversal::WideStack { .. }
            | Traversal::KdStack
            | Traversal::TwoLevelStack { .. } => StackUse::Memory,
            _ if self.short_stack() > 0 => StackUse::Registers,
            _ => StackUse::None,
        }
    }
}

/// How to build a structure. A grid takes nothing from it but the triangle test: its cells follow from the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// Cost of visiting an inner node, Ct; finite, at least 0.
    pub traversal_cost: f64,
    /// Cost of testing a triangle, Ci; finite, greater than 0.
    pub intersection_cost: f64,
    /// Options that only kd-trees have; its costs are replaced by the ones above.
    pub kd: KdOptions,
    /// The test that the triangles are prepared for. The tree does not depend on it.
    pub triangle_test: TriangleTest,
}

impl Default for BuildOptions {
    /// Sousa et al. 2019: Ct = 3, Ci = 1.5, no triangle clipping, no empty-space bonus, the test of Moller & Trumbore.
    fn default() -> Self {
        let BvhOptions { traversal_cost, intersection_cost, .. } = BvhOptions::MOBILE;
        Self {
            traversal_cost,
            intersection_cost,
            kd: KdOptions::MOBILE,
            triangle_test: TriangleTest::MoellerTrumbore,
        }
    }
}

/// Refuses SAH costs Ct and Ci that no builder takes.
pub(crate) fn check_costs([ct, ci]: [f64; 2]) -> Result<(), Error> {
    if ct.is_finite() && ct >= 0.0 && ci.is_finite() && ci > 0.0 {
        return Ok(());
    }
    Err(Error::Options(format!(
        "SAH costs Ct = {ct}, Ci = {ci}: expected finite numbers, Ct at least 0 and Ci above 0; the default is --ct 3 --ci 1.5"
    )))
}

/// Leaves of a structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafCounts {
    /// All of them.
    pub leaves: u64,
    /// Those without references.
    pub empty: u64,
    /// Those without thickness on an axis on which the scene has some: a kd-tree may have them.
    pub flat: u64,
}

/// The structure, by the test of its triangles.
enum Trees {
    MoellerTrumbore(Tree<PreparedTriangle>),
    Watertight(Tree<WatertightTriangle>),
}

/// Refuses triangles and options that no builder takes.
fn check(triangles: &[Triangle], traversal: Traversal, options: &BuildOptions) -> Result<(), Error> {
    check_costs([options.traversal_cost, options.intersection_cost])?;
    if triangles.len() > bvh::MAX_TRIANGLES {
        return Err(Error::Options(format!(
            "{} triangles: a structure holds at most {}; split the scene",
            triangles.len(),
            bvh::MAX_TRIANGLES
        )));
    }
    if let Some(index) = triangles.iter().position(|t| !t.v.iter().all(|corner| corner.is_finite())) {
        return Err(Error::Options(format!(
            "triangle {index} has a corner that is not finite; remove it before building a structure"
        )));
    }
    check_short_stack(traversal)
}

fn check_short_stack(traversal: Traversal) -> Result<(), Error> {
    let short_stack = traversal.short_stack();
    if short_stack > MAX_SHORT_STACK {
        return Err(Error::Options(format!(
            "a short stack of {short_stack} entries: at most {MAX_SHORT_STACK} fit; use --traversal stack for a full one"
        )));
    }
    Ok(())
}

/// A structure together with the traversal that it was built for.
pub struct AccelerationStructure {
    trees: Trees,
    traversal: Traversal,
    alpha: Option<AlphaTest>,
}

/// An expression of the tree, whatever its triangles are prepared for.
macro_rules! with_tree {
    ($structure:expr, $tree:ident => $value:expr) => {
        match &$structure.trees {
            Trees::MoellerTrumbore($tree) => $value,
            Trees::Watertight($tree) => $value,
        }
    };
}

impl AccelerationStructure {
    /// Builds the structure that `traversal` walks over `triangles`. Two levels are then one mesh that is placed once.
    ///
    /// # Errors
    /// Costs out of range, a short stack beyond its limit, more than 2^27 triangles, a corner that is not finite.
    pub fn build(
        triangles: &[Triangle],
        traversal: Traversal,
        options: &BuildOptions,
    ) -> Result<Self, Error> {
        check(triangles, traversal, options)?;
        Ok(match options.triangle_test {
            TriangleTest::MoellerTrumbore => Self {
                trees: Trees::MoellerTrumbore(Tree::build(triangles, traversal, options)?),
                traversal,
                alpha: None,
            },
            TriangleTest::Watertight => Self {
                trees: Trees::Watertight(Tree::build(triangles, traversal, options)?),
                traversal,
                alpha: None,
            },
        })
    }

    /// Builds the two-level structure that `traversal` walks over the instances of meshes. Hits name
    /// triangles instance after instance, each in file order, as [`scenes::Scene::triangles`] lists them.
    ///
    /// # Errors
    /// As [`TwoLevel::build_with`](crate::two_level::TwoLevel::build_with); a short stack beyond its limit; a traversal of another structure.
    pub fn build_two_level(
        meshes: &[Vec<Triangle>],
        instances: &[Instance],
        traversal: Traversal,
        options: &BuildOptions,
    ) -> Result<Self, Error> {
        if traversal.accel() != Accel::TwoLevel {
            let (accel, name) = (traversal.accel().name(), traversal.name());
            return Err(Error::Options(format!(
                "{accel} {name} walks no two levels; use one of --accel two-level"
            )));
        }
        check_short_stack(traversal)?;
        let format = traversal.node_format();
        Ok(match options.triangle_test {
            TriangleTest::MoellerTrumbore => {
                let tree = Tree::of_instances(meshes, instances, format, options)?;
                Self { trees: Trees::MoellerTrumbore(tree), traversal, alpha: None }
            }
            TriangleTest::Watertight => {
                let tree = Tree::of_instances(meshes, instances, format, options)?;
                Self { trees: Trees::Watertight(tree), traversal, alpha: None }
            }
        })
    }

    /// Facts about the two levels; `None` for any other structure.
    pub fn two_level_statistics(&self) -> Option<TwoLevelStatistics> {
        with_tree!(self, tree => tree.two_level_statistics())
    }

    /// The traversal.
    pub fn traversal(&self) -> Traversal {
        self.traversal
    }

    /// Width of the restart trail, if the traversal has one.
    pub fn trail_bits(&self) -> Option<TrailBits> {
        match self.traversal {
            Traversal::BvhRestartTrail { bits, .. } => Some(bits.unwrap_or(TrailBits::fitting(self.depth()))),
            _ => None,
        }
    }

    /// The same structure with some of its triangles alpha-tested, in the numbers that hits have.
    ///
    /// # Errors
    /// When the tests name triangles that it does not have, or micromaps that are too fine.
    pub fn with_alpha(mut self, alpha: AlphaTests) -> Result<Self, Error> {
        let Topology { triangles, references, .. } = self.topology();
        if alpha.mode == AlphaMode::Micromap && references.len() > DECIDED_BY_MICROMAP as usize {
            return Err(Error::Options(format!(
                "{} references to triangles: with opacity micromaps at most {DECIDED_BY_MICROMAP} can be told apart; use --alpha any-hit",
                references.len()
            )));
        }
        self.alpha = Some(AlphaTest::new(alpha, triangles).map_err(Error::Options)?);
        Ok(self)
    }

    /// Its alpha tests, if it has any.
    pub fn alpha(&self) -> Option<&AlphaTests> {
        self.alpha.as_ref().map(AlphaTest::tests)
    }

    /// Traces one ray.
    #[inline]
    pub fn trace<O: Observer>(&self, ray: &Ray, query: Query, observer: &mut O) -> Hit {
        match self.alpha.as_ref().filter(|alpha| alpha.asks()) {
            None => with_tree!(self, tree => tree.trace(self.traversal, ray, query, observer)),
            Some(alpha) => {
                let query = AlphaQuery { query, alpha };
                with_tree!(self, tree => tree.trace(self.traversal, ray, query, observer))
            }
        }
    }

    /// Links and references without geometry, as a trace needs them.
    pub fn topology(&self) -> Topology {
        with_tree!(self, tree => tree.topology())
    }

    /// Entries that a full stack of the traversal may take; 0 for one without.
    pub fn stack_entries(&self) -> u32 {
        match self.traversal.stack_use() {
            StackUse::Memory => with_tree!(self, tree => tree.stack_entries()),
            StackUse::None | StackUse::Registers => 0,
        }
    }

    /// Longest path from the root, in edges; 0 for a grid.
    pub fn depth(&self) -> u32 {
        with_tree!(self, tree => tree.depth())
    }

    /// How many leaves, or cells of a grid, there are, and of which kinds.
    pub fn leaf_counts(&self) -> LeafCounts {
        with_tree!(self, tree => tree.leaf_counts())
    }

    /// Inner nodes whose split costs more than a leaf would, see [`audit::splits_costlier_than_leaf`].
    pub fn splits_costlier_than_leaf(&self, traversal_cost: f64, intersection_cost: f64) -> u64 {
        let Some(areas) = with_tree!(self, tree => tree.half_areas()) else { return 0 };
        audit::splits_costlier_than_leaf(&self.topology(), &areas, [traversal_cost, intersection_cost])
    }

    /// Expected cost of a random ray that meets the scene's box, by the surface area heuristic; `None` for a box without area, and for
    /// two levels, as the heuristic has no cost of entering an instance.
    pub fn sah_cost(&self, traversal_cost: f64, intersection_cost: f64) -> Option<f64> {
        with_tree!(self, tree => tree.sah_cost(traversal_cost, intersection_cost))
    }
}
