//! Holds claims against measurements.

use super::finding::Finding;
use super::measurements::Measurements;
use super::model::{Case, Claim, ClaimSet, Metric, Quantifier, Setup, Test, Variant};
use super::rule::Rule;
use super::verdict::{Figure, Outcome, ReadingVerdict, Verdict};
use std::collections::{BTreeMap, BTreeSet};

/// The reading that is added wherever a stand-in took part.
const WITHOUT_STAND_INS: &str = "without stand-ins";

/// Tests held against measurements.
struct Tested {
    outcome: Outcome,
    ours: Option<String>,
    why: String,
    error: Option<f64>,
    stand_ins: BTreeSet<String>,
    figures: Vec<Figure>,
}

impl ClaimSet {
    /// Every setup that some test or reading needs, with the ids of the metrics it needs from it.
    pub fn needs(&self) -> BTreeMap<Setup, BTreeSet<String>> {
        let mut needs: BTreeMap<Setup, BTreeSet<String>> = BTreeMap::new();
        for claim in &self.claims {
            let readings = claim.readings.iter().flat_map(|reading| &reading.tests);
            for test in claim.tests.iter().chain(readings) {
                for case in &test.cases {
                    let mut note = |scene: &str, variant: &Variant, metric: &Metric| {
                        let ids = std::iter::once(&metric.id).chain(&metric.over).cloned();
                        needs.entry(test.setup(scene, case, variant)).or_default().extend(ids);
                        Ok(1.0)
                    };
                    // The figures mean nothing here: only which of them a rule asks for.
                    let _ = test.rule.columns(case, &mut note);
                }
            }
        }
        needs
    }

    /// The distinct setups, in order.
    pub fn setups(&self) -> Vec<Setup> {
        self.needs().into_keys().collect()
    }

    /// Holds every claim against what was measured, in file order.
    pub fn evaluate(&self, measurements: &Measurements) -> Vec<Verdict> {
        self.claims.iter().map(|claim| claim.evaluate(measurements)).collect()
    }
}

impl Claim {
    fn evaluate(&self, measurements: &Measurements) -> Verdict {
        let main = evaluate(&self.tests, measurements, true);
        let mut readings: Vec<ReadingVerdict> = self
            .readings
            .iter()
            .map(|reading| verdict(&reading.name, &reading.why, evaluate(&reading.tests, measurements, true)))
            .collect();
        if !main.stand_ins.is_empty() {
            let assumption = "only scenes of the paper itself can contradict it";
            let tested = evaluate(&self.tests, measurements, false);
            readings.push(verdict(WITHOUT_STAND_INS, assumption, tested));
        }
        Verdict {
            id: self.id.clone(),
            statement: self.statement.clone(),
            place: self.place.clone(),
            kind: self.kind,
            outcome: main.outcome,
            ours: main.ours,
            published: self.published.clone(),
            error: main.error,
            why: main.why,
            note: self.note.clone(),
            untested: self.untested.clone(),
            readings,
            stand_ins: main.stand_ins.into_iter().collect(),
            figures: main.figures,
        }
    }
}

fn verdict(name: &str, assumption: &str, tested: Tested) -> ReadingVerdict {
    let Tested { outcome, ours, why, .. } = tested;
    ReadingVerdict { name: name.to_owned(), assumption: assumption.to_owned(), outcome, ours, why }
}

/// All tests together: one that fails decides, else one that is undecided.
fn evaluate(tests: &[Test], measurements: &Measurements, with_stand_ins: bool) -> Tested {
    let all: Vec<Tested> = tests.iter().map(|test| test.evaluate(measurements, with_stand_ins)).collect();
    let outcome = [Outcome::NotReproduced, Outcome::Untestable]
        .into_iter()
        .find(|outcome| all.iter().any(|tested| tested.outcome == *outcome))
        .unwrap_or(Outcome::Reproduced);
    let deciding: Vec<&Tested> = all.iter().filter(|tested| tested.outcome == outcome).collect();
    let held = all.iter().filter(|tested| tested.outcome == Outcome::Reproduced).count();
    let mut why = deciding.iter().map(|tested| tested.why.as_str()).collect::<Vec<_>>().join("; ");
    if outcome != Outcome::Reproduced && all.len() > 1 {
        why += &format!("; {held} of {} tests hold", all.len());
    }
    let ours: Vec<&str> = all.iter().filter_map(|tested| tested.ours.as_deref()).collect();
    let ours = (!ours.is_empty()).then(|| ours.join("; "));
    let error = all.iter().filter_map(|tested| tested.error).max_by(|a, b| a.abs().total_cmp(&b.abs()));
    let mut figures: Vec<Figure> = Vec::new();
    for figure in all.iter().flat_map(|tested| &tested.figures) {
        if !figures.contains(figure) {
            figures.push(figure.clone());
        }
    }
    let stand_ins = all.iter().flat_map(|tested| tested.stand_ins.clone()).collect();
    Tested { outcome, ours, why, error, stand_ins, figures }
}

impl Test {
    fn evaluate(&self, measurements: &Measurements, with_stand_ins: bool) -> Tested {
        if let Rule::Untestable { reason } = &self.rule {
            return untestable(reason.clone());
        }
        let with_stand_ins = with_stand_ins && !self.rule.needs_own_scene();
        let stand_ins_of = |case: &Case| {
            let from = match &self.rule {
                Rule::Shift { from, .. } => Some(from),
                _ => None,
            };
            let scenes = std::iter::once(&case.scene).chain(from);
            scenes
                .filter_map(|scene| Some(format!("{scene}: {}", measurements.stand_in_of(scene)?)))
                .collect::<BTreeSet<_>>()
        };
        let (cases, left_out): (Vec<&Case>, Vec<&Case>) =
            self.cases.iter().partition(|case| with_stand_ins || stand_ins_of(case).is_empty());
        let left_out: BTreeSet<String> = left_out.into_iter().flat_map(stand_ins_of).collect();
        if cases.is_empty() {
            let names: Vec<String> = left_out.into_iter().collect();
            return untestable(format!(
                "measured on stand-ins only, which do not count ({})",
                names.join(", ")
            ));
        }
        let stand_ins = cases.iter().flat_map(|case| stand_ins_of(case)).collect();
        let mut figures = Vec::new();
        let mut columns = Vec::new();
        let mut missing = Vec::new();
        for case in &cases {
            let mut look = |scene: &str, variant: &Variant, metric: &Metric| {
                let value = read(self, measurements, scene, case, variant, metric)?;
                figures.push(Figure {
                    scene: scene.to_owned(),
                    each: case.each.as_ref().map(|each| each.name.clone()),
                    variant: variant.name.clone(),
                    metric: metric.to_string(),
                    value,
                });
                Ok(value)
            };
            match self.rule.columns(case, &mut look) {
                Ok(found) => columns.push(found),
                Err(reason) => missing.push(reason),
            }
        }
        if let Some(reason) = missing.first() {
            let more = match missing.len() - 1 {
                0 => String::new(),
                more => format!(" (and {more} more of {} cases)", cases.len()),
            };
            return Tested { stand_ins, figures, ..untestable(format!("{reason}{more}")) };
        }
        let (outcome, deciding, share) = self.decide(&cases, &columns);
        let mut why = format!("{}; wanted {}", deciding.figures, self.rule.wanted());
        why += &share;
        if self.rule.needs_own_scene() && !left_out.is_empty() {
            let names: Vec<String> = left_out.into_iter().collect();
            why += &format!("; not counted: {}", names.join(", "));
        }
        let ours = match self.rule.needs_own_scene() {
            true => cases
                .iter()
                .zip(&columns)
                .map(|(case, columns)| format!("{case} {}", crate::units::digits(columns[0])))
                .collect::<Vec<_>>()
                .join(", "),
            false => deciding.figures.clone(),
        };
        Tested { outcome, ours: Some(ours), why, error: deciding.error, stand_ins, figures }
    }

    /// The outcome, the case that decides it (the one nearest to another outcome, or farthest beyond), and in how many
    /// cases the rule holds.
    fn decide(&self, cases: &[&Case], columns: &[Vec<f64>]) -> (Outcome, Finding, String) {
        let outcome = |holds| if holds { Outcome::Reproduced } else { Outcome::NotReproduced };
        if self.holds == Quantifier::Mean {
            let place = match cases {
                [case] => case.to_string(),
                _ => format!("the mean of {} cases", cases.len()),
            };
            let finding = self.rule.judge(&means(columns, self.rule.has_geometric_mean()), &place);
            return (outcome(finding.holds()), finding, String::new());
        }
        let findings: Vec<Finding> = cases
            .iter()
            .zip(columns)
            .map(|(case, columns)| self.rule.judge(columns, &case.to_string()))
            .collect();
        let held = findings.iter().filter(|finding| finding.holds()).count();
        let (holds, needed) = match self.holds {
            Quantifier::Majority => (2 * held > findings.len(), ", more than half needed"),
            Quantifier::Some => (held > 0, ", one needed"),
            Quantifier::All | Quantifier::Mean => (held == findings.len(), ""),
        };
        let share = match (findings.len(), needed) {
            (1, "") => String::new(),
            (count, _) => format!("; holds in {held} of {count} cases{needed}"),
        };
        let by_margin = |a: &Finding, b: &Finding| a.margin().total_cmp(&b.margin());
        let deciding = match self.holds {
            Quantifier::Some => findings.into_iter().max_by(by_margin),
            _ => findings.into_iter().min_by(by_margin),
        };
        (outcome(holds), deciding.expect("there is at least one case"), share)
    }
}

fn untestable(why: String) -> Tested {
    let (stand_ins, figures) = (BTreeSet::new(), Vec::new());
    Tested { outcome: Outcome::Untestable, ours: None, why, error: None, stand_ins, figures }
}

fn read(
    test: &Test,
    measurements: &Measurements,
    scene: &str,
    case: &Case,
    variant: &Variant,
    metric: &Metric,
) -> Result<f64, String> {
    let setup = test.setup(scene, case, variant);
    let one = |id: &str| {
        measurements.get(&setup, id).map_err(|reason| {
            let each = case.each.as_ref().map(|each| format!(", {}", each.name)).unwrap_or_default();
            format!("no {id} of {}{each} on {scene}: {reason}", variant.name)
        })
    };
    let above = one(&metric.id)?;
    let Some(over) = &metric.over else { return Ok(above) };
    let below = one(over)?;
    if below > 0.0 {
        Ok(above / below)
    } else {
        Err(format!("no {metric} of {} on {scene}: {over} is 0", variant.name))
    }
}

/// The mean of each column over cases.
fn means(rows: &[Vec<f64>], geometric: bool) -> Vec<f64> {
    let count = rows.len() as f64;
    let width = rows.first().map_or(0, Vec::len);
    (0..width)
        .map(|column| {
            let values = rows.iter().map(|row| row[column]);
            let first = rows[0][column];
            if values.clone().all(|value| value == first) {
                first
            } else if geometric {
                (values.map(f64::ln).sum::<f64>() / count).exp()
            } else {
                values.sum::<f64>() / count
            }
        })
        .collect()
}
