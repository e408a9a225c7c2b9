//! The march with steps of equal length on the screen.

use super::march::{Follower, MarchEnd, Verdict};
use super::screen_ray::ScreenRay;

/// Follows a ray with this stride.
///
/// The line moves on one axis by a pixel per *step*, and what is read at a step is the texel that the middle of the step lies in. Step 0, the
/// rest of the pixel that the ray starts in, is not looked at.
pub(super) fn follow<F, O>(march: &mut Follower<'_, F, O>, stride: u32) -> MarchEnd
where
    F: Fn([u32; 2]) -> bool,
    O: FnMut(u32, u32, u32),
{
    let steps = Steps::new(march);
    let mut last = 0;
    while last < steps.count {
        let step = steps.count.min(last.saturating_add(stride.max(1)));
        let Some(verdict) = first_behind(march, &steps, last, step) else { break };
        match verdict {
            (pixel, Verdict::Hit) => return MarchEnd::Hit { x: pixel[0], y: pixel[1] },
            (_, Verdict::Behind) => break,
            (_, Verdict::Passed) => last = step,
        }
    }
    march.misses()
}

/// Reads `step`, and, where the ray is behind its surface, bisects the steps since `before` for the first where it is; judges that one. `None`
/// when no more may be read.
fn first_behind<F, O>(
    march: &mut Follower<'_, F, O>,
    steps: &Steps,
    mut before: u32,
    mut step: u32,
) -> Option<([u32; 2], Verdict)>
where
    F: Fn([u32; 2]) -> bool,
    O: FnMut(u32, u32, u32),
{
    let read = |march: &mut Follower<'_, F, O>, step: u32| {
        let pixel = march.ray.pixel(steps.middle(step), march.depth.size(0));
        Some((pixel, march.read(0, pixel)?))
    };
    let (mut pixel, mut depth) = read(march, step)?;
    while step - before > 1 && !march.is_before(depth, steps.part(step)) {
        let middle = before + (step - before) / 2;
        let (middle_pixel, middle_depth) = read(march, middle)?;
        if march.is_before(middle_depth, steps.part(middle)) {
            before = middle;
            march.frees(steps.part(middle)[1]);
        } else {
            (step, pixel, depth) = (middle, middle_pixel, middle_depth);
        }
    }
    Some((pixel, march.judge(pixel, depth, steps.part(step))))
}

/// The steps of a line.
struct Steps {
    /// Pixels of the first, partial one.
    first: f64,
    length: f64,
    /// How many follow it.
    count: u32,
}

impl Steps {
    fn new<F, O>(march: &Follower<'_, F, O>) -> Self {
        let ray = march.ray;
        let axis = usize::from(ray.delta.x.abs() < ray.delta.y.abs());
        let (start, length) = (ray.start[axis], ray.length());
        let within = start - start.floor();
        let first = if ray.delta[axis] > 0.0 { 1.0 - within } else { within };
        Self { first, length, count: (length - first - ScreenRay::SHORTEST).ceil().max(0.0) as u32 }
    }

    /// Where a step, from 1, begins and ends along the ray.
    fn part(&self, step: u32) -> [f64; 2] {
        let end = self.first + f64::from(step);
        [(end - 1.0) / self.length, (end / self.length).min(1.0)]
    }

    fn middle(&self, step: u32) -> f64 {
        ((self.first + f64::from(step) - 0.5) / self.length).min(1.0)
    }
}
