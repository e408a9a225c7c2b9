//! A phone: its network, what else is on, and what watches over it.

use crate::error::Error;
use crate::file::{GovernorName, PhoneFile, TripFile, ZoneFile};
use crate::governor::{Cap, Rule, Trip, Zone};
use crate::network::{Link, Network, Node};
use crate::sourced::{File, Sourced};
use toml::Spanned;

/// The phone that comes with the program: `configs/thermal/phone.toml`.
pub const BUILTIN: &str = include_str!("../../configs/thermal/phone.toml");

/// When the phone shuts down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutdown {
    /// Whose temperature decides, by place in the network.
    pub node: usize,
    /// Degrees Celsius.
    pub celsius: f64,
}

/// A phone.
#[derive(Clone, Debug, PartialEq)]
pub struct Phone {
    /// Its name.
    pub name: String,
    /// Its name for people.
    pub title: String,
    /// Where heat flows.
    pub network: Network,
    /// Temperature of the air, in degrees Celsius.
    pub ambient_celsius: f64,
    /// Energy of a full battery in Wh, where it is known.
    pub charge_watt_hours: Option<f64>,
    /// The node that the GPU heats.
    pub gpu: usize,
    /// The node that the memory heats.
    pub dram: usize,
    /// Power into each node of what is on besides GPU and memory, in W.
    pub other_watts: Vec<f64>,
    /// What lowers the clock.
    pub zones: Vec<Zone>,
    /// What ends everything.
    pub shutdown: Shutdown,
    /// Keys of the figures that are estimates.
    pub estimates: Vec<String>,
}

/// Bounds of what a file may say, wide enough for any phone.
const HEAT_CAPACITY: std::ops::RangeInclusive<f64> = 1e-9..=1e6;
const CONDUCTANCE: std::ops::RangeInclusive<f64> = 1e-9..=1e6;
const CELSIUS: std::ops::RangeInclusive<f64> = -50.0..=200.0;
const WATTS: std::ops::RangeInclusive<f64> = 0.0..=1000.0;
const WATT_HOURS: std::ops::RangeInclusive<f64> = 1e-3..=1e6;
const INTERVAL_MS: std::ops::RangeInclusive<f64> = 0.0..=1e6;
/// A sensor that is read more often would only cost time.
const PASSIVE_MS: std::ops::RangeInclusive<f64> = 1.0..=1e6;
const HYSTERESIS: std::ops::RangeInclusive<f64> = 1e-3..=100.0;

impl Phone {
    /// The phone that `text` describes; `name` is what errors call the text.
    ///
    /// # Errors
    /// When the text is no such description, a figure is out of its range or without a source, or a name is of no node.
    pub fn parse(text: &str, name: &str) -> Result<Self, Error> {
        let file = File { name, text };
        let read: PhoneFile = file.read()?;
        let mut reader = Reader { file, names: Vec::new(), estimates: Vec::new() };
        let nodes = read.node.iter().map(|node| {
            let name = node.name.get_ref();
            if name.trim().is_empty() || reader.names.contains(name) {
                let problem = format!("'{name}' is empty or the name of an earlier node");
                return Err(reader.file.refuse(
                    "node.name",
                    &node.name.span(),
                    problem,
                    "give each node a name of its own",
                ));
            }
            reader.names.push(name.clone());
            let heat_capacity =
                reader.figure(&format!("node.{name}.heat_capacity"), &node.heat_capacity, HEAT_CAPACITY)?;
            let to_ambient = match &node.to_ambient {
                Some(figure) => reader.figure(&format!("node.{name}.to_ambient"), figure, CONDUCTANCE)?,
                None => 0.0,
            };
            Ok(Node { name: name.clone(), heat_capacity, to_ambient })
        });
        let nodes = nodes.collect::<Result<Vec<_>, _>>()?;
        let links = read.link.iter().map(|link| {
            let [a, b] = [&link.between[0], &link.between[1]].map(|name| reader.node("link.between", name));
            let key = format!("link.{}-{}.conductance", link.between[0].get_ref(), link.between[1].get_ref());
            let conductance = reader.figure(&key, &link.conductance, CONDUCTANCE)?;
            Ok(Link { between: [a?, b?], conductance })
        });
        let links = links.collect::<Result<Vec<_>, Error>>()?;
        let network = Network::new(nodes, &links).map_err(|error| Error::Config {
            file: name.to_owned(),
            line: None,
            key: String::new(),
            problem: error.to_string(),
            remedy: "correct [[node]] and [[link]]".to_owned(),
        })?;
        let mut other_watts = vec![0.0; network.size()];
        for other in &read.other {
            let node = reader.node("other.node", &other.node)?;
            other_watts[node] +=
                reader.figure(&format!("other.{}.watts", other.name), &other.watts, WATTS)?;
        }
        let charge_watt_hours = read
            .charge
            .as_ref()
            .map(|charge| reader.figure("charge.watt_hours", &charge.watt_hours, WATT_HOURS))
            .transpose()?;
        let ambient_celsius = reader.figure("air.celsius", &read.air.celsius, CELSIUS)?;
        let shutdown = Shutdown {
            node: reader.node("shutdown.node", &read.shutdown.node)?,
            celsius: reader.figure("shutdown.celsius", &read.shutdown.celsius, CELSIUS)?,
        };
        if shutdown.celsius <= ambient_celsius {
            let problem = format!("is {}, expected more than the air's {ambient_celsius}", shutdown.celsius);
            let span = read.shutdown.celsius.span();
            return Err(reader.file.refuse("shutdown.celsius", &span, problem, "correct the value"));
        }
        let zones = read.zone.iter().map(|zone| reader.zone(zone)).collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            name: read.name,
            title: read.title,
            gpu: reader.node("heat.gpu", &read.heat.gpu)?,
            dram: reader.node("heat.dram", &read.heat.dram)?,
            network,
            ambient_celsius,
            charge_watt_hours,
            other_watts,
            zones,
            shutdown,
            estimates: reader.estimates,
        })
    }
}

impl Phone {
    /// With caps that are parts of a clock `ratio` times the highest of the operating points that it is given: those of a GPU whose highest ones are left out.
    #[must_use]
    pub fn with_caps_of(mut self, ratio: f64) -> Self {
        for zone in &mut self.zones {
            if let Rule::Monitor(caps) = &mut zone.rule {
                caps.iter_mut().for_each(|cap| cap.clock_share *= ratio);
            }
        }
        self
    }
}

struct Reader<'a> {
    file: File<'a>,
    names: Vec<String>,
    estimates: Vec<String>,
}

impl Reader<'_> {
    fn figure(
        &mut self,
        key: &str,
        figure: &Sourced,
        range: std::ops::RangeInclusive<f64>,
    ) -> Result<f64, Error> {
        if figure.is_estimate() {
            self.estimates.push(key.to_owned());
        }
        self.file.within(key, figure, range)
    }

    fn node(&self, key: &str, name: &Spanned<String>) -> Result<usize, Error> {
        self.names.iter().position(|known| known == name.get_ref()).ok_or_else(|| {
            let problem =
                format!("'{}' is no node; expected one of {}", name.get_ref(), self.names.join(", "));
            self.file.refuse(key, &name.span(), problem, "name a node of [[node]]")
        })
    }

    fn zone(&mut self, zone: &ZoneFile) -> Result<Zone, Error> {
        let key = |figure: &str| format!("zone.{}.{figure}", zone.name);
        let sensor = self.node(&key("sensor"), &zone.sensor)?;
        let seconds = 1e-3;
        let polling = seconds * self.figure(&key("polling_ms"), &zone.polling_ms, INTERVAL_MS)?;
        let polling_passive =
            seconds * self.figure(&key("polling_passive_ms"), &zone.polling_passive_ms, PASSIVE_MS)?;
        let refuse = |this: &Self, problem: &str, remedy: &str| {
            this.file.refuse(&key("trip"), &zone.governor.span(), problem, remedy)
        };
        let rule = match (zone.governor.get_ref(), zone.trip.as_slice()) {
            (_, []) => return Err(refuse(self, "there is none", "add a [[zone.trip]]")),
            (GovernorName::StepWise, [trip]) => {
                if trip.clock_share.is_some() {
                    let remedy = "leave clock_share out, or use the governor \"monitor\"";
                    return Err(refuse(self, "step_wise has no caps", remedy));
                }
                Rule::StepWise(self.trip(&key("trip"), trip)?)
            }
            (GovernorName::StepWise, _) => {
                return Err(refuse(
                    self,
                    "step_wise has one trip",
                    "leave the others out, or make another zone",
                ));
            }
            (GovernorName::Monitor, trips) => {
                let mut caps: Vec<Cap> = Vec::new();
                for file in trips {
                    let trip = self.trip(&key("trip"), file)?;
                    let Some(share) = &file.clock_share else {
                        return Err(refuse(self, "a trip of a monitor has no clock_share", "add it"));
                    };
                    let clock_share = self.figure(&key("trip.clock_share"), share, 0.0..=1.0)?;
                    let last = caps.last();
                    if last.is_some_and(|last| {
                        trip.celsius <= last.trip.celsius
                            || trip.celsius - trip.hysteresis < last.trip.celsius - last.trip.hysteresis
                            || clock_share >= last.clock_share
                    }) {
                        let problem = "trips do not rise, or a later one ends below an earlier one or allows a higher clock";
                        return Err(refuse(self, problem, "sort them by temperature"));
                    }
                    caps.push(Cap { trip, clock_share });
                }
                Rule::Monitor(caps)
            }
        };
        Ok(Zone { name: zone.name.clone(), sensor, polling, polling_passive, rule })
    }

    fn trip(&mut self, key: &str, trip: &TripFile) -> Result<Trip, Error> {
        Ok(Trip {
            celsius: self.figure(&format!("{key}.celsius"), &trip.celsius, CELSIUS)?,
            hysteresis: self.figure(&format!("{key}.hysteresis"), &trip.hysteresis, HYSTERESIS)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(from: &str, to: &str) -> String {
        assert!(BUILTIN.contains(from), "{from}");
        Phone::parse(&BUILTIN.replacen(from, to, 1), "phone.toml").expect_err("refused").to_string()
    }

    #[test]
    fn the_built_in_phone_is_read() {
        let phone = Phone::parse(BUILTIN, "phone.toml").expect("a phone");
        assert_eq!(phone.network.nodes()[phone.gpu].name, "gpu");
        assert!(phone.estimates.contains(&"node.gpu.heat_capacity".to_owned()));
        assert!(phone.zones.iter().all(|zone| zone.polling_passive > 0.0));
    }

    #[test]
    fn caps_stay_at_their_clocks_where_the_highest_operating_points_are_left_out() {
        let clocks = |phone: &Phone, highest: f64| -> Vec<f64> {
            let of_zone = |rule: &Rule| match rule {
                Rule::Monitor(caps) => caps.iter().map(|cap| cap.clock_share * highest).collect(),
                Rule::StepWise(_) => Vec::new(),
            };
            phone.zones.iter().flat_map(|zone| of_zone(&zone.rule)).collect()
        };
        let phone = Phone::parse(BUILTIN, "phone.toml").expect("a phone");
        let of_all = clocks(&phone, 710.0);
        let of_rest = clocks(&phone.with_caps_of(710.0 / 414.0), 414.0);
        assert!(!of_all.is_empty());
        assert!(
            of_all.iter().zip(&of_rest).all(|(all, rest)| (all - rest).abs() < 1e-9),
            "{of_all:?} {of_rest:?}"
        );
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line_and_a_remedy() {
        let message = refused("name = \"board\"", "name = \"package\"");
        assert!(
            message.contains("'package' is empty or the name of an earlier node; give each"),
            "{message}"
        );
        let message = refused("between = [\"gpu\"", "between = [\"cpu\"");
        assert!(message.contains("'cpu' is no node; expected one of gpu, package"), "{message}");
        assert!(message.starts_with("phone.toml:"), "{message}");
        assert!(refused("[air]", "[air]\nwind = 1").contains("wind"));
        assert!(refused("governor = \"step_wise\"", "governor = \"bang\"").contains("bang"));
        assert!(refused("sensor = \"gpu\"", "sensor = \"moon\"").contains("zone.gpu.sensor"));
        assert!(refused("hysteresis = { value = 1", "hysteresis = { value = 0").contains("0.001 to 100"));
    }
}
