//! From a binary tree to a wide one: Wald, Benthin and Boulos 2008, "Getting rid of packets", section 3: as long as a node has room, its largest inner
//! child by surface gives way to its two children.

use super::format::NodeFormat;
use super::quantise::Grid;
use super::tree::{WideBvh, WideNode, WideNodes};
use crate::aabb::Aabb;
use crate::bvh::{Bvh, BvhOptions, NodeRef, PairTree};
use crate::error::Error;
use crate::triangle::RayTriangle;
use scenes::Triangle;

/// A child of a wide node: its box and its links in the binary tree.
type Member = (Aabb, NodeRef);

impl<P: RayTriangle, const W: usize> WideBvh<P, W> {
    /// [`Self::collapse`] of a binary tree that is built for it with the SAH costs Ct and Ci, its triangles in pairs where the format has these.
    ///
    /// # Errors
    /// As [`Self::collapse`].
    ///
    /// # Panics
    /// As [`Bvh::build_for`].
    pub fn build_for(
        triangles: &[Triangle],
        [traversal_cost, intersection_cost]: [f64; 2],
        format: NodeFormat,
    ) -> Result<Self, Error> {
        let max_leaf = format.leaf_triangles().unwrap_or(u32::MAX);
        let options = BvhOptions { traversal_cost, intersection_cost, max_leaf, ..BvhOptions::MOBILE };
        let mut tree = Self::collapse(Bvh::build_for(triangles, &options), format)?;
        if format.has_pairs() {
            tree.join_pairs(triangles);
        }
        Ok(tree)
    }

    /// The tree of nodes in `format`, whose width is `W`, over the leaves of `binary`, which must not be larger than the format allows.
    ///
    /// # Errors
    /// A coordinate that the format cannot hold.
    pub fn collapse(binary: Bvh<P>, format: NodeFormat) -> Result<Self, Error> {
        let tree = WideNodes::collapse(binary.pair_tree(), format)?;
        Ok(Self {
            tree,
            slack: binary.slack,
            references: binary.references,
            seconds: Vec::new(),
            groups: binary.groups,
        })
    }
}

impl<const W: usize> WideNodes<W> {
    /// The nodes in `format`, whose width is `W`, over the leaves of `binary`.
    ///
    /// # Errors
    /// A coordinate that the format cannot hold.
    pub(crate) fn collapse(binary: PairTree<'_>, format: NodeFormat) -> Result<Self, Error> {
        assert_eq!(format.width() as usize, W);
        let mut nodes: Vec<WideNode<W>> = vec![WideNode::EMPTY];
        let mut parents = vec![0];
        let mut depth = 0;
        // Binary node, its place among the wide ones, its depth there.
        let mut open = vec![(0_u32, 0_u32, 0_u32)];
        while let Some((root, place, level)) = open.pop() {
            depth = depth.max(level);
            let members = members(binary, root, W);
            let first = nodes.len() as u32;
            let mut links = [NodeRef::NOTHING; W];
            for (link, &(_, member)) in links.iter_mut().zip(&members.children) {
                *link = member;
                if member.is_inner() {
                    *link = NodeRef::inner(0, nodes.len() as u32);
                    nodes.push(WideNode::EMPTY);
                    parents.push(place);
                }
            }
            let inner = members.inner.iter().zip(first..nodes.len() as u32);
            open.extend(inner.map(|(&node, place)| (node, place, level + 1)).rev());
            let boxes: Vec<Aabb> = members.children.iter().map(|&(bounds, _)| bounds).collect();
            nodes[place as usize] = WideNode::new(&stored(&boxes, format)?, &links);
        }
        Ok(Self { nodes, parents, format, depth })
    }
}

/// What becomes of a binary node in a wide one.
struct Members {
    children: Vec<Member>,
    /// Of the inner ones, their indices in the binary tree.
    inner: Vec<u32>,
}

fn members(binary: PairTree<'_>, root: u32, width: usize) -> Members {
    // The index of each in the binary tree, in order from left to right.
    let mut chosen = vec![root];
    let areas = |node: u32| binary.node(node).0.half_area();
    let largest = |chosen: &[u32]| {
        let inner = (0..chosen.len()).filter(|&at| binary.node(chosen[at]).1.is_inner());
        // Among equals the first.
        inner.rev().max_by(|&a, &b| areas(chosen[a]).total_cmp(&areas(chosen[b])))
    };
    while chosen.len() < width
        && let Some(at) = largest(&chosen)
    {
        let left = binary.node(chosen[at]).1.link;
        chosen.splice(at..=at, [left, left + 1]);
    }
    let holds_triangles = |&node: &u32| {
        let (_, link) = binary.node(node);
        // Only the root of an empty tree is a leaf without triangles.
        link.is_inner() || link.count() > 0
    };
    chosen.retain(holds_triangles);
    let children = chosen.iter().map(|&node| binary.node(node)).collect();
    chosen.retain(|&node| binary.node(node).1.is_inner());
    Members { children, inner: chosen }
}

/// The boxes as the format holds them.
fn stored(boxes: &[Aabb], format: NodeFormat) -> Result<Vec<Aabb>, Error> {
    let all = boxes.iter().copied().fold(Aabb::EMPTY, Aabb::union);
    let Some(origin) = format.origin().filter(|_| !all.is_empty()) else {
        return Ok(boxes.to_vec());
    };
    let grid = Grid::around(&all, origin).map_err(|coordinate| {
        Error::Options(format!(
            "node format {} cannot hold a box at {coordinate:e}: its origins have 16 bits; use another --node-format, or scale the scene",
            format.name()
        ))
    })?;
    Ok(boxes.iter().map(|bounds| grid.snap(bounds)).collect())
}
