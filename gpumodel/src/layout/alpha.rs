//! Masks and opacity micromaps in memory.

use super::VEC4_BYTES;
use super::buffers::NOWHERE;
use super::instanced::InstancedTriangles;
use tracer::{Topology, TraceHeader};

/// The texels of a mask.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mask {
    /// Address in bytes.
    pub(super) base: u64,
    pub(super) bytes: u64,
}

impl Mask {
    /// Texels of a triangle: a block of 8x8 of them.
    pub(super) const TRIANGLE_BYTES: u64 = 64;
}

/// The micromaps of all alpha-tested triangles in memory, in file order.
#[derive(Debug)]
pub(crate) struct Micromaps {
    /// Address in bytes.
    base: u64,
    /// Of one.
    triangle_bytes: u64,
    count: u32,
    /// By position in the leaves; [`NOWHERE`] where a triangle has none.
    of_position: Vec<u32>,
}

impl Micromaps {
    /// Lays them out by `place`, which takes a number of bytes and gives an address; `None` where the trace has none.
    pub(super) fn new(
        header: &TraceHeader,
        topology: &Topology,
        instanced: Option<&InstancedTriangles>,
        place: &mut impl FnMut(u64) -> u64,
    ) -> Option<Self> {
        let alpha = header.alpha.as_ref()?;
        let triangle_bytes = u64::from(alpha.micromap?.bytes());
        let mut of_triangle = vec![NOWHERE; topology.stored_triangles() as usize];
        for triangle in (0..topology.triangles).filter(|&triangle| alpha.tested.contains(triangle)) {
            let stored = instanced.map_or(triangle, |instanced| instanced.stored(triangle));
            of_triangle[stored as usize] = 0;
        }
        let mut count = 0;
        for micromap in of_triangle.iter_mut().filter(|micromap| **micromap != NOWHERE) {
            *micromap = count;
            count += 1;
        }
        let of_position = topology.references.iter().map(|&stored| of_triangle[stored as usize]).collect();
        let base = place(triangle_bytes * u64::from(count));
        Some(Self { base, triangle_bytes, count, of_position })
    }

    /// Bytes of all.
    pub(super) fn bytes(&self) -> u64 {
        self.triangle_bytes * u64::from(self.count)
    }

    /// Address, in units of 16 bytes, of that of the triangle at a position in the leaves.
    pub(crate) fn address(&self, position: u32) -> Option<u32> {
        let micromap = *self.of_position.get(position as usize)?;
        (micromap != NOWHERE)
            .then(|| ((self.base + u64::from(micromap) * self.triangle_bytes) / VEC4_BYTES) as u32)
    }
}
