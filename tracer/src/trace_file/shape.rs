//! Trees as bytes, before compression: their links, without geometry.

use super::MOST_SHADERS;
use super::codec::{Reader, push_varint, unzigzag, zigzag};
use crate::accel::Accel;
use crate::topology::{Topology, TopologyNode};
use crate::trace::{Step, TraceHeader};

/// Most children of a node of a wide BVH.
const WIDEST_NODE: u64 = 8;

/// Encodes what a trace knows of its scene: a structure's shape and the shader of each triangle, where that is kept.
pub(super) fn encode_structure(topology: &Topology, shaders: &[u32]) -> Vec<u8> {
    let mut bytes = encode_topology(topology);
    shaders.iter().for_each(|&shader| push_varint(&mut bytes, u64::from(shader)));
    bytes
}

/// Decodes and validates the shape of the structure that a header names, and the shader of each triangle, where the header says that it is kept.
pub(super) fn decode_structure(bytes: &[u8], header: &TraceHeader) -> Result<(Topology, Vec<u32>), String> {
    let mut reader = Reader { bytes, position: 0 };
    let topology = decode_topology(&mut reader, header)?;
    let triangles = if header.reflections.is_some() { topology.triangles } else { 0 };
    let shader = |_| Ok(reader.bounded(u64::from(MOST_SHADERS) - 1, "a shader")? as u32);
    let shaders = (0..triangles).map(shader).collect::<Result<Vec<u32>, String>>()?;
    reader.finish()?;
    Ok((topology, shaders))
}

/// Encodes a structure's shape: a tree, or with two levels the TLAS, the mesh of each instance, and the number of BLASes and these.
fn encode_topology(topology: &Topology) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(topology.nodes.len() * 4 + topology.references.len() * 4);
    for (number, (_, tree)) in topology.trees().iter().enumerate() {
        encode_tree(tree, &mut bytes);
        if let (0, Some(levels)) = (number, &topology.levels) {
            let mut previous = 0;
            for &mesh in &levels.meshes {
                push_varint(&mut bytes, zigzag(i64::from(mesh) - previous));
                previous = i64::from(mesh);
            }
            push_varint(&mut bytes, levels.blases.len() as u64);
        }
    }
    bytes
}

fn encode_tree(tree: &Topology, bytes: &mut Vec<u8>) {
    push_varint(bytes, tree.nodes.len() as u64);
    push_varint(bytes, tree.references.len() as u64);
    push_varint(bytes, u64::from(tree.triangles));
    // Links and first positions grow through the list: differences are small. The low bit tells inner nodes (0) from leaves.
    let (mut link, mut position) = (0_i64, 0_i64);
    for node in &tree.nodes {
        match *node {
            TopologyNode::Inner { left } => {
                push_varint(bytes, zigzag(i64::from(left) - link) << 1);
                link = i64::from(left);
            }
            TopologyNode::Wide { first, count, leaves } => {
                push_varint(bytes, zigzag(i64::from(first) - link) << 1);
                push_varint(bytes, u64::from(count));
                push_varint(bytes, u64::from(leaves));
                link = i64::from(first) + i64::from(count);
            }
            TopologyNode::Leaf { first, count } => {
                push_varint(bytes, zigzag(i64::from(first) - position) << 1 | 1);
                push_varint(bytes, u64::from(count));
                position = i64::from(first) + i64::from(count);
            }
        }
    }
    let mut previous = 0;
    for &reference in &tree.references {
        push_varint(bytes, zigzag(i64::from(reference) - previous));
        previous = i64::from(reference);
    }
}

fn decode_topology(reader: &mut Reader<'_>, header: &TraceHeader) -> Result<Topology, String> {
    let is_wide = header.node_format.is_some();
    let topology = if header.accel == Accel::TwoLevel {
        decode_levels(reader, is_wide)?
    } else {
        decode_tree(reader, is_wide)?
    };
    topology.validate()?;
    Ok(topology)
}

fn decode_levels(reader: &mut Reader<'_>, is_wide: bool) -> Result<Topology, String> {
    let tlas = decode_tree(reader, false)?;
    let bytes_left = reader.bytes.len() - reader.position;
    let mut meshes = Vec::with_capacity((tlas.triangles as usize).min(bytes_left));
    let mut previous = 0_i64;
    for _ in 0..tlas.triangles {
        previous = previous.wrapping_add(unzigzag(reader.varint()?));
        meshes.push(to_u32(previous)?);
    }
    let count = reader.bounded(u64::from(Step::MAX_ID), "a number of BLASes of")?;
    let blases = (0..count).map(|_| decode_tree(reader, is_wide)).collect::<Result<Vec<_>, _>>()?;
    Topology::of_two_levels(tlas, blases, meshes)
}

fn to_u32(value: i64) -> Result<u32, String> {
    u32::try_from(value).map_err(|_| format!("a link or position of {value}"))
}

fn decode_tree(reader: &mut Reader<'_>, is_wide: bool) -> Result<Topology, String> {
    let most = u64::from(Step::MAX_ID);
    let nodes = reader.bounded(most, "a number of nodes of")? as usize;
    let references = reader.bounded(most, "a number of references of")? as usize;
    let triangles = reader.bounded(most, "a number of triangles of")? as u32;
    // Each takes a byte at least, so the claimed numbers cannot make the vectors larger than the data.
    let bytes_left = reader.bytes.len() - reader.position;
    let mut tree = Topology {
        nodes: Vec::with_capacity(nodes.min(bytes_left)),
        references: Vec::with_capacity(references.min(bytes_left)),
        triangles,
        levels: None,
    };
    let (mut link, mut position) = (0_i64, 0_i64);
    for _ in 0..nodes {
        let token = reader.varint()?;
        let difference = unzigzag(token >> 1);
        tree.nodes.push(if token & 1 == 0 {
            let first = to_u32(link.wrapping_add(difference))?;
            link = i64::from(first);
            if is_wide {
                let count = reader.bounded(WIDEST_NODE, "a number of inner children of")? as u32;
                let leaves = reader.bounded(WIDEST_NODE - u64::from(count), "a number of leaves of")? as u32;
                link += i64::from(count);
                TopologyNode::Wide { first, count, leaves }
            } else {
                TopologyNode::Inner { left: first }
            }
        } else {
            let first = to_u32(position.wrapping_add(difference))?;
            let count = reader.bounded(most, "a leaf's number of references of")? as u32;
            position = i64::from(first) + i64::from(count);
            TopologyNode::Leaf { first, count }
        });
    }
    let mut previous = 0_i64;
    for _ in 0..references {
        previous = previous.wrapping_add(unzigzag(reader.varint()?));
        tree.references.push(to_u32(previous)?);
    }
    Ok(tree)
}
