//! Features of a frame: those that its scene needs, unless they are forced in or out.

use anyhow::bail;
use scenes::{Feature, Needs};
use tracer::{Choice, Forced};

/// What was asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Features {
    /// In the order of [`Feature::ALL`].
    choices: [Option<Choice>; Feature::ALL.len()],
}

impl Features {
    pub(crate) fn new(force: &[String], leave_out: &[String]) -> anyhow::Result<Self> {
        if let Some(name) = force.iter().find(|name| leave_out.contains(name)) {
            bail!("--force {name}: --leave-out {name} asks for the opposite; give one of them");
        }
        let choice = |feature: Feature| {
            let named = |names: &[String]| names.iter().any(|name| name == feature.name());
            match (named(force), named(leave_out)) {
                (true, _) => Some(Choice::In),
                (false, true) => Some(Choice::Out),
                (false, false) => None,
            }
        };
        Ok(Self { choices: Feature::ALL.map(choice) })
    }

    /// What was asked for a feature.
    pub(crate) fn choice(self, feature: Feature) -> Option<Choice> {
        let place = Feature::ALL.iter().position(|&other| other == feature);
        place.and_then(|place| self.choices[place])
    }

    /// Whether the frame of a scene with these needs has a feature.
    pub(crate) fn has(self, feature: Feature, needs: &Needs) -> bool {
        self.choice(feature).map_or(needs.has(feature), |choice| choice == Choice::In)
    }

    /// What goes against these needs.
    pub(crate) fn forced(self, needs: &Needs) -> Vec<Forced> {
        let forced = |feature: Feature| {
            let choice = self.choice(feature)?;
            ((choice == Choice::In) != needs.has(feature)).then_some(Forced { feature, choice })
        };
        Feature::ALL.into_iter().filter_map(forced).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_goes_against_the_needs_is_forced() {
        let needs = scenes::load("cornell").expect("built in").needs();
        assert!(needs.has(Feature::ShadowRays) && !needs.has(Feature::Normals));
        let features = |force: &[&str], leave_out: &[&str]| {
            let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
            Features::new(&owned(force), &owned(leave_out)).expect("no contradiction")
        };
        assert_eq!(features(&[], &[]).forced(&needs), []);
        assert_eq!(features(&["shadow-rays"], &["normals"]).forced(&needs), []);
        let against = features(&["normals"], &["shadow-rays"]);
        let expected = [(Feature::ShadowRays, Choice::Out), (Feature::Normals, Choice::In)];
        assert_eq!(against.forced(&needs), expected.map(|(feature, choice)| Forced { feature, choice }));
        assert!(!against.has(Feature::ShadowRays, &needs) && against.has(Feature::Normals, &needs));
    }
}
