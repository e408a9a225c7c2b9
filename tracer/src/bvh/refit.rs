//! Refitting: new boxes for the same tree after its triangles have moved.

use super::tree::{Bvh, NodePair, NodeRef};
use crate::aabb::{Aabb, PlaneSlack};
use crate::error::Error;
use crate::triangle::{GROUP, RayTriangle, TriangleGroup};
use scenes::Triangle;

/// What a refit has done to a tree: its expected costs by the surface area heuristic, see [`Bvh::sah_cost`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refit {
    /// With the old triangles.
    pub before: Option<f64>,
    /// With the new ones. The further above `before`, the more a new tree would gain.
    pub after: Option<f64>,
}

impl<P: RayTriangle> Bvh<P> {
    /// Gives every node the box of the moved triangles, which are in file order, and keeps the links and leaves. Split axes stay
    /// what they were for the old triangles. In linear time.
    ///
    /// # Errors
    /// Another number of triangles, or a corner that is not finite; the tree is then as before.
    pub fn refit(&mut self, triangles: &[Triangle], sah_costs: [f64; 2]) -> Result<Refit, Error> {
        if triangles.len() != self.references.len() {
            return Err(Error::Options(format!(
                "a refit with {} triangles of a tree over {}: expected as many; build a new tree",
                triangles.len(),
                self.references.len()
            )));
        }
        if let Some(index) = triangles.iter().position(|t| !t.v.iter().all(|corner| corner.is_finite())) {
            return Err(Error::Options(format!(
                "triangle {index} has a corner that is not finite; remove it and build a new tree"
            )));
        }
        let [traversal_cost, intersection_cost] = sah_costs;
        let before = self.sah_cost(traversal_cost, intersection_cost);
        // Children lie behind their parent.
        for index in (0..self.pairs.len()).rev() {
            let links = self.pairs[index].links;
            let [left, right] = links.map(|node| self.refit_node(node, triangles));
            self.pairs[index] = NodePair::new([&left, &right], links);
        }
        self.root_bounds = self.refit_node(self.root, triangles);
        let boxes: Vec<Aabb> = triangles.iter().map(Aabb::of_triangle).collect();
        self.slack = PlaneSlack::new(&boxes);
        debug_assert!(triangles.len() > 50_000 || self.validate(triangles) == Ok(()));
        Ok(Refit { before, after: self.sah_cost(traversal_cost, intersection_cost) })
    }

    /// The new box of a node whose children have theirs; a leaf's triangles are prepared again.
    fn refit_node(&mut self, node: NodeRef, triangles: &[Triangle]) -> Aabb {
        if node.is_inner() {
            let pair = &self.pairs[(node.link / 2) as usize];
            return pair.side(0).0.union(pair.side(1).0);
        }
        let mut bounds = Aabb::EMPTY;
        let mut left = node.count() as usize;
        let mut group = node.link as usize;
        while left > 0 {
            let first = self.groups[group].first();
            let count = left.min(GROUP);
            let moved = self.references[first as usize..][..count].iter().map(|&id| &triangles[id as usize]);
            bounds = moved.clone().map(Aabb::of_triangle).fold(bounds, Aabb::union);
            self.groups[group] = P::Group::new(first, &moved.map(P::from).collect::<Vec<P>>());
            left -= count;
            group += 1;
        }
        bounds
    }
}
