//! Clocks that a GPU can run at, and their voltages.

use super::Gpu;
use super::sourced::{File, Sourced};
use crate::error::Error;
use serde::Deserialize;

/// A clock of a GPU and its supply voltage there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatingPoint {
    /// Cycles per second.
    pub hz: f64,
    /// Supply voltage, where one is given.
    pub volts: Option<f64>,
}

impl Gpu {
    /// Supply voltage at its clock: on a straight line between the operating points on both sides, and that of the outermost one beyond them. `None` where
    /// the description gives no voltages.
    pub fn supply_volts(&self) -> Option<f64> {
        let hz = self.clock.hz;
        let slower = self.operating_points.partition_point(|point| point.hz > hz);
        let above = slower.checked_sub(1).map(|faster| self.operating_points[faster]);
        match (above, self.operating_points.get(slower)) {
            (Some(above), Some(below)) => {
                let (high, low) = (above.volts?, below.volts?);
                Some(low + (high - low) * (hz - below.hz) / (above.hz - below.hz))
            }
            (Some(end), None) => end.volts,
            (None, end) => end?.volts,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OperatingPointFile {
    mhz: Sourced<f64>,
    volts: Option<Sourced<f64>>,
}

/// Clocks fall, and voltages do not rise with falling clocks; either all points have a voltage or none.
pub(super) fn operating_points(
    file: &File<'_>,
    raw: &[OperatingPointFile],
) -> Result<Vec<OperatingPoint>, Error> {
    let mut points: Vec<OperatingPoint> = Vec::new();
    for OperatingPointFile { mhz, volts } in raw {
        let point = OperatingPoint {
            hz: file.within("operating_point.mhz", mhz, 1e-6..=1e7)? * 1e6,
            volts: match volts {
                Some(volts) => Some(file.within("operating_point.volts", volts, 0.1..=2.0)?),
                None => None,
            },
        };
        if let Some(last) = points.last() {
            let problem = if point.hz >= last.hz {
                "is not below the clock of the operating point before it"
            } else if point.volts.is_some() != last.volts.is_some() {
                "has a voltage where others have none, or none where others have one"
            } else if point.volts > last.volts {
                "has a higher voltage than the operating point before it"
            } else {
                points.push(point);
                continue;
            };
            let remedy = "sort operating points by falling clock, each with its voltage or all without";
            return Err(file.refuse("operating_point", &mhz.value.span(), problem, remedy));
        }
        points.push(point);
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use crate::config::Gpu;

    const TEXT: &str = include_str!("../../../configs/gpus/mali-g71.toml");

    fn point(mhz: f64, volts: Option<f64>) -> String {
        let figure = |value: f64| format!("{{ value = {value}, source = \"test\", tag = \"driver\" }}");
        let volts = volts.map_or(String::new(), |volts| format!("volts = {}\n", figure(volts)));
        format!("[[operating_point]]\nmhz = {}\n{volts}\n", figure(mhz))
    }

    fn parse(points: &[(f64, Option<f64>)]) -> Result<Gpu, String> {
        let points: String = points.iter().map(|&(mhz, volts)| point(mhz, volts)).collect();
        Gpu::parse(&format!("{TEXT}\n{points}"), "gpu.toml").map_err(|error| error.to_string())
    }

    #[test]
    fn the_supply_lies_on_lines_between_operating_points_and_stays_beyond_them() {
        let mut gpu = parse(&[(800.0, Some(0.9)), (600.0, Some(0.8)), (300.0, Some(0.65))]).expect("a GPU");
        let expected = [
            (1000.0, 0.9),
            (800.0, 0.9),
            (700.0, 0.85),
            (600.0, 0.8),
            (400.0, 0.7),
            (300.0, 0.65),
            (10.0, 0.65),
        ];
        for (mhz, volts) in expected {
            gpu.clock.hz = mhz * 1e6;
            let found = gpu.supply_volts().expect("it has voltages");
            assert!((found - volts).abs() < 1e-12, "{found} V at {mhz} MHz");
        }
        assert_eq!(parse(&[(600.0, None), (500.0, None)]).expect("a GPU").supply_volts(), None);
        assert_eq!(parse(&[]).expect("a GPU").supply_volts(), None);
    }

    #[test]
    fn points_fall_and_their_voltages_do_not_rise() {
        let gpu = parse(&[(800.0, Some(0.9)), (600.0, Some(0.9)), (300.0, Some(0.7))]).expect("a GPU");
        assert_eq!(gpu.operating_points.len(), 3);
        assert_eq!((gpu.operating_points[2].hz, gpu.operating_points[2].volts), (300e6, Some(0.7)));
        assert!(parse(&[]).expect("a GPU").operating_points.is_empty());
        let refused = |points: &[_]| parse(points).expect_err("refused");
        assert!(refused(&[(600.0, None), (600.0, None)]).contains("not below"));
        assert!(refused(&[(600.0, Some(0.8)), (500.0, None)]).contains("none where others have one"));
        assert!(refused(&[(600.0, Some(0.8)), (500.0, Some(0.81))]).contains("higher voltage"));
        assert!(refused(&[(600.0, Some(8.0))]).contains("0.1 to 2"));
    }
}
