//! A point with what it asks for, checked, and the name of its inputs.

use super::plan::{Plan, PlannedPoint};
use crate::args::{FrameArgs, MachineArgs};
use crate::machine::Machine;
use crate::options::Request;
use crate::report::TOOL;
use crate::settings::FrameSettings;
use crate::vary::{self, meaningless};
use anyhow::bail;
use reports::sweep::GridAxis;
use scenes::{Mesh, Normals, Scene};
use xxhash_rust::xxh3::{Xxh3Default, xxh3_128};

/// A point that can be replayed.
pub(crate) struct ReadyPoint {
    /// Number in the plan.
    pub(crate) index: usize,
    pub(crate) scene: String,
    pub(crate) frame: FrameArgs,
    pub(crate) settings: FrameSettings,
    pub(crate) machine: Machine,
}

impl ReadyPoint {
    /// Checks what a point asks for; where its options mean nothing together, why. Machines are made once, see `known`.
    ///
    /// # Errors
    /// On options that do not exist, or contradict each other.
    fn new(
        index: usize,
        point: &PlannedPoint,
        known: &mut Vec<(MachineArgs, Machine)>,
    ) -> anyhow::Result<Result<Self, &'static str>> {
        let Request { scene, frame, machine } = point.options.request()?;
        let point = vary::Point { values: Vec::new(), frame, machine };
        if let Some(reason) = meaningless(&point) {
            return Ok(Err(reason));
        }
        let vary::Point { frame, machine, .. } = point;
        let settings = FrameSettings::new(&frame)?;
        let machine = match known.iter().find(|(args, _)| *args == machine) {
            Some((_, known)) => known.clone(),
            None => {
                let made = Machine::of_whole_frames(&machine)?;
                known.push((machine, made.clone()));
                made
            }
        };
        Ok(Ok(Self { index, scene, frame, settings, machine }))
    }

    /// All points of a plan; of those that are not to be replayed, why. A combination of the grid may be impossible, such as a cache that one of
    /// two GPUs does not have.
    ///
    /// # Errors
    /// On a point of the list that is impossible, on a value of the grid with which all points are, and where nothing is left.
    pub(crate) fn all(plan: &Plan, file: &str) -> anyhow::Result<Vec<Result<Self, String>>> {
        let told = |index: usize| {
            let options = plan.points[index].options.iter().map(|(key, value)| format!("{key} {value}"));
            format!("{file}: point {} ({})", index + 1, options.collect::<Vec<_>>().join(", "))
        };
        let mut known = Vec::new();
        let points = plan.points.iter().enumerate();
        let made: Vec<_> = points.map(|(index, point)| Self::new(index, point, &mut known)).collect();
        for (axis, GridAxis { name, values }) in plan.axes.iter().enumerate() {
            for (value, shown) in values.iter().enumerate() {
                let has_value = |index: &usize| {
                    plan.points[*index].place.as_ref().is_some_and(|place| place[axis] == value)
                };
                let mut with_value = (0..made.len()).filter(has_value);
                if with_value.clone().all(|index| !matches!(made[index], Ok(Ok(_))))
                    && let Some(error) = with_value.find_map(|index| made[index].as_ref().err())
                {
                    bail!("{file}: grid.{name}: no point can have {shown}: {error}");
                }
            }
        }
        let mut points = Vec::new();
        for (index, made) in made.into_iter().enumerate() {
            points.push(match made {
                Ok(made) => made.map_err(str::to_owned),
                Err(error) if plan.points[index].place.is_some() => Err(error.to_string()),
                Err(error) => bail!("{}: {error}", told(index)),
            });
        }
        if let (Some(Err(reason)), true) = (points.first(), points.iter().all(Result::is_err)) {
            bail!("{file}: no point is left to replay, for {reason}; vary something else");
        }
        Ok(points)
    }

    /// Hash of everything that its figures follow from and that they name, given that of its scene.
    pub(crate) fn id(&self, scene_key: u128) -> String {
        let Machine { config, gpu_name, gpu_hash, costs_hash, energy_hash, sampled: _ } = &self.machine;
        let inputs = format!(
            "{TOOL}\n{scene_key:032x}\n{:?}\n{config:?}\n{gpu_name}\n{gpu_hash}\n{costs_hash}\n{energy_hash}",
            self.settings
        );
        format!("{:032x}", xxh3_128(inputs.as_bytes()))
    }
}

/// Hash of a scene, of all that a frame's figures can follow from.
pub(crate) fn scene_key(scene: &Scene) -> u128 {
    let Scene { name, meshes, instances, materials, camera, lights, rays, notes } = scene;
    let told = format!("{name}\n{materials:?}\n{camera:?}\n{lights:?}\n{rays:?}\n{notes:?}\n{instances:?}\n");
    let mut hasher = Xxh3Default::new();
    hasher.update(told.as_bytes());
    for Mesh { name: _, positions, triangles, normals, materials } in meshes {
        let mut bytes = Vec::new();
        let lengths = [positions.len(), triangles.len(), materials.len()];
        bytes.extend(lengths.iter().flat_map(|&length| (length as u64).to_le_bytes()));
        bytes.extend(positions.iter().flat_map(|point| point.to_array()).flat_map(f32::to_le_bytes));
        bytes.extend(triangles.iter().flatten().chain(materials).flat_map(|index| index.to_le_bytes()));
        if let Some(Normals { vectors, triangles }) = normals {
            bytes.extend(vectors.iter().flat_map(|vector| vector.to_array()).flat_map(f32::to_le_bytes));
            // No index is that large.
            let indices = triangles.iter().map(|triangle| triangle.unwrap_or([u32::MAX; 3]));
            bytes.extend(indices.flatten().flat_map(u32::to_le_bytes));
        }
        hasher.update(&bytes);
    }
    hasher.digest128()
}
