//! Which sets of rays a frame has: kinds, and how a trace's header names them.

use crate::ray::Query;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Most ray sets of a frame in a trace file.
pub const MAX_RAY_SETS: usize = 1024;

/// What the rays of a set are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RayKind {
    /// From the camera, or from a ray file; closest hit.
    Primary,
    /// From each primary hit to the middle of a light; any hit.
    Shadow,
    /// From each primary hit to a point of the sphere that a light is; any hit.
    SoftShadow,
    /// From each primary hit of a smooth surface along its reflection; closest hit.
    Reflection,
    /// From each hit of a reflection ray to the middle of a light; any hit.
    ReflectionShadow,
    /// From each primary hit into its surroundings; any hit.
    AmbientOcclusion,
    /// From each primary hit to what lights it; closest hit.
    Diffuse,
    /// From each hit of a diffuse ray to the middle of a light; any hit.
    DiffuseShadow,
}

impl RayKind {
    /// All kinds, in the order in which a pixel's shader casts them.
    pub const ALL: [Self; 8] = [
        Self::Primary,
        Self::Shadow,
        Self::SoftShadow,
        Self::Reflection,
        Self::ReflectionShadow,
        Self::AmbientOcclusion,
        Self::Diffuse,
        Self::DiffuseShadow,
    ];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::SoftShadow => "soft-shadow",
            Self::Reflection => "reflection",
            Self::ReflectionShadow => "reflection-shadow",
            Self::AmbientOcclusion => "ambient-occlusion",
            Self::Diffuse => "diffuse",
            Self::DiffuseShadow => "diffuse-shadow",
        }
    }

    /// The kind of ray from whose hits rays of this kind start.
    pub fn starts_from(self) -> Option<Self> {
        match self {
            Self::Primary => None,
            Self::Shadow | Self::SoftShadow | Self::Reflection | Self::AmbientOcclusion | Self::Diffuse => {
                Some(Self::Primary)
            }
            Self::ReflectionShadow => Some(Self::Reflection),
            Self::DiffuseShadow => Some(Self::Diffuse),
        }
    }

    /// Whether a shader reads the triangle's shading record at its hits.
    pub fn is_shaded(self) -> bool {
        matches!(self, Self::Primary | Self::Reflection | Self::Diffuse)
    }

    /// What its rays ask for, where rays to lights ask for `shadow_query`.
    pub fn query(self, shadow_query: Query) -> Query {
        match self {
            Self::Primary | Self::Reflection | Self::Diffuse => Query::Closest,
            Self::Shadow | Self::SoftShadow | Self::ReflectionShadow | Self::DiffuseShadow => shadow_query,
            Self::AmbientOcclusion => Query::Any,
        }
    }

    /// Whether its rays depend on where their surface is looked at from, and not on the surface alone; primary rays are found again by
    /// reprojection.
    pub fn depends_on_view(self) -> bool {
        matches!(self, Self::Reflection | Self::ReflectionShadow)
    }

    /// Whether its rays go to lights.
    pub fn goes_to_light(self) -> bool {
        matches!(self, Self::Shadow | Self::SoftShadow | Self::ReflectionShadow | Self::DiffuseShadow)
    }
}

/// A set of rays: at most one for each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RaySetId {
    /// What its rays are for.
    pub kind: RayKind,
    /// Which sample of its pixel each ray is, from 0; 0 for kinds that are not drawn at random.
    pub sample: u32,
    /// To which light, from 0, its rays go; 0 for kinds that go to none.
    pub light: u32,
}

impl RaySetId {
    /// The primary rays.
    pub const PRIMARY: Self = Self { kind: RayKind::Primary, sample: 0, light: 0 };

    /// Hard shadow rays to a light.
    pub fn shadow(light: u32) -> Self {
        Self { kind: RayKind::Shadow, sample: 0, light }
    }

    /// Of `sets`, the place of the one from whose hits this one's rays start; none where it is not among them, as in a list of reflection rays
    /// ([`ReflectionTracer`](crate::reflections::ReflectionTracer)), of which every ray is due.
    pub fn source(self, sets: &[Self]) -> Option<usize> {
        let kind = self.kind.starts_from()?;
        let sample = if kind == RayKind::Primary { 0 } else { self.sample };
        sets.iter().position(|set| set.kind == kind && set.sample == sample)
    }

    /// Whether the rays of this set can be told from rays that were not cast by their steps and the hits of [`Self::source`] alone.
    pub(crate) fn is_plain(self) -> bool {
        matches!(self.kind, RayKind::Primary | RayKind::Shadow)
    }
}

/// Says why these cannot be the ray sets of a trace.
pub(crate) fn check(sets: &[RaySetId]) -> Result<(), String> {
    if sets.is_empty() || sets.len() > MAX_RAY_SETS {
        return Err(format!("{} ray sets, 1 to {MAX_RAY_SETS} expected", sets.len()));
    }
    for (place, set) in sets.iter().enumerate() {
        if !set.is_plain() && set.source(&sets[..place]).is_none() {
            let RaySetId { kind, sample, .. } = set;
            return Err(format!(
                "{} rays of sample {sample} without the rays before them from whose hits they start",
                kind.name()
            ));
        }
    }
    Ok(())
}

/// A ray set as it stands in a header.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Written {
    Plain(Plain),
    Numbered(Numbered),
}

/// The kinds that the first traces had. Sets of shadow rays go to the lights in order.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Plain {
    Primary,
    Shadow,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Numbered {
    kind: RayKind,
    sample: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    light: Option<u32>,
}

/// Writes `sets` as a header has them: names for primary and hard shadow rays, tables for all others.
pub(crate) fn serialize<S: Serializer>(sets: &[RaySetId], serializer: S) -> Result<S::Ok, S::Error> {
    let written = sets.iter().map(|&RaySetId { kind, sample, light }| match kind {
        RayKind::Primary => Written::Plain(Plain::Primary),
        RayKind::Shadow => Written::Plain(Plain::Shadow),
        _ => Written::Numbered(Numbered { kind, sample, light: kind.goes_to_light().then_some(light) }),
    });
    serializer.collect_seq(written)
}

/// Reads what [`serialize`] writes.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<RaySetId>, D::Error> {
    let mut lights = 0;
    let set = |written: Written| match written {
        Written::Plain(Plain::Primary) => Ok(RaySetId::PRIMARY),
        Written::Plain(Plain::Shadow) => {
            lights += 1;
            Ok(RaySetId::shadow(lights - 1))
        }
        Written::Numbered(Numbered { kind, sample, light }) => {
            let plain = matches!(kind, RayKind::Primary | RayKind::Shadow);
            if plain || light.is_some() != kind.goes_to_light() {
                return Err(serde::de::Error::custom(format!(
                    "a set of {} rays {}",
                    kind.name(),
                    if plain {
                        "as a table, its name alone expected"
                    } else {
                        "with a light where it has none, or without"
                    }
                )));
            }
            Ok(RaySetId { kind, sample, light: light.unwrap_or(0) })
        }
    };
    Vec::<Written>::deserialize(deserializer)?.into_iter().map(set).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Header(#[serde(with = "super")] Vec<RaySetId>);

    fn id(kind: RayKind, sample: u32, light: u32) -> RaySetId {
        RaySetId { kind, sample, light }
    }

    #[test]
    fn old_sets_are_names_and_new_ones_tables() {
        let sets = vec![
            RaySetId::PRIMARY,
            RaySetId::shadow(0),
            RaySetId::shadow(1),
            id(RayKind::SoftShadow, 2, 1),
            id(RayKind::AmbientOcclusion, 3, 0),
        ];
        let text = r#"["primary","shadow","shadow",{"kind":"soft-shadow","sample":2,"light":1},{"kind":"ambient-occlusion","sample":3}]"#;
        assert_eq!(serde_json::to_string(&Header(sets.clone())).expect("it becomes JSON"), text);
        assert_eq!(serde_json::from_str::<Header>(text).expect("it is read"), Header(sets));
    }

    #[test]
    fn tables_that_contradict_their_kind_are_refused() {
        for text in [
            r#"[{"kind":"primary","sample":0}]"#,
            r#"[{"kind":"shadow","sample":0,"light":0}]"#,
            r#"[{"kind":"soft-shadow","sample":0}]"#,
            r#"[{"kind":"diffuse","sample":0,"light":0}]"#,
            r#"[{"kind":"diffuse"}]"#,
            r#"[{"kind":"diffuse","sample":-1}]"#,
            r#"[{"kind":"diffuse","sample":0,"pixel":0}]"#,
            r#"["diffuse"]"#,
        ] {
            assert!(serde_json::from_str::<Header>(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sets_follow_those_from_whose_hits_they_start() {
        let (reflection, shadow) = (id(RayKind::Reflection, 1, 0), id(RayKind::ReflectionShadow, 1, 0));
        assert_eq!(check(&[RaySetId::PRIMARY, reflection, shadow]), Ok(()));
        assert_eq!(shadow.source(&[RaySetId::PRIMARY, reflection]), Some(1));
        assert_eq!(reflection.source(&[RaySetId::PRIMARY]), Some(0));
        for wrong in [&[RaySetId::PRIMARY, shadow, reflection][..], &[reflection], &[]] {
            assert!(check(wrong).is_err(), "{wrong:?}");
        }
        let other_sample = id(RayKind::ReflectionShadow, 0, 0);
        assert!(check(&[RaySetId::PRIMARY, reflection, other_sample]).is_err());
        let most = vec![RaySetId::PRIMARY; MAX_RAY_SETS];
        assert_eq!(check(&most), Ok(()));
        assert!(check(&[&most[..], &most[..1]].concat()).is_err());
    }
}
