//! All structures and traversals of the tracer over one scene, watched.

use scenes::Triangle;
use std::sync::atomic::{AtomicU64, Ordering};
use tracer::wide::NodeFormat;
use tracer::{
    AccelerationStructure, BuildOptions, Hit, Observer, Op, PreparedTriangle, Query, Ray, Topology,
    Traversal, TriangleTest, WatertightTriangle,
};

/// What must not happen to any ray of the suite, counted.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    pub(crate) rays: AtomicU64,
    /// Hits with a distance or weight that is no number, or a distance outside the ray's interval.
    pub(crate) not_numbers: AtomicU64,
    /// Traversals that took more trips than theory allows them.
    pub(crate) over_bound: AtomicU64,
}

/// A structure with its traversal.
pub(crate) struct Structure {
    pub(crate) name: String,
    structure: AccelerationStructure,
    /// Node visits and climbs that one ray can need at most.
    bound: u64,
}

/// Trips of a traversal's loop.
#[derive(Default)]
struct Trips {
    nodes: u64,
}

impl Observer for Trips {
    #[inline(always)]
    fn step(&mut self, op: Op, _: u32) {
        self.nodes += u64::from(matches!(op, Op::Node | Op::Up));
    }
}

impl Structure {
    /// Builds the structure that a traversal walks.
    ///
    /// # Errors
    /// As [`AccelerationStructure::build`].
    pub(crate) fn build(
        triangles: &[Triangle],
        traversal: Traversal,
        options: &BuildOptions,
    ) -> Result<Self, tracer::Error> {
        let structure = AccelerationStructure::build(triangles, traversal, options)?;
        let bound = most_trips(traversal, &structure.topology(), structure.depth());
        let name = format!("{} {}", traversal.accel().name(), traversal.name());
        Ok(Self { name, structure, bound })
    }

    pub(crate) fn depth(&self) -> u32 {
        self.structure.depth()
    }

    /// Traces one ray and counts what must not happen.
    pub(crate) fn trace(&self, watch: &Watch, ray: &Ray, query: Query) -> Hit {
        let mut trips = Trips::default();
        let hit = self.structure.trace(ray, query, &mut trips);
        let is_number =
            !hit.is_hit() || ((ray.t_min..=ray.t_max).contains(&hit.t) && !hit.u.is_nan() && !hit.v.is_nan());
        let add = |counter: &AtomicU64, amount| {
            if amount > 0 {
                counter.fetch_add(amount, Ordering::Relaxed);
            }
        };
        add(&watch.rays, 1);
        add(&watch.not_numbers, u64::from(!is_number));
        add(&watch.over_bound, u64::from(trips.nodes > self.bound));
        hit
    }
}

/// Node fetches that a ray can need: a traversal with memory comes to each node once, one that climbs leaves it once too, and one that
/// restarts descends once for each leaf.
fn most_trips(traversal: Traversal, topology: &Topology, depth: u32) -> u64 {
    let nodes = topology.nodes.len() as u64;
    match traversal {
        Traversal::BvhStack | Traversal::WideStack { .. } | Traversal::KdStack | Traversal::GridDda => nodes,
        // The triangles are one mesh, placed once.
        Traversal::TwoLevelStack { .. } => nodes,
        Traversal::BvhParentLink | Traversal::KdBacktrack => 2 * nodes,
        // Each node, and its parent again behind each child, leaves among them.
        Traversal::WideShortStack { format, .. } | Traversal::TwoLevelShortStack { format, .. } => {
            nodes * (1 + u64::from(format.width()))
        }
        Traversal::BvhRestartTrail { .. } | Traversal::KdRestart | Traversal::KdPushDown { .. } => {
            // A restart also follows decisions whose other child has been culled since.
            nodes * (u64::from(depth) + 1)
        }
    }
}

/// Every traversal, over nodes that can hold any coordinate: those of adreno-8 cannot hold the largest, and quantised boxes around these may reach
/// infinity, where no instance is placed.
pub(crate) fn traversals() -> [Traversal; Traversal::ALL.len()] {
    Traversal::ALL.map(|traversal| match traversal {
        Traversal::WideShortStack { short_stack, .. } => {
            Traversal::WideShortStack { format: NodeFormat::Compressed8, short_stack }
        }
        Traversal::TwoLevelShortStack { short_stack, .. } => {
            Traversal::TwoLevelShortStack { format: NodeFormat::Full8, short_stack }
        }
        other => other,
    })
}

/// Every traversal over a scene.
///
/// # Panics
/// When a builder refuses the scene: these have finite corners.
pub(crate) fn all(triangles: &[Triangle], options: &BuildOptions) -> Vec<Structure> {
    let build = |traversal| Structure::build(triangles, traversal, options);
    traversals().map(build).into_iter().map(|built| built.expect("the scene is finite")).collect()
}

/// The options of a test, all else as usual.
pub(crate) fn options(test: TriangleTest) -> BuildOptions {
    BuildOptions { triangle_test: test, ..BuildOptions::default() }
}

/// A loop over all triangles: nearest hit, lowest index among equal distances.
pub(crate) fn brute_force(triangles: &[Triangle], test: TriangleTest, ray: &Ray) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    for (primitive, triangle) in (0..).zip(triangles) {
        let found = match test {
            TriangleTest::MoellerTrumbore => PreparedTriangle::from(triangle).intersect(ray, best.t),
            TriangleTest::Watertight => WatertightTriangle::from(triangle).intersect(ray, best.t),
        };
        if let Some((t, u, v)) = found
            && (t < best.t || primitive < best.primitive)
        {
            best = Hit { t, u, v, primitive };
        }
    }
    best
}

/// Whether two hits are the same bit by bit.
pub(crate) fn same(a: &Hit, b: &Hit) -> bool {
    a.primitive == b.primitive && [a.t, a.u, a.v].map(f32::to_bits) == [b.t, b.u, b.v].map(f32::to_bits)
}
