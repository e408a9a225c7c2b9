//! How much the boxes of the instances overlap, from a sample of points.
//!
//! The exact volume of a union of boxes has no algorithm that is fast for any boxes, and pairs of boxes can be n^2 many. A point
//! costs a descent of the TLAS, which ends at the first other box.

use super::sampling::Uniform;
use super::structure::PlacedBlas;
use super::tlas::TopLevel;
use crate::aabb::Aabb;
use glam::DVec3;

/// Points: the standard error of a share is at most 0.5 / sqrt(4096) = 0.8 %.
const POINTS: u32 = 4096;

/// Share of the boxes' volumes, each counted, that lies in another box as well; `None` where no box has a volume.
pub(super) fn shared_volume(tlas: &impl TopLevel, instances: &[PlacedBlas]) -> Option<f64> {
    let volumes: Vec<f64> = instances.iter().map(|placed| volume(&placed.bounds)).collect();
    let total: f64 = volumes.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let mut uniform = Uniform::new();
    let mut shared = 0;
    // Points are spread over the boxes in equal steps of volume.
    let mut number = 0;
    let mut before = 0.0;
    for point in 0..POINTS {
        let at = (f64::from(point) + uniform.next()) / f64::from(POINTS) * total;
        while number + 1 < volumes.len() && before + volumes[number] <= at {
            before += volumes[number];
            number += 1;
        }
        let Aabb { min, max } = instances[number].bounds;
        let [min, max] = [min.as_dvec3(), max.as_dvec3()];
        let point = min + DVec3::new(uniform.next(), uniform.next(), uniform.next()) * (max - min);
        shared += u32::from(lies_in_another(tlas, instances, number, point));
    }
    Some(f64::from(shared) / f64::from(POINTS))
}

fn volume(bounds: &Aabb) -> f64 {
    if bounds.is_empty() { 0.0 } else { bounds.extent().as_dvec3().element_product() }
}

fn contains(bounds: &Aabb, point: DVec3) -> bool {
    bounds.min.as_dvec3().cmple(point).all() && point.cmple(bounds.max.as_dvec3()).all()
}

/// Whether the point lies in the box of an instance other than `own`.
fn lies_in_another(tlas: &impl TopLevel, instances: &[PlacedBlas], own: usize, point: DVec3) -> bool {
    tlas.any_instance(
        |bounds| contains(bounds, point),
        |number| number as usize != own && contains(&instances[number as usize].bounds, point),
    )
}
