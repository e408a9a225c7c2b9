//! A phone as it stands in its TOML file.

use crate::sourced::Sourced;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PhoneFile {
    pub(crate) name: String,
    pub(crate) title: String,
    pub(crate) air: AirFile,
    pub(crate) charge: Option<ChargeFile>,
    pub(crate) node: Vec<NodeFile>,
    pub(crate) link: Vec<LinkFile>,
    pub(crate) heat: HeatFile,
    #[serde(default)]
    pub(crate) other: Vec<OtherFile>,
    #[serde(default)]
    pub(crate) zone: Vec<ZoneFile>,
    pub(crate) shutdown: ShutdownFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AirFile {
    pub(crate) celsius: Sourced,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChargeFile {
    pub(crate) watt_hours: Sourced,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NodeFile {
    pub(crate) name: Spanned<String>,
    pub(crate) heat_capacity: Sourced,
    pub(crate) to_ambient: Option<Sourced>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LinkFile {
    pub(crate) between: [Spanned<String>; 2],
    pub(crate) conductance: Sourced,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct HeatFile {
    pub(crate) gpu: Spanned<String>,
    pub(crate) dram: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OtherFile {
    pub(crate) name: String,
    pub(crate) node: Spanned<String>,
    pub(crate) watts: Sourced,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ZoneFile {
    pub(crate) name: String,
    pub(crate) sensor: Spanned<String>,
    pub(crate) governor: Spanned<GovernorName>,
    pub(crate) polling_ms: Sourced,
    pub(crate) polling_passive_ms: Sourced,
    pub(crate) trip: Vec<TripFile>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum GovernorName {
    StepWise,
    Monitor,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TripFile {
    pub(crate) celsius: Sourced,
    pub(crate) hysteresis: Sourced,
    pub(crate) clock_share: Option<Sourced>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ShutdownFile {
    pub(crate) node: Spanned<String>,
    pub(crate) celsius: Sourced,
}
