//! What a frame rate becomes on a phone that warms: the frame at each clock of the GPU, and the phone under that load.

use crate::args::SustainedArgs;
use crate::machine::Machine;
use crate::output::read_text;
use crate::report::Answer;
use crate::sample::duration;
use anyhow::{anyhow, bail};
use gpumodel::energy::{Domain, FrameEnergy};
use reports::chart::TimeSeriesChart;
use reports::sustained::{self, Sustained};
use thermal::{BUILTIN, LeakageLaw, OperatingPoint, Phone, Run, Settings};

/// A day: a longer load has long settled.
const LONGEST_SECONDS: f64 = 86_400.0;

/// A phone, how long it is loaded, and the clocks of the GPU that its governor chooses from.
pub(crate) struct Plan {
    phone: Phone,
    seconds: f64,
    /// The highest first.
    points: Vec<gpumodel::OperatingPoint>,
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
                "--sustained {text}: expected a time above 0 and up to a day with its unit, such as 10min or 90s"
            );
        };
        let phone = match &args.phone {
            None => Phone::parse(BUILTIN, "configs/thermal/phone.toml")?,
            Some(path) => Phone::parse(
                &read_text(path, "a description of a phone (.toml)")?,
                &path.display().to_string(),
            )?,
        };
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
        let allowed = |point: &&gpumodel::OperatingPoint| point.hz <= gpu.clock.hz * (1.0 + 1e-9);
        let points: Vec<_> = gpu.operating_points.iter().filter(allowed).copied().collect();
        if points.is_empty() {
            bail!(
                "--sustained {text}: every operating point of {} has a higher clock than its {} MHz; raise clock.mhz or add a lower [[operating_point]]",
                gpu.name(),
                gpu.clock.hz * 1e-6
            );
        }
        Ok(Some(Self { phone, seconds, points }))
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
        let Self { phone, seconds, points } = self;
        let hot = phone.hottest_of_gpu();
        let mut loads = Vec::new();
        let mut volts = Vec::new();
        for (point, answer) in points.iter().zip(answers) {
            let energy = answer.energy.as_ref().ok_or_else(|| anyhow!("the frame's energy is not known"))?;
            loads.push(load(point, energy, answer.seconds, hot)?);
            volts.push(energy.prices.supply().volts());
        }
        let run = phone.simulate(&loads, &Settings::over(seconds))?;
        let section = Sustained::new(&phone, &loads, &volts, &run, seconds);
        let assumptions = assumptions(&phone, &points, hot);
        Ok(Followed { section, assumptions, phone, points: loads, run })
    }
}

/// What frames one after the other take at a clock.
fn load(
    point: &gpumodel::OperatingPoint,
    energy: &FrameEnergy,
    frame_s: f64,
    hot: f64,
) -> anyhow::Result<OperatingPoint> {
    let prices = &energy.prices;
    let leakage = prices.leakage();
    let volts = prices.supply().volts();
    let figure = |celsius| (celsius, leakage.watts(volts, celsius));
    let law = LeakageLaw::through([figure(leakage.reference_celsius()), figure(hot)]).ok_or_else(|| {
        anyhow!(
            "leakage does not grow from {} to {hot} degrees Celsius; correct temperature_scale of the energy table",
            leakage.reference_celsius()
        )
    })?;
    let of = |domain| energy.of_domain(domain) / frame_s;
    Ok(OperatingPoint {
        mhz: point.hz * 1e-6,
        frames_per_second: 1.0 / frame_s,
        gpu_watts: of(Domain::Gpu) + of(Domain::SystemCache),
        dram_watts: of(Domain::Dram),
        leakage: law,
    })
}

fn assumptions(phone: &Phone, points: &[gpumodel::OperatingPoint], hot: f64) -> Vec<String> {
    let voltage = if points.iter().all(|point| point.volts.is_some()) {
        "at its voltage"
    } else {
        "at the reference voltage of its process, as the description gives none"
    };
    vec![
        format!(
            "Sustained: the frame is replayed at each clock {voltage}, and drawn again as soon as it is done, whatever the display shows. Dynamic energy of the \
             GPU goes with the square of the voltage; leakage is the exponential through the energy table's figures at its reference temperature and at {hot} \
             degrees Celsius. The CPU's part of a frame is not in it."
        ),
        format!(
            "Sustained: {} figures of the phone are estimates: {}.",
            phone.estimates.len(),
            phone.estimates.join(", ")
        ),
    ]
}

impl Followed {
    /// The series over time, and its chart under a subtitle: names and bytes of files.
    pub(crate) fn files(&self, subtitle: String) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
        let chart: TimeSeriesChart = sustained::chart(&self.phone, &self.points, &self.run, subtitle);
        Ok(vec![
            (FILES[0].to_owned(), sustained::csv_text(&self.phone, &self.points, &self.run).into_bytes()),
            (FILES[1].to_owned(), chart.svg()?.into_bytes()),
            (FILES[2].to_owned(), chart.png()?),
        ])
    }
}

/// Names of the files of a load.
pub(crate) const FILES: [&str; 3] = ["sustained.csv", "sustained.svg", "sustained.png"];
