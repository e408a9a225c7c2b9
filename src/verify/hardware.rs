//! Runs the probes of `raybudget verify hardware`.

use crate::console;
use crate::figures::with_figures;
use gpumodel::kernel::{Observation, Pattern};
use gpumodel::{BuiltinGpu, Fidelity, Gpu};
use rayon::prelude::*;
use reports::hardware::{Found, Row, RowVerdict};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Rungs that measure, the judge first, and whether experiments are made.
pub(crate) struct Conditions {
    pub(crate) rungs: Vec<Fidelity>,
    pub(crate) experiments: bool,
}

/// A probe of a row: of the description as it is, or with some figures set.
#[derive(Clone, PartialEq)]
struct Probe<'a> {
    gpu: &'a str,
    set: &'a [String],
    pattern: Pattern,
    fidelity: Fidelity,
}

/// Measures all rows and compares them with what was published.
pub(crate) fn all(rows: &[Row], conditions: &Conditions) -> anyhow::Result<Vec<RowVerdict>> {
    // Rows share probes: a ratio those of its divisor, a knee those of its sizes.
    let mut probes: Vec<Probe<'_>> = Vec::new();
    for (row, fidelity, set) in wanted(rows, conditions) {
        for pattern in row.patterns() {
            let probe = Probe { gpu: &row.gpu, set, pattern, fidelity };
            if !probes.contains(&probe) {
                probes.push(probe);
            }
        }
    }
    let (done, count) = (AtomicUsize::new(0), probes.len());
    let measured: Vec<Observation> = probes
        .par_iter()
        .map(|probe| {
            let observed = measure(probe)?;
            console::status(&format!("probe {} of {count}", done.fetch_add(1, Ordering::Relaxed) + 1));
            Ok(observed)
        })
        .collect::<anyhow::Result<_>>()?;
    let found = |row: &Row, fidelity, set: &[String]| -> Found {
        let observed: Vec<Observation> = row
            .patterns()
            .into_iter()
            .filter_map(|pattern| {
                let probe = Probe { gpu: &row.gpu, set, pattern, fidelity };
                probes.iter().position(|known| *known == probe).map(|place| measured[place].clone())
            })
            .collect();
        row.found(&observed)
    };
    let judge = conditions.rungs[0];
    let verdict = |row: &Row| {
        let others: Vec<(Fidelity, Found)> =
            conditions.rungs[1..].iter().map(|&rung| (rung, found(row, rung, &[]))).collect();
        let experiments = row.experiment.iter().filter(|_| conditions.experiments);
        let tried =
            experiments.map(|of| row.tried(&of.set, &of.meaning, found(row, judge, &of.set))).collect();
        row.judge(found(row, judge, &[]), &others, tried)
    };
    Ok(rows.iter().map(verdict).collect())
}

/// Rows with the rungs and figures that they are measured with.
fn wanted<'a>(
    rows: &'a [Row],
    conditions: &'a Conditions,
) -> impl Iterator<Item = (&'a Row, Fidelity, &'a [String])> {
    rows.iter().flat_map(move |row| {
        let plain = conditions.rungs.iter().map(move |&rung| (row, rung, &[] as &[String]));
        let experiments = row.experiment.iter().filter(|_| conditions.experiments);
        plain.chain(experiments.map(move |of| (row, conditions.rungs[0], of.set.as_slice())))
    })
}

fn measure(probe: &Probe<'_>) -> anyhow::Result<Observation> {
    let Probe { gpu, set, pattern, fidelity } = probe;
    let file = format!("{gpu}.toml");
    let text = BuiltinGpu::named(gpu).map_or("", |builtin| builtin.toml);
    let gpu = Gpu::parse(&with_figures(text, &file, set)?, &file)?;
    Ok(pattern.observe(&gpu, *fidelity)?)
}
