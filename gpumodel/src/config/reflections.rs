//! What the passes of reflections cost in operations: marches on the screen, compaction, sort, materials.

use super::costs::{Cost, TaggedCostFile};
use super::reflection_technique::PAYLOAD_BYTES;
use super::sourced::{File, Sourced, Tag, tags};
use crate::error::Error;
use serde::Deserialize;
use std::ops::RangeInclusive;

/// Registers of a shader.
const REGISTERS: RangeInclusive<u32> = 1..=1024;

/// Costs of the passes of reflections, without the addresses of their loads, stores and atomics of buffers, which are
/// [`SharedCosts::address`](super::SharedCosts::address) each; addresses of shared memory and loop control are among them.
#[derive(Clone, Copy, Debug)]
pub struct ReflectionCosts {
    /// From a ray to a line on the screen, in equal steps.
    pub march_setup: Cost,
    /// A step of it, which reads a texel of depth.
    pub march_step: Cost,
    /// From a ray to a line through a pyramid of depths.
    pub hierarchical_setup: Cost,
    /// A step of it, which reads a texel of one level.
    pub hierarchical_step: Cost,
    /// Of either march, at a pixel that the ray is behind: whether it meets the surface, whose normal it reads.
    pub march_judge: Cost,
    /// [`Binning::Sign`](crate::ordering::Binning::Sign).
    pub bin_sign: Cost,
    /// [`Binning::Octahedral`](crate::ordering::Binning::Octahedral).
    pub bin_octahedral: Cost,
    /// [`Binning::Position`](crate::ordering::Binning::Position) of two bits.
    pub bin_position: Cost,
    /// A ray appended without bins: the add to the global counter and the maximum for the dispatch.
    pub append: Cost,
    /// Setting a bin's counter to zero, for each that a lane sets.
    pub zero_bin: Cost,
    /// A ray's place in its bin.
    pub rank: Cost,
    /// A bin in the sum that one lane makes.
    pub sum_bin: Cost,
    /// That lane's add to the global counter and maximum for the dispatch.
    pub start: Cost,
    /// A ray's place in the buffer.
    pub place: Cost,
    /// A lower bin in that place.
    pub lower_bin: Cost,
    /// Writing a ray that missed on the screen: 32 bytes in 2 stores.
    pub write_missed: Cost,
    /// Reading it, in 2 loads.
    pub read_missed: Cost,
    /// Writing what it hit: 36 bytes in 4 stores.
    pub write_hit: Cost,
    /// Reading that, the direction to the viewer among it.
    pub read_hit: Cost,
    /// The bucket of a hit, in 2 loads; of the first and the last pass of the sort.
    pub bucket: Cost,
    /// The rest of the first pass, for an element.
    pub sort_count: Cost,
    /// The second pass, for a bucket.
    pub sort_offset: Cost,
    /// The rest of the last pass, for an element.
    pub sort_copy: Cost,
    /// A trip of [`AtomicStrategy::Loop`](crate::ordering::AtomicStrategy::Loop).
    pub loop_trip: Cost,
    /// A trip of [`AtomicStrategy::Subgroup`](crate::ordering::AtomicStrategy::Subgroup).
    pub subgroup_trip: Cost,
    /// A trip of [`AtomicStrategy::Ballot`](crate::ordering::AtomicStrategy::Ballot).
    pub ballot_trip: Cost,
    /// Normal and texture coordinates of a hit, in 4 loads.
    pub fetch: Cost,
    /// A material of albedo alone, in 1 load.
    pub diffuse: Cost,
    /// A material of albedo, roughness and reflectance, in 2 loads.
    pub glossy: Cost,
    /// What a texture adds to a material.
    pub texture: Cost,
    /// What a ray that hits nothing shows.
    pub sky: Cost,
    /// Entries of two uber shaders, and the instructions that a compiler made of each, without nops.
    pub uber_sizes: [[u32; 2]; 2],
    /// What a ray-tracing pipeline adds.
    pub pipeline: PipelineCosts,
    /// What the passes hold.
    pub registers: ReflectionRegisters,
}

impl ReflectionCosts {
    /// Instructions of an uber shader of so many materials, by the line through the two that were compiled.
    pub fn uber_instructions(&self, entries: u32) -> f64 {
        let [[few, of_few], [more, of_more]] = self.uber_sizes.map(|pair| pair.map(f64::from));
        of_few + (of_more - of_few) / (more - few) * (f64::from(entries) - few)
    }
}

/// What a ray-tracing pipeline does beside what an uber shader does.
#[derive(Clone, Copy, Debug)]
pub struct PipelineCosts {
    /// A call of a shader and its return, arguments moved; without loads and stores.
    pub call: Cost,
    /// Bytes of a shader's record that a call reads.
    pub record_bytes: u32,
    /// Bytes of a ray's payload where ray generation sends the shadow ray.
    pub payload_bytes: u32,
    /// Bytes of a ray's payload where the closest-hit shader sends it.
    pub shaded_payload_bytes: u32,
    /// Bytes of a lane that ray generation keeps across a trace.
    pub live_bytes: u32,
    /// Registers of four words that a called shader stores and loads again.
    pub saved_registers: u32,
    /// Registers of four words that a lane holds where shaders are called.
    pub registers: u32,
}

/// Registers of four words per lane that passes of reflections hold.
#[derive(Clone, Copy, Debug)]
pub struct ReflectionRegisters {
    /// A march in equal steps.
    pub march: u32,
    /// A march through a pyramid of depths.
    pub hierarchical: u32,
    /// Ray queries whose hits are written for later.
    pub query: u32,
    /// Ray queries whose hits are shaded at once, by any of several materials.
    pub uber: u32,
    /// The sort.
    pub sort: u32,
    /// Shading by one material.
    pub shade: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ReflectionsFile {
    march_setup: TaggedCostFile,
    march_step: TaggedCostFile,
    hierarchical_setup: TaggedCostFile,
    hierarchical_step: TaggedCostFile,
    march_judge: TaggedCostFile,
    bin_sign: TaggedCostFile,
    bin_octahedral: TaggedCostFile,
    bin_position: TaggedCostFile,
    append: TaggedCostFile,
    zero_bin: TaggedCostFile,
    rank: TaggedCostFile,
    sum_bin: TaggedCostFile,
    start: TaggedCostFile,
    place: TaggedCostFile,
    lower_bin: TaggedCostFile,
    write_missed: TaggedCostFile,
    read_missed: TaggedCostFile,
    write_hit: TaggedCostFile,
    read_hit: TaggedCostFile,
    bucket: TaggedCostFile,
    sort_count: TaggedCostFile,
    sort_offset: TaggedCostFile,
    sort_copy: TaggedCostFile,
    loop_trip: TaggedCostFile,
    subgroup_trip: TaggedCostFile,
    ballot_trip: TaggedCostFile,
    fetch: TaggedCostFile,
    diffuse: TaggedCostFile,
    glossy: TaggedCostFile,
    texture: TaggedCostFile,
    sky: TaggedCostFile,
    uber_sizes: Sourced<[[u32; 2]; 2]>,
    pipeline: PipelineFile,
    registers: RegistersFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PipelineFile {
    call: TaggedCostFile,
    record_bytes: Sourced<u32>,
    payload_bytes: Sourced<u32>,
    shaded_payload_bytes: Sourced<u32>,
    live_bytes: Sourced<u32>,
    saved_registers: Sourced<u32>,
    registers: Sourced<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RegistersFile {
    march: Sourced<u32>,
    hierarchical: Sourced<u32>,
    query: Sourced<u32>,
    uber: Sourced<u32>,
    sort: Sourced<u32>,
    shade: Sourced<u32>,
}

pub(super) fn reflections(file: &File<'_>, raw: &ReflectionsFile) -> Result<ReflectionCosts, Error> {
    let cost = |field: &str, raw: &TaggedCostFile| raw.read(file, &format!("reflections.{field}"));
    Ok(ReflectionCosts {
        march_setup: cost("march_setup", &raw.march_setup)?,
        march_step: cost("march_step", &raw.march_step)?,
        hierarchical_setup: cost("hierarchical_setup", &raw.hierarchical_setup)?,
        hierarchical_step: cost("hierarchical_step", &raw.hierarchical_step)?,
        march_judge: cost("march_judge", &raw.march_judge)?,
        bin_sign: cost("bin_sign", &raw.bin_sign)?,
        bin_octahedral: cost("bin_octahedral", &raw.bin_octahedral)?,
        bin_position: cost("bin_position", &raw.bin_position)?,
        append: cost("append", &raw.append)?,
        zero_bin: cost("zero_bin", &raw.zero_bin)?,
        rank: cost("rank", &raw.rank)?,
        sum_bin: cost("sum_bin", &raw.sum_bin)?,
        start: cost("start", &raw.start)?,
        place: cost("place", &raw.place)?,
        lower_bin: cost("lower_bin", &raw.lower_bin)?,
        write_missed: cost("write_missed", &raw.write_missed)?,
        read_missed: cost("read_missed", &raw.read_missed)?,
        write_hit: cost("write_hit", &raw.write_hit)?,
        read_hit: cost("read_hit", &raw.read_hit)?,
        bucket: cost("bucket", &raw.bucket)?,
        sort_count: cost("sort_count", &raw.sort_count)?,
        sort_offset: cost("sort_offset", &raw.sort_offset)?,
        sort_copy: cost("sort_copy", &raw.sort_copy)?,
        loop_trip: cost("loop_trip", &raw.loop_trip)?,
        subgroup_trip: cost("subgroup_trip", &raw.subgroup_trip)?,
        ballot_trip: cost("ballot_trip", &raw.ballot_trip)?,
        fetch: cost("fetch", &raw.fetch)?,
        diffuse: cost("diffuse", &raw.diffuse)?,
        glossy: cost("glossy", &raw.glossy)?,
        texture: cost("texture", &raw.texture)?,
        sky: cost("sky", &raw.sky)?,
        uber_sizes: uber_sizes(file, &raw.uber_sizes)?,
        pipeline: pipeline(file, &raw.pipeline)?,
        registers: registers(file, &raw.registers)?,
    })
}

fn uber_sizes(file: &File<'_>, raw: &Sourced<[[u32; 2]; 2]>) -> Result<[[u32; 2]; 2], Error> {
    const KEY: &str = "reflections.uber_sizes";
    let sizes = *file.sourced(KEY, raw)?;
    let [[few, _], [more, _]] = sizes;
    if few >= more {
        let problem = format!("are of {few} and {more} entries, expected more in the second");
        return Err(file.refuse(KEY, &raw.value.span(), problem, "correct the value"));
    }
    Ok(sizes)
}

fn pipeline(file: &File<'_>, raw: &PipelineFile) -> Result<PipelineCosts, Error> {
    let key = |field: &str| format!("reflections.pipeline.{field}");
    let bytes = |field: &str, raw: &Sourced<u32>| file.within(&key(field), raw, PAYLOAD_BYTES);
    Ok(PipelineCosts {
        call: raw.call.read(file, &key("call"))?,
        record_bytes: bytes("record_bytes", &raw.record_bytes)?,
        payload_bytes: bytes("payload_bytes", &raw.payload_bytes)?,
        shaded_payload_bytes: bytes("shaded_payload_bytes", &raw.shaded_payload_bytes)?,
        live_bytes: bytes("live_bytes", &raw.live_bytes)?,
        saved_registers: file.within(&key("saved_registers"), &raw.saved_registers, REGISTERS)?,
        registers: file.within(&key("registers"), &raw.registers, REGISTERS)?,
    })
}

/// Keys of the figures that are estimates, in a text that has been read once.
pub(super) fn reflection_estimates(text: &str) -> Vec<String> {
    let estimates = tags(text).into_iter().filter(|(_, tag)| *tag == Tag::Estimate).map(|(key, _)| key);
    estimates.filter(|key| key.starts_with("reflections.")).collect()
}

fn registers(file: &File<'_>, raw: &RegistersFile) -> Result<ReflectionRegisters, Error> {
    let count = |pass: &str, raw: &Sourced<u32>| {
        file.within(&format!("reflections.registers.{pass}"), raw, REGISTERS)
    };
    Ok(ReflectionRegisters {
        march: count("march", &raw.march)?,
        hierarchical: count("hierarchical", &raw.hierarchical)?,
        query: count("query", &raw.query)?,
        uber: count("uber", &raw.uber)?,
        sort: count("sort", &raw.sort)?,
        shade: count("shade", &raw.shade)?,
    })
}
