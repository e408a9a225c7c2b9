//! The march through a pyramid of least depths.

use super::march::{Follower, MarchEnd, Verdict};
use super::screen_ray::ScreenRay;

/// Follows a ray.
///
/// A cell whose least depth the whole ray within it is before is crossed, and the next one is larger. In another one the ray goes on to where
/// it reaches that depth, and what follows is looked at in a smaller cell. The pixel that the ray starts in is not looked at.
pub(super) fn follow<F, O>(march: &mut Follower<'_, F, O>) -> MarchEnd
where
    F: Fn([u32; 2]) -> bool,
    O: FnMut(u32, u32, u32),
{
    let ray = march.ray;
    let shortest = ScreenRay::SHORTEST / ray.length();
    let size = march.depth.size(0);
    let top = march.depth.levels() - 1;
    let mut level = 0;
    let mut s = crossing(ray, ray.pixel(0.0, size), 0);
    while s + shortest < 1.0 {
        let pixel = ray.pixel(s + shortest, size);
        let cell = pixel.map(|place| place >> level);
        let exit = crossing(ray, cell, level).clamp(s + shortest, 1.0);
        let Some(depth) = march.read(level, cell) else { break };
        if march.is_before(depth, [s, exit]) {
            march.frees(exit);
            s = exit;
            level = top.min(level + 1);
        } else if level > 0 {
            let reached = ray.at_depth(depth);
            if march.is_before(depth, [s, s]) && reached > s && reached < exit {
                march.frees(reached);
                s = reached;
            }
            level -= 1;
        } else {
            match march.judge(pixel, depth, [s, exit]) {
                Verdict::Hit => return MarchEnd::Hit { x: pixel[0], y: pixel[1] },
                Verdict::Behind => break,
                Verdict::Passed => s = exit,
            }
        }
    }
    march.misses()
}

/// Where the ray crosses the border of a cell towards which it goes.
fn crossing(ray: &ScreenRay, cell: [u32; 2], level: u32) -> f64 {
    let border = |axis: usize| {
        let (start, delta) = (ray.start[axis], ray.delta[axis]);
        let border = (u64::from(cell[axis]) + u64::from(delta > 0.0)) << level;
        if delta == 0.0 { f64::INFINITY } else { (border as f64 - start) / delta }
    };
    border(0).min(border(1))
}
