//! What is read and written, by no warp and at no time.

use super::super::stream::{Share, TileStream};
use super::{Emitter, missing};
use crate::counters::Pass;
use crate::layout::BufferKind;
use crate::warp::program::Program;
use crate::warp::steps::WarpStep;
use tracer::{DECIDED_BY_MICROMAP, Op, Step, TileRect};

/// Lanes of a load or store, at most.
const WARP: usize = 64;

impl Emitter {
    /// The lines of what these steps and the shading of these triangles read, and of the image that tile `index` at `rect` writes.
    ///
    /// # Errors
    /// A sentence when a step names what does not exist.
    pub(crate) fn touch(
        &mut self,
        program: &Program,
        (steps, shaded): (&[Step], &[u32]),
        (index, rect): (u32, TileRect),
    ) -> Result<TileStream, String> {
        let pass = Pass::Primary;
        for step in steps {
            let (op, id) = (step.op(), step.id());
            let reads_less = match op {
                Op::Node => program.levels.is_alone(id),
                Op::Primitive => program.seconds.contains(id),
                _ => false,
            };
            let step = WarpStep {
                op,
                lanes: 1,
                root_lanes: u32::from(reads_less),
                shader_lanes: u32::from(op == Op::AnyHit && id & DECIDED_BY_MICROMAP == 0),
                records: &[id],
            };
            self.step(program, pass, step)?;
        }
        let buffers = &program.buffers;
        for &triangle in shaded {
            let mut part = self.part(program, pass, Share::Own);
            part.by_ray_unit = false;
            part.locate(std::iter::once(triangle), |triangle| buffers.shading(triangle))
                .map_err(|triangle| missing("triangle", triangle))?
                .read_records(buffers.shading_kind, buffers.shading_reads, 1);
        }
        if program.writes_image {
            let rays: Vec<u32> = (0..rect.width * rect.height).collect();
            for rays in rays.chunks(WARP) {
                self.pixels(program, Pass::Output, BufferKind::Image, rays, index, rect);
            }
        }
        Ok(self.own.take())
    }
}
