//! What a frame rate becomes on a phone that warms: the frame at each clock of the GPU, and the phone under that load.

use crate::args::SustainedArgs;
use crate::machine::Machine;
use crate::output::read_text;
use crate::report::Answer;
use crate::sample::duration;
use anyhow::{anyhow, bail};
use gpumodel::energy::{Domain, EnergyPrices, FrameEnergy, Supply};
use reports::chart::TimeSeriesChart;
use reports::sustained::{self, Sustained};
use thermal::{BUILTIN, LeakageLaw, OperatingPoint, Phone, Run, Settings};

/// A day: a longer load has long settled.
const LONGEST_SECONDS: f64 = 86_400.0;
/// Clocks that differ relatively by no more are the same but for rounding.
const SAME_CLOCK: f64 = 1e-9;

/// A phone, how long it is loaded, and the clocks of the GPU that its governor chooses from.
pub(crate) struct Plan {
    phone: Phone,
    seconds: f64,
    /// The highest first.
    points: Vec<gpumodel::OperatingPoint>,
    /// Clock of the profiled frame.
    frame_hz: f64,
}

/// A load that was followed.
pub(crate) struct Followed {
    pub(crate) section: Sustained,
    /// What stands behind the figures, in sentences.
    pub(crate) assumptions: Vec<String>,
    phone: Phone,
    points: Vec<OperatingPoint>,
    run: Run,
}

impl Plan {
    /// `None` where no time was asked for.
    pub(crate) fn new(args: &SustainedArgs, machine: &Machine) -> anyhow::Result<Option<Self>> {
        let Some(text) = &args.sustained else { return Ok(None) };
        let seconds = duration(text).map(|duration| duration.as_secs_f64());
        let Some(seconds) = seconds.filter(|seconds| *seconds <= LONGEST_SECONDS) else {
            bail!(
                "--sustained {text}: expected a time above 0 and up to a day (1440min) with its unit, one of ms, s and min, such as 10min or 90s"
            );
        };
        let phone = match &args.phone {
            None => Phone::parse(BUILTIN, "configs/thermal/phone.toml")?,
            Some(path) => Phone::parse(
                &read_text(path, "a description of a phone (.toml)")?,
                &path.display().to_string(),
            )?,
        };
        // What would be refused after minutes of replay is refused now.
        phone.check(&Settings::over(seconds)).map_err(|error| anyhow!("--sustained {text}: {error}"))?;
        let gpu = &machine.config.gpu;
        if gpu.energy.is_none() {
            bail!(
                "--sustained {text}: {} names no process, so the energy of its frame is not known; add [energy] to its description",
                gpu.name()
            );
        }
        if gpu.operating_points.is_empty() {
            bail!(
                "--sustained {text}: no clocks of {} are known that a governor could choose from; add [[operating_point]] tables to a copy of its \
                 description, as in configs/gpus/adreno-540.toml, and give that to --gpu",
                gpu.name()
            );
        }
        // The clock of the machine is its highest: so --set clock.mhz=500 asks for a GPU that is never faster.
        let allowed = |point: &&gpumodel::OperatingPoint| point.hz <= gpu.clock.hz * (1.0 + SAME_CLOCK);
        let points: Vec<_> = gpu.operating_points.iter().filter(allowed).copied().collect();
        if points.is_empty() {
            bail!(
                "--sustained {text}: every operating point of {} has a higher clock than its {} MHz; raise clock.mhz or add a lower [[operating_point]]",
                gpu.name(),
                gpu.clock.hz * 1e-6
            );
        }
        // Caps are parts of the highest clock that the description has.
        let phone = phone.with_caps_of(gpu.operating_points[0].hz / points[0].hz);
        Ok(Some(Self { phone, seconds, points, frame_hz: gpu.clock.hz }))
    }

    /// The machine at each of the clocks.
    pub(crate) fn machines(&self, machine: &Machine) -> Vec<Machine> {
        let at_clock = |point: &gpumodel::OperatingPoint| {
            let mut machine = machine.clone();
            machine.config.gpu.clock.hz = point.hz;
            machine
        };
        self.points.iter().map(at_clock).collect()
    }

    /// Follows the load of frames that were replayed at each of the clocks.
    pub(crate) fn follow(self, answers: &[Answer]) -> anyhow::Result<Followed> {
        let Self { phone, seconds, points, frame_hz } = self;
        let energies = answers.iter().map(|answer| answer.energy.as_ref()).collect::<Option<Vec<_>>>();
        let energies = energies.ok_or_else(|| anyhow!("the frame's energy is not known"))?;
        let frames = points.iter().zip(&energies).zip(answers);
        let loads: Vec<_> =
            frames.map(|((point, energy), answer)| load(point, energy, answer.seconds)).collect();
        let volts: Vec<f64> = energies.iter().map(|energy| energy.prices.supply().volts()).collect();
        let run = phone.simulate(&loads, &Settings::over(seconds))?;
        let section = Sustained::new(&phone, &loads, &volts, &run, seconds);
        let mut assumptions = assumptions(&phone, &energies[0].prices);
        let highest_hz = points[0].hz;
        if (highest_hz / frame_hz - 1.0).abs() > SAME_CLOCK {
            assumptions.push(format!(
                "Sustained: the highest operating point has {} MHz, not the {} MHz of the frame whose counters are reported, so its peak is another frame rate.",
                highest_hz * 1e-6,
                frame_hz * 1e-6
            ));
        }
        Ok(Followed { section, assumptions, phone, points: loads, run })
    }
}

/// What frames one after the other take at a clock.
fn load(point: &gpumodel::OperatingPoint, energy: &FrameEnergy, frame_s: f64) -> OperatingPoint {
    let leakage = energy.prices.leakage();
    let celsius = leakage.fitted_from_celsius();
    let of = |domain| energy.of_domain(domain) / frame_s;
    OperatingPoint {
        mhz: point.hz * 1e-6,
        frames_per_second: 1.0 / frame_s,
        gpu_watts: of(Domain::Gpu) + of(Domain::SystemCache),
        dram_watts: of(Domain::Dram),
        leakage: LeakageLaw {
            watts: leakage.watts(energy.prices.supply().volts(), celsius),
            celsius,
            per_kelvin: leakage.growth_per_kelvin(),
        },
    }
}

fn assumptions(phone: &Phone, prices: &EnergyPrices) -> Vec<String> {
    let voltage = match prices.supply() {
        Supply::OperatingPoints(_) => "at its voltage",
        Supply::Process(_) => "at the reference voltage of its process, as the description gives none",
    };
    let leakage = prices.leakage();
    vec![
        format!(
            "Sustained: the frame is replayed at each clock {voltage}, and drawn again as soon as it is done, whatever the display shows. Dynamic energy of the \
             GPU goes with the square of the voltage; leakage is the exponential through the energy table's figures at {} and {} degrees Celsius, whatever the \
             phone. Above these it is an extrapolation: where the GPU settles there, or that it has no balance, is a statement of this law and not of the table's \
             polynomial. The CPU's part of a frame is not in it.",
            leakage.fitted_from_celsius(),
            leakage.fitted_to_celsius(),
        ),
        format!(
            "Sustained: {} figures of the phone are estimates: {}.",
            phone.estimates.len(),
            phone.estimates.join(", ")
        ),
    ]
}

impl Followed {
    /// Frame rate, clock, power and temperatures over time.
    pub(crate) fn chart(&self, subtitle: String) -> TimeSeriesChart {
        sustained::chart(&self.phone, &self.points, &self.run, subtitle)
    }

    /// The series over time, and its chart under a subtitle: names and bytes of files.
    pub(crate) fn files(&self, subtitle: String) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
        let chart = self.chart(subtitle);
        Ok(vec![
            (FILES[0].to_owned(), sustained::csv_text(&self.phone, &self.points, &self.run).into_bytes()),
            (FILES[1].to_owned(), chart.svg()?.into_bytes()),
            (FILES[2].to_owned(), chart.png()?),
        ])
    }
}

/// Names of the files of a load.
pub(crate) const FILES: [&str; 3] = ["sustained.csv", "sustained.svg", "sustained.png"];
