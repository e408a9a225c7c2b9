//! What a report says of a structure of two levels.

use tracer::AccelerationStructure;
use tracer::two_level::{SMALL_BLAS_TRIANGLES, TwoLevelStatistics};

/// How large the structure is against one of copied meshes, how its instances lie, and what to change; nothing for other structures.
pub(crate) fn notes(structure: &AccelerationStructure) -> Vec<String> {
    let Some(statistics) = structure.two_level_statistics() else { return Vec::new() };
    let topology = structure.topology();
    let Some(levels) = &topology.levels else { return Vec::new() };
    let copied: u64 = (0..levels.meshes.len() as u32)
        .filter_map(|instance| levels.blas_of(instance))
        .map(|blas| blas.nodes.len() as u64)
        .sum();
    let TwoLevelStatistics { instances, expected_entries, overlap_share, blases } = &statistics;
    let size = format!(
        "Two levels: {instances} instances of {} meshes; {} nodes, {} of them in the TLAS, and {} triangles, where a copy of its mesh \
         for each instance would have {copied} nodes below the TLAS and {} triangles.",
        blases.len(),
        topology.node_count(),
        levels.tlas_nodes,
        topology.stored_triangles(),
        topology.triangles,
    );
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let entries = expected_entries.map(|entries| {
        let overlap = overlap_share.map_or(String::new(), |share| {
            format!("; {} of the volume of their boxes lies in more than one", percent(share))
        });
        format!("A random ray that meets the box of all instances meets the boxes of {entries:.1}{overlap}.")
    });
    let advice = statistics.warnings(SMALL_BLAS_TRIANGLES);
    std::iter::once(size).chain(entries).chain(advice).collect()
}
