//! What deciding about a hit asks of memory.

use super::{Access, Part, missing};
use crate::layout::BufferKind;
use crate::warp::program::{MASK_TEXEL_BYTES, MICROMAP_READ_BYTES};
use crate::warp::steps::WarpStep;
use tracer::DECIDED_BY_MICROMAP;

impl Part<'_> {
    /// A look at the micromap, where there is one; then the shader reads attributes, and samples the mask at what these say.
    pub(super) fn any_hit(&mut self, step: WarpStep<'_>) -> Result<(), String> {
        let (program, buffers) = (self.program, &self.program.buffers);
        if !program.has_any_hits() {
            return Err("it has steps of kind AnyHit, and its header tells of no any-hit shaders".to_owned());
        }
        let position = |id: u32| id & !DECIDED_BY_MICROMAP;
        self.by_ray_unit = false;
        if let Some(micromaps) = &buffers.micromaps {
            self.locate(step.records.iter().map(|&id| position(id)), |position| micromaps.address(position))
                .map_err(|position| missing("opacity micromap of primitive", position))?;
            let shift = buffers.tree.line_shift;
            let lines = self.records[..self.located].iter().map(|&address| address >> shift);
            let lines = self.distinct.filter(lines, self.writer.lines());
            let access =
                Access { kind: BufferKind::Primitive, write: false, bytes: MICROMAP_READ_BYTES, repeats: 1 };
            self.count(access, lines, step.lanes);
            self.end_turn(true);
        }
        if step.shader_lanes == 0 {
            return Ok(());
        }
        let asked = step.records.iter().copied().filter(|&id| id & DECIDED_BY_MICROMAP == 0);
        self.locate(asked.clone(), |position| buffers.attributes(position))
            .map_err(|position| missing("primitive", position))?
            .read_records(buffers.shading_kind, buffers.shading_reads, step.shader_lanes);
        self.end_turn(true);
        let lines = asked.map(|position| (buffers.mask(position) >> program.texture_line_shift) as u32);
        let samples = (f64::from(step.shader_lanes) / program.texture_samples_per_clock).ceil() as u32;
        let texel =
            Access { kind: BufferKind::Attachment, write: false, bytes: MASK_TEXEL_BYTES, repeats: 1 };
        self.sample(texel, lines, step.shader_lanes, samples);
        self.end_turn(true);
        Ok(())
    }
}
