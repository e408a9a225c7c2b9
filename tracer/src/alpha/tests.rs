use super::*;
use proptest::prelude::*;

#[test]
fn half_of_a_fence_is_opaque_and_its_edges_are() {
    let samples = 1 << 16;
    let opaque = (0..samples).filter(|&sample| fence((sample as f32 + 0.5) / samples as f32)).count();
    assert_eq!(opaque * 2, samples);
    for edge in [0.0, -1e-7, 1.0, 1.000_000_1] {
        assert!(fence(edge), "{edge}");
    }
    let changes = (1..samples).filter(|&sample| {
        let at = |sample: i32| fence(sample as f32 / samples as f32);
        at(sample as i32) != at(sample as i32 - 1)
    });
    assert_eq!(changes.count(), 2 * POSTS as usize, "three gaps, each with two sides");
}

#[test]
fn contradictions_are_refused() {
    let runs = |runs: &[[u32; 2]]| TestedTriangles::Runs(runs.to_vec());
    let tests = |mode, tested, micromap| AlphaTests { mode, tested, micromap };
    let format = MicromapFormat { level: 4, states: MicromapStates::Four };
    assert!(tests(AlphaMode::AnyHit, runs(&[[0, 2], [5, 5]]), None).check(10).is_ok());
    assert!(tests(AlphaMode::Micromap, runs(&[]), Some(format)).check(0).is_ok());
    for wrong in [
        tests(AlphaMode::AnyHit, runs(&[[0, 0]]), None),
        tests(AlphaMode::AnyHit, runs(&[[3, 2], [1, 1]]), None),
        tests(AlphaMode::AnyHit, runs(&[[3, 2], [4, 1]]), None),
        tests(AlphaMode::AnyHit, runs(&[[9, 2]]), None),
        tests(AlphaMode::AnyHit, runs(&[[u32::MAX, u32::MAX]]), None),
        tests(AlphaMode::AnyHit, runs(&[]), Some(format)),
        tests(AlphaMode::Micromap, runs(&[]), None),
        tests(AlphaMode::Micromap, runs(&[]), Some(MicromapFormat { level: 5, ..format })),
    ] {
        assert!(wrong.check(10).is_err(), "{wrong:?}");
    }
}

proptest! {
    #[test]
    fn runs_are_what_they_were_made_of(tested in prop::collection::vec(any::<bool>(), 0..300)) {
        let runs = TestedTriangles::of(tested.iter().copied());
        let triangles = tested.len() as u32;
        prop_assert!(runs.check(triangles).is_ok());
        prop_assert_eq!(runs.count(triangles) as usize, tested.iter().filter(|&&tested| tested).count());
        let set = runs.set(triangles);
        for (triangle, &tested) in (0..).zip(&tested) {
            prop_assert_eq!((runs.contains(triangle), set.contains(triangle)), (tested, tested));
        }
    }

    #[test]
    fn one_pair_in_four_is_counted_rightly(triangles in 0_u32..100) {
        let rule = TestedTriangles::OnePairInFour;
        let contained = (0..triangles).filter(|&triangle| rule.contains(triangle)).count();
        prop_assert_eq!(rule.count(triangles) as usize, contained);
    }
}
