//! What varies between the frames of a comparison: axes, their values, and the options that each value stands for.

use crate::args::{FrameArgs, MachineArgs};
use crate::ray_sets;
use anyhow::{anyhow, bail};
use gpumodel::ordering::AtomicStrategy;
use gpumodel::{
    GPUS, HitShading, Launch, NodeOrder, NodeRecords, PrimitiveLayout, PrimitiveOrder, QueryOrigin,
    RayScheduling, ScreenSpace, SecondaryQuery, TECHNIQUES,
};
use scenes::Feature;
use tracer::wide::NodeFormat;
use tracer::{Accel, AlphaMode, MicromapFormat, Query, Traversal};

/// Costs Ct and Ci of Sousa et al. 2019: the chosen ones, and around them the three that their charts compare them with.
const COSTS: [&str; 4] = ["3:1.5", "3.5:1", "1.5:3", "1:3.5"];
/// Both axes of the fine grid of costs.
const FINE_COSTS: [&str; 6] = ["0.5", "1", "1.5", "2", "3", "4"];
/// Bins that are compared unless told otherwise.
const BINNINGS: [&str; 5] = ["none", "sign", "octahedral-4x4", "position-2", "position-sign-1"];
/// Most variants of one comparison.
const MOST_VARIANTS: usize = 1000;

/// What can vary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    Traversal,
    CtCi,
    ShortStack,
    NodeFormat,
    RaySets,
    Force,
    Spp,
    ShadowQuery,
    Alpha,
    MicromapLevel,
    Gpu,
    Technique,
    Layout,
    PrimitiveOrder,
    NodeRecords,
    NodeOrder,
    RayUnit,
    ScreenSpace,
    Launch,
    Binning,
    QueryOrigin,
    HitShading,
    SecondaryQuery,
    Payload,
    Materials,
    Atomics,
    /// A figure of the GPU's description, by its dotted key.
    Figure(String),
}

/// An axis with its values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Variation {
    pub(crate) axis: Axis,
    pub(crate) values: Vec<String>,
}

/// One frame of a comparison.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    /// A value for each axis.
    pub(crate) values: Vec<String>,
    pub(crate) frame: FrameArgs,
    pub(crate) machine: MachineArgs,
}

impl Axis {
    const NAMED: [Self; 26] = [
        Self::Traversal,
        Self::CtCi,
        Self::ShortStack,
        Self::NodeFormat,
        Self::RaySets,
        Self::Force,
        Self::Spp,
        Self::ShadowQuery,
        Self::Alpha,
        Self::MicromapLevel,
        Self::Gpu,
        Self::Technique,
        Self::Layout,
        Self::PrimitiveOrder,
        Self::NodeRecords,
        Self::NodeOrder,
        Self::RayUnit,
        Self::ScreenSpace,
        Self::Launch,
        Self::Binning,
        Self::QueryOrigin,
        Self::HitShading,
        Self::SecondaryQuery,
        Self::Payload,
        Self::Materials,
        Self::Atomics,
    ];

    /// The axis of that name, or of that figure of the GPU.
    pub(crate) fn named(name: &str) -> anyhow::Result<Self> {
        if let Some(axis) = Self::NAMED.into_iter().find(|axis| axis.name() == name) {
            return Ok(axis);
        }
        if name.contains('.') {
            return Ok(Self::Figure(name.to_owned()));
        }
        bail!(
            "--vary {name}: no such axis; use: {}, or a figure of the GPU such as cache.uche.size=65536+131072",
            Self::NAMED.map(|axis| axis.name().to_owned()).join(", ")
        )
    }

    /// Its name on the command line.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Traversal => "traversal",
            Self::CtCi => "ct-ci",
            Self::ShortStack => "short-stack",
            Self::NodeFormat => "node-format",
            Self::RaySets => "ray-sets",
            Self::Force => "force",
            Self::Spp => "spp",
            Self::ShadowQuery => "shadow-query",
            Self::Alpha => "alpha",
            Self::MicromapLevel => "micromap-level",
            Self::Gpu => "gpu",
            Self::Technique => "technique",
            Self::Layout => "layout",
            Self::PrimitiveOrder => "primitive-order",
            Self::NodeRecords => "node-records",
            Self::NodeOrder => "node-order",
            Self::RayUnit => "ray-unit",
            Self::ScreenSpace => "screen-space",
            Self::Launch => "launch",
            Self::Binning => "binning",
            Self::QueryOrigin => "query-origin",
            Self::HitShading => "hit-shading",
            Self::SecondaryQuery => "secondary-query",
            Self::Payload => "payload",
            Self::Materials => "materials",
            Self::Atomics => "atomics",
            Self::Figure(key) => key,
        }
    }

    /// The values that it takes unless told otherwise.
    fn all(&self) -> anyhow::Result<Vec<String>> {
        let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        Ok(match self {
            Self::Traversal => Traversal::ALL.map(traversal_name).into(),
            Self::CtCi => owned(&COSTS),
            Self::ShortStack => owned(&["0", "1", "2", "4"]),
            Self::NodeFormat => owned(&NodeFormat::ALL.map(NodeFormat::name)),
            Self::RaySets => owned(&ray_sets::names()),
            Self::Force => owned(&Feature::ALL.map(Feature::name)),
            Self::Spp => owned(&["1", "2", "4"]),
            Self::ShadowQuery => owned(&Query::ALL.map(Query::name)),
            Self::Alpha => owned(&AlphaMode::ALL.map(AlphaMode::name)),
            Self::MicromapLevel => (0..=MicromapFormat::MAX_LEVEL).map(|level| level.to_string()).collect(),
            Self::Gpu => GPUS.iter().map(|gpu| gpu.name.to_owned()).collect(),
            Self::Technique => TECHNIQUES.iter().map(|technique| technique.name.to_owned()).collect(),
            Self::Layout => owned(&PrimitiveLayout::ALL.map(PrimitiveLayout::name)),
            Self::PrimitiveOrder => owned(&PrimitiveOrder::ALL.map(PrimitiveOrder::name)),
            Self::NodeRecords => owned(&NodeRecords::ALL.map(NodeRecords::name)),
            Self::NodeOrder => owned(&NodeOrder::ALL.map(NodeOrder::name)),
            Self::RayUnit => std::iter::once("none")
                .chain(RayScheduling::ALL.map(RayScheduling::name))
                .map(str::to_owned)
                .collect(),
            Self::ScreenSpace => owned(&ScreenSpace::ALL.map(ScreenSpace::name)),
            Self::Launch => owned(&Launch::ALL.map(Launch::name)),
            Self::Binning => owned(&BINNINGS),
            Self::QueryOrigin => owned(&QueryOrigin::ALL.map(QueryOrigin::name)),
            Self::HitShading => owned(&HitShading::ALL.map(HitShading::name)),
            Self::SecondaryQuery => owned(&SecondaryQuery::ALL.map(SecondaryQuery::name)),
            Self::Payload => owned(&["16", "32", "64", "128"]),
            Self::Materials => owned(&["1", "4", "8", "9", "32", "128"]),
            Self::Atomics => owned(&AtomicStrategy::ALL.map(AtomicStrategy::name)),
            Self::Figure(key) => {
                bail!("--vary {key}: a figure of the GPU needs values, such as {key}=64+128")
            }
        })
    }

    /// Puts one of its values into the options.
    pub(crate) fn apply(
        &self,
        value: &str,
        frame: &mut FrameArgs,
        machine: &mut MachineArgs,
    ) -> anyhow::Result<()> {
        let given = Some(value.to_owned());
        match self {
            Self::Traversal => {
                let traversal =
                    Traversal::ALL.into_iter().find(|&traversal| traversal_name(traversal) == value);
                let Some(traversal) = traversal else {
                    bail!(
                        "--vary traversal={value}: no such one; use: {}",
                        Traversal::ALL.map(traversal_name).join(", ")
                    );
                };
                frame.accel = Some(traversal.accel().name().to_owned());
                frame.traversal = Some(traversal.name().to_owned());
            }
            Self::CtCi => {
                let costs = value.split_once(':');
                let parsed = costs.and_then(|(ct, ci)| Some((ct.parse().ok()?, ci.parse().ok()?)));
                let Some((ct, ci)) = parsed else {
                    bail!("--vary ct-ci={value}: expected Ct:Ci, such as 3:1.5, or fine");
                };
                (frame.ct, frame.ci) = (Some(ct), Some(ci));
            }
            Self::ShortStack => {
                let entries = value.parse();
                frame.short_stack = Some(entries.map_err(|_| {
                    anyhow!("--vary short-stack={value}: expected a number of entries, such as 4")
                })?);
            }
            Self::NodeFormat => frame.node_format = given,
            Self::RaySets => frame.ray_sets = several("ray-sets", value, &ray_sets::names())?,
            Self::Force => frame.force = several("force", value, &Feature::ALL.map(Feature::name))?,
            Self::Spp => {
                let samples = value.parse();
                frame.spp = Some(samples.map_err(|_| {
                    anyhow!("--vary spp={value}: expected a number of rays per pixel, such as 2")
                })?);
            }
            Self::ShadowQuery => frame.shadow_query = given,
            Self::Alpha => frame.alpha = given,
            Self::MicromapLevel => {
                let level = value.parse().ok().filter(|&level| level <= MicromapFormat::MAX_LEVEL);
                frame.micromap_level = Some(level.ok_or_else(|| {
                    anyhow!(
                        "--vary micromap-level={value}: expected a level from 0 to {}",
                        MicromapFormat::MAX_LEVEL
                    )
                })?);
            }
            Self::Gpu => machine.gpu = given,
            Self::Technique => machine.technique = given,
            Self::Layout => machine.layout = given,
            Self::PrimitiveOrder => machine.primitive_order = given,
            Self::NodeRecords => machine.node_records = given,
            Self::NodeOrder => machine.node_order = given,
            Self::RayUnit => machine.ray_unit = given,
            Self::ScreenSpace => machine.reflections.screen_space = given,
            Self::Launch => machine.reflections.launch = given,
            Self::Binning => machine.reflections.binning = given,
            Self::QueryOrigin => machine.reflections.query_origin = given,
            Self::HitShading => machine.reflections.hit_shading = given,
            Self::SecondaryQuery => machine.reflections.secondary_query = given,
            Self::Payload => machine.reflections.payload = given,
            Self::Materials => machine.reflections.materials = given,
            Self::Atomics => machine.reflections.atomics = given,
            Self::Figure(key) => machine.set.push(format!("{key}={value}")),
        }
        Ok(())
    }
}

/// Names that a value joins by colons.
fn several(axis: &str, value: &str, known: &[&str]) -> anyhow::Result<Vec<String>> {
    let names: Vec<String> = value.split(':').map(str::to_owned).collect();
    if names.iter().all(|name| known.contains(&name.as_str())) {
        return Ok(names);
    }
    bail!("--vary {axis}={value}: expected one of {}, or several joined by colons", known.join(", "))
}

/// `bvh-stack` and the like.
pub(crate) fn traversal_name(traversal: Traversal) -> String {
    format!("{}-{}", traversal.accel().name(), traversal.name())
}

impl Variation {
    /// Reads `AXIS` or `AXIS=VALUE+VALUE`.
    pub(crate) fn parse(text: &str) -> anyhow::Result<Self> {
        let (name, values) = text.split_once('=').map_or((text, None), |(name, values)| (name, Some(values)));
        let axis = Axis::named(name)?;
        let values = match values {
            None => axis.all()?,
            Some("fine") if axis == Axis::CtCi => FINE_COSTS
                .iter()
                .flat_map(|ct| FINE_COSTS.iter().map(move |ci| format!("{ct}:{ci}")))
                .collect(),
            Some(values) => values.split('+').map(str::to_owned).collect(),
        };
        Self::distinct(axis, values, &format!("--vary {text}"))
    }

    /// Reads `KEY=VALUE+VALUE` of a figure of the GPU.
    pub(crate) fn of_figure(text: &str) -> anyhow::Result<Self> {
        let Some((key, values)) = text.split_once('=') else {
            bail!("--set {text}: expected KEY=V+V, such as cache.uche.line=64+128");
        };
        let values = values.split('+').map(str::to_owned).collect();
        Self::distinct(Axis::Figure(key.trim().to_owned()), values, &format!("--set {text}"))
    }

    /// An axis with values that all differ; `given` is how they stand on the command line.
    pub(crate) fn distinct(axis: Axis, values: Vec<String>, given: &str) -> anyhow::Result<Self> {
        let mut sorted = values.clone();
        sorted.sort_unstable();
        sorted.dedup();
        if sorted.len() < values.len() || values.iter().any(String::is_empty) {
            bail!("{given}: a value is empty or given twice; give each once");
        }
        Ok(Self { axis, values })
    }

    /// Every combination of the values of all variations, the last varying fastest.
    ///
    /// # Errors
    /// When an axis is given twice, there are too many combinations, or a value does not fit its axis.
    pub(crate) fn points(
        variations: &[Self],
        frame: &FrameArgs,
        machine: &MachineArgs,
    ) -> anyhow::Result<Vec<Point>> {
        for (index, variation) in variations.iter().enumerate() {
            if variations[..index].iter().any(|other| other.axis == variation.axis) {
                bail!("--vary {}: given twice; give it once, its values joined by +", variation.axis.name());
            }
        }
        let count = variations.iter().try_fold(1_usize, |count, v| count.checked_mul(v.values.len()));
        if count.is_none_or(|count| count > MOST_VARIANTS) {
            bail!("--vary: more than {MOST_VARIANTS} combinations; vary fewer axes, or give fewer values");
        }
        let mut points = vec![Point { values: Vec::new(), frame: frame.clone(), machine: machine.clone() }];
        for Self { axis, values } in variations {
            let mut next = Vec::with_capacity(points.len() * values.len());
            for point in &points {
                for value in values {
                    let mut point = point.clone();
                    axis.apply(value, &mut point.frame, &mut point.machine)?;
                    point.values.push(value.clone());
                    next.push(point);
                }
            }
            points = next;
        }
        Ok(points)
    }
}

/// Why a combination has no meaning, such as a short stack for a traversal without one.
pub(crate) fn meaningless(point: &Point) -> Option<&'static str> {
    let accel = point.frame.accel.as_deref().unwrap_or("bvh");
    let traversal = point.frame.traversal.as_deref().unwrap_or("stack");
    let pairs = accel == "bvh" && traversal != "parent-link";
    let has_short_stack = matches!(traversal, "restart-trail" | "push-down" | "short-stack");
    let may_be_wide = [Accel::WideBvh, Accel::TwoLevel].map(Accel::name).contains(&accel);
    let is_wide = accel == Accel::WideBvh.name()
        || (may_be_wide && (point.frame.node_format.is_some() || traversal == "short-stack"));
    let of_machine = |value: &Option<String>, name: &str| value.as_deref() == Some(name);
    let unit = point.machine.ray_unit.as_deref().and_then(RayScheduling::from_name);
    let is_adreno_8 =
        point.frame.node_format.as_deref().is_none_or(|name| name == NodeFormat::Adreno8.name());
    let has_instruction = traversal == "short-stack" && is_adreno_8;
    let FrameArgs { ct, ci, node_format, trail_bits, splits, flat_cells, empty_bonus, max_depth, .. } =
        &point.frame;
    let of_kd = splits.is_some() || flat_cells.is_some() || empty_bonus.is_some() || max_depth.is_some();
    if accel == "grid" && (ct.is_some() || ci.is_some()) {
        Some("a grid is not built by costs")
    } else if of_machine(&point.machine.node_records, NodeRecords::ChildBoxes.name()) && !pairs {
        Some("only traversals that test siblings together have the boxes of both children in one record")
    } else if node_format.is_some() && !may_be_wide {
        Some("only nodes of wide BVHs have a format")
    } else if is_wide && of_machine(&point.machine.node_order, NodeOrder::VanEmdeBoas.name()) {
        Some("it parts the children of a wide node, which follow each other")
    } else if unit.is_some() && !is_wide {
        Some("ray units walk wide BVHs alone")
    } else if unit == Some(RayScheduling::Instruction) && !has_instruction {
        Some("the instruction of a ray unit tests nodes of adreno-8 for --traversal short-stack")
    } else if point.frame.short_stack.is_some() && !has_short_stack {
        Some("only restart-trail, push-down and short-stack have a short stack")
    } else if trail_bits.is_some() && traversal != "restart-trail" {
        Some("only restart-trail has a trail")
    } else if of_kd && accel != "kd" {
        Some("only kd-trees are built with these options")
    } else if traversal == "backtrack" && flat_cells.as_deref() == Some("allowed") {
        Some("backtracking cannot leave a cell without thickness")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(variations: &[&str]) -> anyhow::Result<Vec<Point>> {
        let variations =
            variations.iter().map(|text| Variation::parse(text)).collect::<anyhow::Result<Vec<_>>>()?;
        Variation::points(&variations, &FrameArgs::default(), &MachineArgs::default())
    }

    #[test]
    fn every_axis_varies_over_all_its_values_by_its_name_alone() {
        for axis in Axis::NAMED {
            let all = points(&[axis.name()]).expect("it has values");
            assert!(!all.is_empty(), "{axis:?}");
        }
        assert_eq!(points(&["ct-ci=fine"]).expect("it is known").len(), 36);
    }

    #[test]
    fn the_last_axis_varies_fastest() {
        let all = points(&["layout=padded+split", "cache.uche.line=64+128"]).expect("they are known");
        let values: Vec<String> = all.iter().map(|point| point.values.join(" ")).collect();
        assert_eq!(values, ["padded 64", "padded 128", "split 64", "split 128"]);
        assert_eq!(all[3].machine.set, ["cache.uche.line=128"]);
        assert_eq!(all[3].machine.layout.as_deref(), Some("split"));
    }

    #[test]
    fn what_cannot_vary_is_refused() {
        for (texts, expected) in [
            (&["colour"][..], "no such axis; use: traversal"),
            (&["cache.uche.line"], "needs values"),
            (&["layout=split+split"], "given twice"),
            (&["layout=split+"], "empty"),
            (&["layout", "layout=split"], "given twice"),
            (&["traversal=bvh-zigzag"], "no such one; use: bvh-stack"),
            (&["ct-ci=3"], "expected Ct:Ci"),
            (&["short-stack=few"], "expected a number"),
            (&["ct-ci=fine", "traversal", "layout", "technique"], "more than 1000 combinations"),
        ] {
            let message = points(texts).expect_err("it is wrong").to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn combinations_without_meaning_are_told() {
        let told = |texts: &[&str]| meaningless(&points(texts).expect("known")[0]).is_some();
        assert!(told(&["traversal=grid-dda", "ct-ci=3:1.5"]) && !told(&["traversal=grid-dda"]));
        assert!(told(&["traversal=bvh-parent-link", "node-records=child-boxes"]));
        assert!(!told(&["traversal=bvh-restart-trail", "node-records=child-boxes", "short-stack=4"]));
        assert!(told(&["traversal=kd-backtrack", "short-stack=4"]));
        assert!(!told(&["traversal=wide-bvh-short-stack", "short-stack=4", "ray-unit=instruction"]));
        assert!(told(&["traversal=wide-bvh-stack", "ray-unit=instruction"]));
        assert!(told(&["traversal=two-level-stack", "ray-unit=warp"]));
        assert!(!told(&["traversal=two-level-stack", "node-format=full-4", "ray-unit=warp"]));
        assert!(!told(&["traversal=two-level-short-stack", "ray-unit=instruction"]));
        assert!(told(&["traversal=two-level-short-stack", "node-order=van-emde-boas"]));
        assert!(told(&["traversal=wide-bvh-short-stack", "node-format=full-4", "ray-unit=instruction"]));
    }
}
