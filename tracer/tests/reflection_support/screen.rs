//! A march written down anew, as a list of the parts of a ray: in world space, by planes through the eye, without any projected line.

use glam::{DVec2, DVec3};
use scenes::Camera;
use tracer::Ray;
use tracer::reflections::{GBuffer, MarchEnd};

/// A pixel and the parameters between which a ray passes it.
pub(crate) type Part = ([u32; 2], [f64; 2]);

/// A camera over a square image.
pub(crate) struct Screen {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Pixels per unit at depth 1.
    scale: f64,
    edge: u32,
}

impl Screen {
    pub(crate) fn new(camera: &Camera, edge: u32) -> Self {
        let forward = (camera.target - camera.eye).as_dvec3().normalize();
        let right = forward.cross(camera.up.as_dvec3()).normalize();
        let half = (f64::from(camera.vertical_fov_degrees).to_radians() / 2.0).tan();
        let scale = f64::from(edge) / 2.0 / half;
        Self { eye: camera.eye.as_dvec3(), right, up: right.cross(forward), forward, scale, edge }
    }

    pub(crate) fn depth(&self, point: DVec3) -> f64 {
        (point - self.eye).dot(self.forward)
    }

    /// In pixels from the upper left.
    pub(crate) fn position(&self, point: DVec3) -> DVec2 {
        let from_eye = (point - self.eye) / self.depth(point);
        let middle = f64::from(self.edge) / 2.0;
        DVec2::new(from_eye.dot(self.right), -from_eye.dot(self.up)) * self.scale + middle
    }

    pub(crate) fn pixel(&self, point: DVec3) -> Option<[u32; 2]> {
        let position = self.position(point);
        let inside = |place: f64| place >= 0.0 && place < f64::from(self.edge);
        (self.depth(point) > 0.0 && inside(position.x) && inside(position.y))
            .then_some([position.x as u32, position.y as u32])
    }

    /// Where the ray meets the plane of all points on one line of pixels: column or row `line`.
    fn crossing(&self, ray: &Ray, axis: usize, line: f64) -> f64 {
        let side = if axis == 0 { self.right } else { -self.up };
        let normal = side * self.scale - self.forward * (line - f64::from(self.edge) / 2.0);
        (self.eye - ray.origin.as_dvec3()).dot(normal) / ray.direction.as_dvec3().dot(normal)
    }

    /// Where the ray leaves the screen, or comes nearer than `near`.
    fn end(&self, ray: &Ray, near: f64) -> f64 {
        let edge = f64::from(self.edge);
        let borders = [(0, 0.0), (0, edge), (1, 0.0), (1, edge)];
        let slope = ray.direction.as_dvec3().dot(self.forward);
        let nearest = (near - self.depth(ray.origin.as_dvec3())) / slope;
        let crossings = borders.map(|(axis, line)| self.crossing(ray, axis, line));
        let near = (slope < 0.0).then_some(nearest.max(0.0));
        crossings.into_iter().filter(|&t| t > 0.0).chain(near).fold(f64::INFINITY, f64::min)
    }

    /// Which way it moves, in pixels per unit of its parameter at its start.
    fn motion(&self, ray: &Ray) -> DVec2 {
        let step = self.depth(ray.origin.as_dvec3()) * 1e-6;
        let at = |t: f64| self.position(ray.origin.as_dvec3() + ray.direction.as_dvec3() * t);
        (at(step) - at(-step)) / (2.0 * step)
    }

    fn at(&self, ray: &Ray, t: f64) -> DVec3 {
        // A ray that stays on the screen ends infinitely far away, in the direction that it has.
        let t = if t.is_finite() { t } else { self.depth(ray.origin.as_dvec3()) * 1e9 };
        ray.origin.as_dvec3() + ray.direction.as_dvec3() * t
    }

    /// One part for each column that the ray crosses, or row if it crosses more of these; of the pixel that it is in half-way through.
    pub(crate) fn steps(&self, ray: &Ray, near: f64) -> Vec<Part> {
        let motion = self.motion(ray);
        let axis = usize::from(motion.x.abs() < motion.y.abs());
        let end = self.end(ray, near);
        let forwards = motion[axis] > 0.0;
        let first = self.position(ray.origin.as_dvec3())[axis].floor() as i64;
        let mut parts = Vec::new();
        for step in 1.. {
            let line = if forwards { first + step } else { first - step };
            let side = |near_side: bool| line + i64::from(near_side != forwards);
            let entry = self.crossing(ray, axis, side(true) as f64);
            let exit = self.crossing(ray, axis, side(false) as f64);
            if line < 0 || line >= i64::from(self.edge) || !(0.0..end).contains(&entry) {
                return parts;
            }
            // Beyond its vanishing point it crosses nothing.
            let until = |t: f64| if t > entry { t.min(end) } else { end };
            let middle = self.position(self.at(ray, until(self.crossing(ray, axis, line as f64 + 0.5))));
            let last = f64::from(self.edge - 1);
            let pixel = middle.clamp(DVec2::ZERO, DVec2::splat(last));
            parts.push(([pixel.x as u32, pixel.y as u32], [entry, until(exit)]));
        }
        parts
    }

    /// One part for each pixel that the ray passes after its own.
    pub(crate) fn pixels(&self, ray: &Ray, near: f64) -> Vec<Part> {
        let end = self.end(ray, near);
        let lines = (0..2).flat_map(|axis| (0..=self.edge).map(move |line| (axis, f64::from(line))));
        let crossings = lines.map(|(axis, line)| self.crossing(ray, axis, line));
        let mut crossings: Vec<f64> = crossings.filter(|&t| t > 0.0 && t < end).chain([end]).collect();
        crossings.sort_by(f64::total_cmp);
        let parts = crossings.windows(2).filter_map(|part| {
            let [entry, exit] = *part else { return None };
            let depth = |t: f64| self.depth(self.at(ray, t));
            // Half-way on the screen.
            let middle = (self.position(self.at(ray, entry)) + self.position(self.at(ray, exit))) / 2.0;
            let on_screen = middle.min_element() >= 0.0 && middle.max_element() < f64::from(self.edge);
            (on_screen && depth(entry) > 0.0).then_some(([middle.x as u32, middle.y as u32], [entry, exit]))
        });
        parts.collect()
    }

    /// The least and the largest depth of a part.
    pub(crate) fn depths(&self, ray: &Ray, [from, to]: [f64; 2]) -> [f64; 2] {
        let [a, b] = [from, to].map(|t| self.depth(self.at(ray, t)));
        [a.min(b), a.max(b)]
    }

    /// How the march ends that reads the pixels of `parts`, and how many of these it reads.
    pub(crate) fn march(
        &self,
        gbuffer: &GBuffer<'_>,
        ray: &Ray,
        parts: &[Part],
        thickness: f64,
    ) -> (MarchEnd, usize) {
        for (read, &([x, y], part)) in (1..).zip(parts) {
            let depth = f64::from(gbuffer.depth().depth(0, x, y));
            let [least, largest] = self.depths(ray, part);
            if depth == f64::INFINITY || largest < depth {
                continue;
            }
            let near = least <= depth * (1.0 + thickness);
            let normal = gbuffer.departure(y * self.edge + x).expect("a surface").normal;
            match (near, normal.dot(ray.direction) < 0.0) {
                (true, true) => return (MarchEnd::Hit { x, y }, read),
                (true, false) => {}
                (false, _) => return (MarchEnd::Miss { t: 0.0 }, read),
            }
        }
        (MarchEnd::Miss { t: 0.0 }, parts.len())
    }
}
