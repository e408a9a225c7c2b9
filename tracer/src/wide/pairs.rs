//! Pairs of triangles in leaves: two that share an edge have four corners, which take one record.
//!
//! Drivers and CPU tracers have such records: `TriangleNode` of AMD's GPURT holds corners and numbers of up to two triangles in 64 bytes, Embree's
//! `QuadMv` four corners each. A record is one fetch; its triangles are tested each by itself, in the order of the leaf.

use super::tree::WideBvh;
use crate::triangle::{GROUP, RayTriangle, TriangleGroup};
use scenes::Triangle;

impl<P: RayTriangle, const W: usize> WideBvh<P, W> {
    /// Joins triangles of a leaf to pairs, greedily: each, in the order of the leaf, with the first behind it that shares an edge and is free. The second
    /// of a pair then follows the first.
    pub(super) fn join_pairs(&mut self, triangles: &[Triangle]) {
        let nodes = self.tree.nodes.iter();
        let leaves = nodes.flat_map(|node| node.iter()).map(|(_, link)| link).filter(|link| !link.is_inner());
        let leaves: Vec<_> = leaves.map(|link| (link.link as usize, link.count() as usize)).collect();
        for (group, count) in leaves {
            let first = self.groups[group].first();
            let references = &mut self.references[first as usize..][..count];
            self.seconds.extend(join(references, triangles).map(|second| first + second));
            for (index, chunk) in references.chunks(GROUP).enumerate() {
                let prepared: Vec<P> = chunk.iter().map(|&id| P::from(&triangles[id as usize])).collect();
                self.groups[group + index] = P::Group::new(first + (index * GROUP) as u32, &prepared);
            }
        }
        self.seconds.sort_unstable();
    }
}

/// Orders the triangles of a leaf by pairs; answers the places of the second ones.
fn join<'a>(leaf: &'a mut [u32], triangles: &'a [Triangle]) -> impl Iterator<Item = u32> + 'a {
    let mut at = 0;
    std::iter::from_fn(move || {
        while at < leaf.len() {
            let (first, rest) = (leaf[at], at + 1);
            let triangle = |id: u32| &triangles[id as usize];
            let partner = leaf[rest..].iter().position(|&id| share_an_edge(triangle(first), triangle(id)));
            at += 1;
            if let Some(partner) = partner {
                leaf[rest..=rest + partner].rotate_right(1);
                at += 1;
                return Some(rest as u32);
            }
        }
        None
    })
}

/// Whether the corners of both together lie in four places at most.
fn share_an_edge(a: &Triangle, b: &Triangle) -> bool {
    b.v.iter().filter(|corner| !a.v.contains(corner)).count() <= 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn fan(corners: [[f32; 2]; 3]) -> Triangle {
        Triangle { v: corners.map(|[x, y]| Vec3::new(x, y, 0.0)) }
    }

    #[test]
    fn four_corners_make_a_pair_and_five_do_not() {
        let base = fan([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        let beside = fan([[1.0, 1.0], [0.0, 1.0], [1.0, 0.0]]);
        let at_a_corner = fan([[0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]]);
        let away = fan([[5.0, 0.0], [6.0, 0.0], [5.0, 1.0]]);
        assert!(
            share_an_edge(&base, &beside) && share_an_edge(&beside, &base) && share_an_edge(&base, &base)
        );
        assert!(!share_an_edge(&base, &at_a_corner) && !share_an_edge(&base, &away));
    }

    #[test]
    fn each_takes_the_first_free_one_behind_it() {
        // A strip of five, of which each shares an edge with the next.
        let strip: Vec<Triangle> = (0..5)
            .map(|i| {
                let corner = |i: usize| [i as f32, (i % 2) as f32];
                fan([corner(i), corner(i + 1), corner(i + 2)])
            })
            .collect();
        for (leaf, ordered, seconds) in [
            (vec![0, 1, 2, 3, 4], vec![0, 1, 2, 3, 4], vec![1, 3]),
            (vec![0, 2, 4, 3, 1], vec![0, 1, 2, 3, 4], vec![1, 3]),
            (vec![1, 4, 0, 2, 3], vec![1, 0, 4, 3, 2], vec![1, 3]),
            (vec![0, 2, 4], vec![0, 2, 4], vec![]),
            (vec![], vec![], vec![]),
        ] {
            let mut leaf = leaf;
            let found: Vec<u32> = join(&mut leaf, &strip).collect();
            assert_eq!((leaf, found), (ordered, seconds));
        }
    }
}
