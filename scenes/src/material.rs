//! What a surface asks of the renderer.

use glam::Vec3;

/// Which secondary rays a surface spawns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Reflection {
    /// None: diffuse or glossy shading without further rays.
    #[default]
    None,
    /// A mirror ray (MTL `illum` 3 or 5).
    Mirror,
    /// A mirror ray and a refracted ray (MTL `illum` 4, 6 or 7).
    Glass,
}

/// A material, reduced to what decides which work its surface causes.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the file.
    pub name: String,
    /// Diffuse colour, linear RGB (`Kd`).
    pub diffuse: Vec3,
    /// Specular colour, linear RGB (`Ks`).
    pub specular: Vec3,
    /// Emitted light, linear RGB (`Ke`).
    pub emission: Vec3,
    /// Perceptual roughness in 0 (mirror) to 1 (matte). From a Phong exponent `Ns` as `(2 / (Ns + 2))^(1/4)`.
    pub roughness: f32,
    /// Which secondary rays the surface spawns.
    pub reflection: Reflection,
    /// True when a mask decides per hit whether the surface is there (`map_d`, or glTF `alphaMode` MASK).
    pub alpha_tested: bool,
    /// True when shading reads at least one image.
    pub textured: bool,
}

impl Material {
    /// A matte, untextured surface.
    pub fn matte(name: impl Into<String>, diffuse: Vec3) -> Self {
        Material {
            name: name.into(),
            diffuse,
            specular: Vec3::ZERO,
            emission: Vec3::ZERO,
            roughness: 1.0,
            reflection: Reflection::None,
            alpha_tested: false,
            textured: false,
        }
    }

    /// The roughness that decides on its reflection rays: 0 for mirror and glass, none for a surface without specular colour.
    pub fn reflected_roughness(&self) -> Option<f32> {
        match self.reflection {
            Reflection::Mirror | Reflection::Glass => Some(0.0),
            Reflection::None => (self.specular.max_element() > 0.0).then_some(self.roughness),
        }
    }

    /// The stand-in where a file names no material or one that is not defined.
    pub(crate) fn assumed(name: impl Into<String>) -> Self {
        Material::matte(name, Vec3::splat(0.5))
    }
}
