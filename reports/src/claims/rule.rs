//! The rules, and what each reads from the measurements of a case.

use super::model::{Case, Metric, Variant};
use super::rank_correlation::spearman;
use std::collections::BTreeMap;

/// What must hold in a case. Effects are relative: `b` exceeds `a` by `b / a - 1`; negative ones are shortfalls that still
/// count. What equals a limit keeps it.
#[derive(Clone, Debug, PartialEq)]
pub enum Rule {
    /// A metric, or its ratio between two variants, is as published.
    Number {
        /// Of what.
        metric: Metric,
        /// Measured where.
        of: Variant,
        /// And divided by what it is there.
        to: Option<Variant>,
        /// The paper's figure by scene, in the metric's unit.
        figures: BTreeMap<String, f64>,
        /// Largest relative error.
        within: f64,
    },
    /// A metric rises from group to group.
    Order {
        /// Which.
        metric: Metric,
        /// Groups in rising order, two or more.
        ascending: Vec<Vec<Variant>>,
        /// By how much each member exceeds each of the group before.
        effect: f64,
    },
    /// A variant has the smallest or the largest metric.
    Extreme {
        /// Which.
        metric: Metric,
        /// Smallest or largest.
        end: End,
        /// The variant.
        of: Variant,
        /// The others.
        others: Vec<Variant>,
        /// By how much it is beyond the nearest of them.
        effect: f64,
    },
    /// Two variants have nearly the same metric.
    Similar {
        /// Which.
        metric: Metric,
        /// Over
        of: Variant,
        /// this
        to: Variant,
        /// lies between these.
        ratio: [f64; 2],
    },
    /// Two metrics rank the variants alike, or opposite.
    Correlation {
        /// One.
        x: Metric,
        /// The other.
        y: Metric,
        /// The variants, three or more.
        over: Vec<Variant>,
        /// Alike or opposite.
        sign: Sign,
        /// Smallest size of the rank correlation.
        least: f64,
    },
    /// Of several metrics, one ranks the variants most as another does.
    Strongest {
        /// The one.
        x: Metric,
        /// The weaker ones.
        than: Vec<Metric>,
        /// The other.
        y: Metric,
        /// The variants, three or more.
        over: Vec<Variant>,
        /// Alike or opposite.
        sign: Sign,
        /// By how much the rank correlation of `x` exceeds all others and 0; a difference, not a ratio.
        effect: f64,
    },
    /// A metric follows a list of settings.
    Trend {
        /// Which.
        metric: Metric,
        /// The settings in order.
        along: Vec<Variant>,
        /// Where to.
        direction: Direction,
        /// From first to last.
        effect: f64,
    },
    /// The ratio of two variants differs between scenes.
    Shift {
        /// Of what.
        metric: Metric,
        /// Over
        of: Variant,
        /// this,
        to: Variant,
        /// compared with the ratio in this scene.
        from: String,
        /// Where to.
        direction: Direction,
        /// By how much.
        effect: f64,
    },
    /// The ratio of two variants is larger under some variants than under others.
    Contrast {
        /// Of what.
        metric: Metric,
        /// Over
        of: Variant,
        /// this.
        to: Variant,
        /// Where it is small; under each, `of` and `to`.
        lower: Vec<Condition>,
        /// Where it is large.
        higher: Vec<Condition>,
        /// By how much the smallest of `higher` exceeds the largest of `lower`.
        effect: f64,
    },
    /// Two platforms have different best variants.
    Swap {
        /// Which; less is better.
        metric: Metric,
        /// The platforms; on each, the variants in the same order.
        across: Vec<Condition>,
        /// By how much either best one is better at home than the other.
        effect: f64,
    },
    /// A metric keeps a bound.
    Property {
        /// Which.
        metric: Metric,
        /// Measured where.
        of: Variant,
        /// The bound.
        bound: Bound,
    },
    /// No measurement could decide it.
    Untestable {
        /// Why.
        reason: String,
    },
}

/// A variant under which others are compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Condition {
    /// Its name.
    pub name: String,
    /// The others, each with the axes of this one.
    pub among: Vec<Variant>,
}

/// Of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The smallest.
    Least,
    /// The largest.
    Most,
}

/// Of a correlation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Both rise together.
    Positive,
    /// One falls as the other rises.
    Negative,
}

/// Of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Upwards.
    Rising,
    /// Downwards.
    Falling,
}

/// Of a property.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// Exactly this.
    Equals(f64),
    /// This or more.
    AtLeast(f64),
    /// This or less.
    AtMost(f64),
}

impl Sign {
    /// 1 or -1.
    pub(super) fn factor(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }
}

/// Reads the metric of a variant in a scene, or says why it cannot.
pub(super) type Look<'a> = dyn FnMut(&str, &Variant, &Metric) -> Result<f64, String> + 'a;

impl Rule {
    /// Every variant that the rule measures.
    pub fn variants(&self) -> Vec<&Variant> {
        match self {
            Self::Number { of, to, .. } => std::iter::once(of).chain(to).collect(),
            Self::Property { of, .. } => vec![of],
            Self::Order { ascending, .. } => ascending.iter().flatten().collect(),
            Self::Extreme { of, others, .. } => std::iter::once(of).chain(others).collect(),
            Self::Similar { of, to, .. } | Self::Shift { of, to, .. } => vec![of, to],
            Self::Correlation { over, .. } | Self::Strongest { over, .. } => over.iter().collect(),
            Self::Trend { along, .. } => along.iter().collect(),
            Self::Contrast { lower, higher, .. } => {
                lower.iter().chain(higher).flat_map(|condition| &condition.among).collect()
            }
            Self::Swap { across, .. } => across.iter().flat_map(|condition| &condition.among).collect(),
            Self::Untestable { .. } => Vec::new(),
        }
    }

    /// Whether only measurements of the paper's own scene count.
    pub(super) fn needs_own_scene(&self) -> bool {
        matches!(self, Self::Number { .. })
    }

    /// Whether means over cases are geometric; correlations, which may be negative, are averaged as they are.
    pub(super) fn has_geometric_mean(&self) -> bool {
        !matches!(self, Self::Correlation { .. } | Self::Strongest { .. })
    }

    /// The figures of a case that decide it, as [`Rule::judge`] takes them.
    pub(super) fn columns(&self, case: &Case, look: &mut Look<'_>) -> Result<Vec<f64>, String> {
        let scene = case.scene.as_str();
        let mut of_each = |metric: &Metric, variants: &[&Variant]| {
            variants.iter().map(|variant| look(scene, variant, metric)).collect::<Result<Vec<f64>, String>>()
        };
        match self {
            Self::Number { metric, of, to, figures, .. } => {
                let published = figures.get(scene).ok_or("the claim file has no figure for this scene")?;
                let ours = match to {
                    Some(to) => ratio(look, scene, metric, of, to)?,
                    None => look(scene, of, metric)?,
                };
                Ok(vec![ours, *published])
            }
            Self::Order { metric, .. }
            | Self::Extreme { metric, .. }
            | Self::Trend { metric, .. }
            | Self::Swap { metric, .. }
            | Self::Property { metric, .. } => of_each(metric, &self.variants()),
            Self::Similar { metric, of, to, .. } => Ok(vec![ratio(look, scene, metric, of, to)?]),
            Self::Shift { metric, of, to, from, .. } => {
                Ok(vec![ratio(look, from, metric, of, to)?, ratio(look, scene, metric, of, to)?])
            }
            Self::Contrast { metric, .. } => {
                let variants = self.variants();
                let figures = of_each(metric, &variants)?;
                let pairs = figures.chunks(2).zip(variants.chunks(2));
                pairs.map(|(pair, of)| quotient(pair[0], pair[1], metric, of[1], scene)).collect()
            }
            Self::Correlation { x, y, .. } => {
                let variants = self.variants();
                Ok(vec![spearman(&of_each(x, &variants)?, &of_each(y, &variants)?)])
            }
            Self::Strongest { x, than, y, .. } => {
                let variants = self.variants();
                let ys = of_each(y, &variants)?;
                std::iter::once(x).chain(than).map(|x| Ok(spearman(&of_each(x, &variants)?, &ys))).collect()
            }
            Self::Untestable { reason } => Err(reason.clone()),
        }
    }
}

fn ratio(
    look: &mut Look<'_>,
    scene: &str,
    metric: &Metric,
    of: &Variant,
    to: &Variant,
) -> Result<f64, String> {
    let (above, below) = (look(scene, of, metric)?, look(scene, to, metric)?);
    quotient(above, below, metric, to, scene)
}

fn quotient(above: f64, below: f64, metric: &Metric, to: &Variant, scene: &str) -> Result<f64, String> {
    if below > 0.0 {
        Ok(above / below)
    } else {
        Err(format!("{metric} of {} on {scene} is 0, so nothing can be compared with it", to.name))
    }
}
