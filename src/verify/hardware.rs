//! Runs the probes of `raybudget verify hardware`.

use crate::console;
use gpumodel::kernel::{Observation, Pattern};
use gpumodel::{BuiltinGpu, Fidelity, Gpu};
use rayon::prelude::*;
use reports::hardware::{self, Found, Row, RowVerdict};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A probe of a row.
#[derive(Clone, PartialEq)]
struct Probe<'a> {
    gpu: &'a str,
    /// Of a row of power.
    interface_gbs: Option<f64>,
    pattern: Pattern,
    fidelity: Fidelity,
}

/// Measures all rows on `rungs`, the judge first, and compares them with what was published.
pub(crate) fn all(rows: &[Row], rungs: &[Fidelity]) -> anyhow::Result<Vec<RowVerdict>> {
    // Rows share probes: a ratio those of its divisor, a knee those of its sizes.
    let mut probes: Vec<Probe<'_>> = Vec::new();
    for (row, &fidelity) in rows.iter().flat_map(|row| rungs.iter().map(move |rung| (row, rung))) {
        for pattern in row.patterns() {
            let probe = probe(row, pattern, fidelity);
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
    let found = |row: &Row, fidelity| -> Found {
        let observed: Vec<Observation> = row
            .patterns()
            .into_iter()
            .filter_map(|pattern| {
                let probe = probe(row, pattern, fidelity);
                probes.iter().position(|known| *known == probe).map(|place| measured[place].clone())
            })
            .collect();
        row.found(&observed)
    };
    let verdict = |row: &Row| {
        let others: Vec<(Fidelity, Found)> =
            rungs[1..].iter().map(|&rung| (rung, found(row, rung))).collect();
        row.judge(found(row, rungs[0]), &others)
    };
    Ok(rows.iter().map(verdict).collect())
}

fn probe(row: &Row, pattern: Pattern, fidelity: Fidelity) -> Probe<'_> {
    Probe { gpu: &row.gpu, interface_gbs: row.interface_gbs, pattern, fidelity }
}

fn measure(probe: &Probe<'_>) -> anyhow::Result<Observation> {
    let Probe { gpu, interface_gbs, pattern, fidelity } = probe;
    let file = format!("{gpu}.toml");
    let text = BuiltinGpu::named(gpu).map_or("", |builtin| builtin.toml);
    let mut gpu = Gpu::parse(text, &file)?;
    if let Some(gbs) = *interface_gbs {
        hardware::set_interface_rate(&mut gpu, gbs)?;
    }
    Ok(pattern.observe(&gpu, *fidelity)?)
}
