//! The reflections of a frame: from the screen where it shows what a reflection ray meets, by a ray query where it does not.
//!
//! Calvo Lista, "Ray Tracing in Mobile Games", Vulkanised 2026: a first pass marches each reflection ray through the depth buffer
//! ([`March`]). A ray that meets a surface there takes its colour from the screen; all others go into a list ([`Reflections::rays`])
//! that a second pass traces, in any order ([`ReflectionTracer`]), from where the march ended.
//!
//! The march is of one layer of depth, so it knows nothing behind what the camera sees.

mod frame;
mod gbuffer;
mod hierarchical;
mod linear;
mod march;
mod pyramid;
mod ray_tracer;
mod recorded;
mod screen_ray;
#[cfg(test)]
mod tests;

pub(crate) use screen_ray::Projection;

pub use frame::{Outcome, QueryOrigin, ReflectionRay, ReflectionSettings, Reflections};
pub use gbuffer::GBuffer;
pub use march::{March, MarchBounds, MarchEnd};
pub use pyramid::DepthPyramid;
pub use ray_tracer::{NO_RAY, ReflectionList, ReflectionTracer};
pub use recorded::{RecordedList, RecordedReflections};
