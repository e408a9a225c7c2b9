//! Hits in f32 held against exact ones.

use crate::exact::{Crossing, ROUNDINGS, plane_crossing};
use crate::reference::Reference;
use tracer::{Hit, Ray};

/// What became of many rays.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Verdicts {
    pub(crate) rays: u64,
    /// Rays that hit something, exactly.
    pub(crate) hits: u64,
    /// Rays whose triangle is not the exact one, nor one exactly as near.
    pub(crate) differing: u64,
    /// Differing rays without a triangle although there is one.
    pub(crate) lost: u64,
    /// Differing rays that the roundings of the test cannot explain.
    pub(crate) wrong: u64,
    /// Largest error of a distance, in roundings: at most [`ROUNDINGS`] by theory.
    pub(crate) t_error: f64,
    /// Largest relative error of a distance.
    pub(crate) relative_t_error: f64,
    /// Largest condition of a crossing.
    pub(crate) condition: f64,
}

impl Verdicts {
    /// Both together.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            differing: self.differing + other.differing,
            lost: self.lost + other.lost,
            wrong: self.wrong + other.wrong,
            t_error: self.t_error.max(other.t_error),
            relative_t_error: self.relative_t_error.max(other.relative_t_error),
            condition: self.condition.max(other.condition),
        }
    }

    /// Differing rays of a million.
    pub(crate) fn per_million(&self) -> f64 {
        1e6 * self.differing as f64 / self.rays.max(1) as f64
    }

    /// Judges one ray's hit, where `exact` is the nearest crossing.
    pub(crate) fn of(
        reference: &Reference<'_>,
        ray: &Ray,
        hit: &Hit,
        exact: Option<(u32, Crossing)>,
    ) -> Self {
        let mut verdict = Self { rays: 1, hits: u64::from(exact.is_some()), ..Self::default() };
        verdict.condition = exact.map_or(0.0, |(_, found)| found.condition);
        let claimed = hit.is_hit().then(|| {
            // What a triangle without area, or seen edge on, is hit at has no exact counterpart.
            plane_crossing(ray, &reference.triangles()[hit.primitive as usize])
        });
        match (claimed, exact) {
            (None, None) => {}
            (None, Some((_, missed))) => {
                (verdict.differing, verdict.lost) = (1, 1);
                verdict.wrong = u64::from(!may_be_lost(ray, &missed));
            }
            (Some(None), _) => (verdict.differing, verdict.wrong) = (1, 1),
            (Some(Some(claimed)), None) => {
                verdict.differing = 1;
                verdict.wrong = u64::from(!may_be_hit(ray, &claimed));
            }
            (Some(Some(claimed)), Some((triangle, exact))) => {
                let as_near =
                    claimed.least_weight() >= 0.0 && (claimed.t - exact.t).abs() <= 1e-9 * exact.t.abs();
                if hit.primitive == triangle || as_near {
                    let error = (f64::from(hit.t) - claimed.t).abs();
                    verdict.t_error = ROUNDINGS * error / claimed.t_doubt;
                    verdict.relative_t_error = if error > 0.0 { error / claimed.t.abs() } else { 0.0 };
                } else {
                    verdict.differing = 1;
                    // A hit in front of the exact one hides it; otherwise that one was lost.
                    let in_front = claimed.t <= exact.t + claimed.t_doubt + exact.t_doubt;
                    let explained = may_be_hit(ray, &claimed) && (in_front || may_be_lost(ray, &exact));
                    verdict.wrong = u64::from(!explained);
                }
            }
        }
        verdict
    }
}

/// Whether rounding can make a test miss what is there.
fn may_be_lost(ray: &Ray, found: &Crossing) -> bool {
    let ends = [ray.t_min, ray.t_max].map(f64::from);
    found.least_weight() <= found.doubt() || ends.iter().any(|end| (found.t - end).abs() <= found.t_doubt)
}

/// Whether rounding can make a test hit there, if it is not there.
fn may_be_hit(ray: &Ray, found: &Crossing) -> bool {
    found.least_weight() >= -found.doubt()
        && found.t >= f64::from(ray.t_min) - found.t_doubt
        && found.t <= f64::from(ray.t_max) + found.t_doubt
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use scenes::Triangle;

    /// A wall at z = 1 and a wider one at z = 2; a ray at a distance from the edge of the nearer.
    fn judge(beside: f32, primitive: u32, t: f32) -> Verdicts {
        let wall = |z: f32, size: f32| Triangle {
            v: [Vec3::new(0.0, -size, z), Vec3::new(0.0, size, z), Vec3::new(-size, 0.0, z)],
        };
        let triangles = [wall(1.0, 1.0), wall(2.0, 4.0)];
        let reference = Reference::new(&triangles);
        let ray = Ray::new(Vec3::new(-beside, 0.0, 0.0), Vec3::Z);
        Verdicts::of(&reference, &ray, &Hit { t, u: 0.5, v: 0.1, primitive }, reference.nearest(&ray))
    }

    #[test]
    fn a_hit_is_wrong_only_where_roundings_cannot_explain_it() {
        let verdict = |beside, primitive, t| {
            let found = judge(beside, primitive, t);
            (found.differing, found.lost, found.wrong)
        };
        assert_eq!(verdict(0.1, 0, 1.0), (0, 0, 0));
        assert_eq!(verdict(0.1, 1, 2.0), (1, 0, 1), "the nearer wall cannot be lost in its middle");
        assert_eq!(verdict(1e-7, 1, 2.0), (1, 0, 0), "but near its edge");
        assert_eq!(verdict(-1e-7, 0, 1.0), (1, 0, 0), "and hit beside it");
        assert_eq!(verdict(-0.1, 0, 1.0), (1, 0, 1), "but not far beside it");
        assert_eq!(verdict(0.1, tracer::NO_HIT, f32::INFINITY), (1, 1, 1));
        assert!(judge(0.1, 0, 1.01).t_error > ROUNDINGS);
    }
}
