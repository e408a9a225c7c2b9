//! Hits shaded by the shaders of a ray-tracing pipeline (VK_KHR_ray_tracing_pipeline).
//!
//! Where a driver links them, they are one shader: a switch over the hit groups, as an uber shader is. Where it does not, ray generation keeps
//! what it needs in its stack memory, each distinct shader of a warp's hits is called for its own lanes, saves registers, and leaves the payload in
//! stack memory, from which ray generation reads it.

use super::lists::LOAD_BYTES;
use super::rays::RayPass;
use crate::config::{Gpu, PipelineCosts, Reflections, SecondaryQuery};
use crate::layout::BufferKind;
use crate::warp::Emitter;

/// A pipeline on a GPU.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pipeline {
    pub(crate) binding: Binding,
    /// Ray generation, miss, and a closest-hit shader for each material.
    pub(crate) shaders: u32,
    pub(crate) payload_bytes: u32,
    costs: PipelineCosts,
    warp_width: u32,
}

/// How the shaders of a pipeline reach each other, as a GPU's driver does it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Binding {
    /// They are one shader.
    Linked,
    /// They are called.
    Called,
}

/// Ray generation and the miss shader.
const OTHER_SHADERS: u32 = 2;

impl Pipeline {
    /// `None` where the technique has none.
    pub(crate) fn of(
        technique: &Reflections,
        gpu: &Gpu,
        costs: PipelineCosts,
        materials: u32,
    ) -> Option<Self> {
        if !technique.hit_shading.is_pipeline() {
            return None;
        }
        let shaders = OTHER_SHADERS + materials;
        // One trace call: every shader but ray generation is inlined once.
        let links = gpu
            .ray_pipeline
            .is_some_and(|limits| shaders <= limits.linked_shaders && shaders - 1 <= limits.inlined_shaders);
        let binding =
            if links && technique.hit_shading.is_linkable() { Binding::Linked } else { Binding::Called };
        let of_costs = match technique.secondary_query {
            SecondaryQuery::RayGeneration => costs.payload_bytes,
            SecondaryQuery::HitShader => costs.shaded_payload_bytes,
        };
        let payload_bytes = technique.payload_bytes.unwrap_or(of_costs);
        Some(Self { binding, shaders, payload_bytes, costs, warp_width: gpu.cores.warp_width })
    }

    /// Registers of four words, where shaders that are linked hold `linked`.
    pub(super) fn registers(&self, linked: u32) -> u32 {
        match self.binding {
            Binding::Linked => linked,
            Binding::Called => self.costs.registers,
        }
    }

    /// Stack memory of a lane in loads and stores of 16 bytes: where what ray generation keeps, the payload and saved registers begin, and the end.
    fn frame(&self) -> [u32; 4] {
        let loads = |bytes: u32| bytes.div_ceil(LOAD_BYTES as u32);
        let payload = loads(self.costs.live_bytes);
        let saved = payload + loads(self.payload_bytes);
        [0, payload, saved, saved + self.costs.saved_registers]
    }

    /// Bytes of stack memory that a warp needs beside that of traversals.
    pub(super) fn stack_bytes(&self) -> u64 {
        match self.binding {
            Binding::Linked => 0,
            Binding::Called => u64::from(self.frame()[3] * self.warp_width) * LOAD_BYTES,
        }
    }

    /// Bytes of the shader records of misses and hit groups.
    pub(super) fn record_bytes(&self) -> u64 {
        u64::from((self.shaders - 1) * self.costs.record_bytes)
    }

    /// Before a warp's rays are traced.
    pub(super) fn before_trace(&self, pass: &RayPass<'_>, emitter: &mut Emitter, lanes: &[u32]) {
        if self.binding == Binding::Called && !lanes.is_empty() {
            let [live, payload, ..] = self.frame();
            self.stack(pass, emitter, true, live..payload, lanes);
            emitter.end_turn(pass.program, pass.pass, false);
        }
    }

    /// Finds the shaders of what a warp's lanes hit, by shader or `None` for a miss, and executes each for its own.
    pub(super) fn shade(
        &self,
        pass: &RayPass<'_>,
        emitter: &mut Emitter,
        lanes: &[u32],
        hits: &[Option<u32>],
    ) {
        let loads = self.costs.record_bytes.div_ceil(LOAD_BYTES as u32);
        // The miss shader's record is the first.
        let records = hits
            .iter()
            .map(|hit| pass.lists.group_record(hit.map_or(0, |shader| shader + 1), self.costs.record_bytes));
        pass.records(emitter, false, u64::from(self.costs.record_bytes), &records);
        emitter.end_turn(pass.program, pass.pass, true);
        let read = pass.prices.with_loads(&[], loads);
        pass.program.spend(read, 1, lanes.len() as u64, emitter.issue(pass.pass));
        if self.binding == Binding::Linked {
            pass.shade(emitter, hits);
            return;
        }
        let [live, payload, saved, end] = self.frame();
        let calls = calls(lanes, hits);
        let closest_hits = calls.iter().filter(|call| call.shader.is_some()).count() as u64;
        // Each fetches the attributes of its hits itself, of which one is in what a warp issues for its hits.
        let fetch = pass.program.hit_shade();
        pass.program.spend(fetch, closest_hits.saturating_sub(1), 0, emitter.issue(pass.pass));
        for Call { shader, lanes: own } in calls {
            let of_own = vec![shader; own.len()];
            let call = pass.prices.with_loads(&[self.costs.call], 0);
            let issue = emitter.issue(pass.pass);
            issue.shader_calls += 1;
            pass.program.spend(call, 1, own.len() as u64, issue);
            self.stack(pass, emitter, true, saved..end, &own);
            emitter.end_turn(pass.program, pass.pass, false);
            pass.shade(emitter, &of_own);
            self.stack(pass, emitter, true, payload..saved, &own);
            self.stack(pass, emitter, false, saved..end, &own);
            emitter.end_turn(pass.program, pass.pass, true);
        }
        self.stack(pass, emitter, false, live..saved, lanes);
        emitter.end_turn(pass.program, pass.pass, true);
    }

    /// Loads or stores of these parts of the stack memory of lanes.
    fn stack(
        &self,
        pass: &RayPass<'_>,
        emitter: &mut Emitter,
        write: bool,
        parts: std::ops::Range<u32>,
        lanes: &[u32],
    ) {
        let cost = pass.prices.with_loads(&[], parts.len() as u32);
        pass.program.spend(cost, 1, lanes.len() as u64, emitter.issue(pass.pass));
        for part in parts {
            let place = |&lane: &u32| pass.program.buffers.call_frame(part * self.warp_width + lane);
            let access = (BufferKind::Stack, write, LOAD_BYTES as u32);
            emitter.access(pass.program, pass.pass, access, lanes.iter().map(place));
        }
    }
}

/// A shader that a warp calls.
pub(super) struct Call {
    /// `None` for the miss shader.
    pub(super) shader: Option<u32>,
    /// Whose rays hit it, or miss.
    pub(super) lanes: Vec<u32>,
}

/// Each distinct shader once, for its own of the lanes that hit or miss.
pub(super) fn calls(lanes: &[u32], hits: &[Option<u32>]) -> Vec<Call> {
    let mut distinct = hits.to_vec();
    distinct.sort_unstable();
    distinct.dedup();
    let call = |shader: Option<u32>| {
        let own = lanes.iter().zip(hits).filter(|&(_, hit)| *hit == shader);
        Call { shader, lanes: own.map(|(&lane, _)| lane).collect() }
    };
    distinct.into_iter().map(call).collect()
}
