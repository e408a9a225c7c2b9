//! Which stored triangle a triangle of the scene is, where meshes are stored once and placed by instances.

use tracer::Topology;

/// The triangles of all instances, in the order of the scene.
#[derive(Debug)]
pub(super) struct InstancedTriangles {
    /// Per instance, its first triangle in the scene; rising.
    first: Vec<u32>,
    /// Per instance, the first triangle of its mesh among those of all meshes.
    stored: Vec<u32>,
}

impl InstancedTriangles {
    /// Those of a valid structure of two levels; `None` for one.
    pub(super) fn new(topology: &Topology) -> Option<Self> {
        let levels = topology.levels.as_ref()?;
        let (mut first, mut stored) = (Vec::new(), Vec::new());
        let mut next = 0;
        for blas in (0..levels.meshes.len() as u32).filter_map(|instance| levels.blas_of(instance)) {
            first.push(next);
            stored.push(blas.references.start);
            next += blas.references.len() as u32;
        }
        Some(Self { first, stored })
    }

    /// The stored triangle of one of the scene's. Instances of empty meshes begin where the next instance does, and come before it.
    pub(super) fn stored(&self, triangle: u32) -> u32 {
        let instance = self.first.partition_point(|&first| first <= triangle) - 1;
        self.stored[instance] + (triangle - self.first[instance])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracer::TopologyNode;

    #[test]
    fn triangles_of_instances_are_those_of_their_mesh_with_empty_meshes_between() {
        let leaf = |count: u32| Topology {
            nodes: vec![TopologyNode::Leaf { first: 0, count }],
            references: (0..count).collect(),
            triangles: count,
            ..Topology::default()
        };
        let meshes = vec![1, 0, 2, 0, 1, 2];
        let tlas = Topology { references: (0..6).collect(), triangles: 6, ..leaf(6) };
        let topology = Topology::of_two_levels(tlas, vec![leaf(3), leaf(0), leaf(2)], meshes).expect("valid");
        topology.validate().expect("valid");
        let triangles = InstancedTriangles::new(&topology).expect("two levels");
        let stored: Vec<u32> = (0..topology.triangles).map(|triangle| triangles.stored(triangle)).collect();
        assert_eq!(stored, [0, 1, 2, 3, 4, 0, 1, 2, 3, 4]);
    }
}
