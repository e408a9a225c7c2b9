//! Does every case of the stability suite keep its limit, and does the suite end?

use stability::{Case, Size, all};
use std::collections::HashSet;
use std::sync::mpsc;
use std::time::Duration;

/// Many times what a quick run takes on a slow machine: what is not done by then hangs.
const LONGEST: Duration = Duration::from_secs(300);

#[test]
fn every_case_keeps_its_limit_and_the_suite_ends() {
    let (sender, receiver) = mpsc::channel();
    let (started, starting) = mpsc::channel();
    std::thread::spawn(move || {
        // Nobody listens any more once the test has failed.
        let cases = all(Size::Quick, |group| {
            let _ = started.send(group);
        });
        let _ = sender.send(cases);
    });
    let cases: Vec<Case> = receiver.recv_timeout(LONGEST).unwrap_or_else(|error| {
        panic!("{error} after {LONGEST:?}, in the group {:?}", starting.try_iter().last());
    });
    let groups: Vec<&str> = starting.try_iter().collect();
    assert_eq!(groups, stability::groups().collect::<Vec<_>>());
    let ids: HashSet<&str> = cases.iter().map(|case| case.id.as_str()).collect();
    assert_eq!(ids.len(), cases.len(), "every case has a name of its own");
    let failed: Vec<&Case> = cases.iter().filter(|case| !case.passes()).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(cases.len() > 100, "{} cases", cases.len());
}
