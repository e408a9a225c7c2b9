use super::*;
use proptest::prelude::*;

const NAMED: [&str; 7] =
    ["none", "sign", "octahedral-4x4", "octahedral-7x3", "position-2", "position-sign-1", "octahedral-1x1"];

fn unit_box() -> Aabb {
    let mut bounds = Aabb::EMPTY;
    bounds.min = [0.0; 3].into();
    bounds.max = [1.0; 3].into();
    bounds
}

fn named(name: &str) -> Binning {
    Binning::from_name(name).expect(name)
}

fn direction_bin(name: &str, direction: [f32; 3]) -> u32 {
    named(name).bin(direction, [0.5; 3], &unit_box())
}

/// Any bits of a float: zeros, infinities and numbers that are none among them.
fn anything() -> impl Strategy<Value = [f32; 3]> {
    [0, 1, 2].map(|_| {
        prop_oneof![
            4 => any::<u32>().prop_map(f32::from_bits),
            1 => prop::sample::select(vec![0.0, -0.0, f32::NAN, f32::INFINITY, f32::MIN_POSITIVE, f32::MAX]),
        ]
    })
}

/// How many of that many directions each octahedral bin gets.
fn shares(columns: u32, rows: u32, count: u32) -> Vec<u32> {
    let binning = Binning::Octahedral { columns, rows };
    let mut counts = vec![0; binning.bins() as usize];
    for direction in directions(count) {
        counts[binning.bin(narrowed(direction), [0.0; 3], &unit_box()) as usize] += 1;
    }
    counts
}

/// Unit directions, evenly over the sphere.
fn directions(count: u32) -> impl Iterator<Item = [f64; 3]> {
    let turn = std::f64::consts::PI * (3.0 - 5_f64.sqrt());
    (0..count).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (sine, cosine) = (turn * f64::from(i)).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        [radius * cosine, radius * sine, z]
    })
}

fn narrowed(direction: [f64; 3]) -> [f32; 3] {
    direction.map(|coordinate| coordinate as f32)
}

#[test]
fn names_are_told_apart_and_refusals_say_what_to_do() {
    for name in NAMED {
        assert_eq!(named(name).to_string(), name);
    }
    for (name, expected) in [
        ("", "no binning is called ''"),
        ("octahedral", "expected none, sign, octahedral-4x4"),
        ("octahedral-4", "no binning is called"),
        ("octahedral-04x4", "no binning is called"),
        ("octahedral-+4x4", "no binning is called"),
        ("position--1", "no binning is called"),
        ("octahedral-0x4", "has 0 bins, expected 1 to 4095"),
        ("octahedral-64x64", "has 4096 bins"),
        ("octahedral-65536x65536", "more than 4294967295 bins"),
        ("position-4", "has 4096 bins"),
        ("position-11", "more than 4294967295 bins"),
        ("position-sign-3", "has 4096 bins"),
        ("position-4000000000", "more than 4294967295 bins"),
    ] {
        let message = Binning::from_name(name).expect_err(name).to_string();
        assert!(message.contains(expected), "{name}: {message}");
    }
}

#[test]
fn bins_are_as_many_as_the_parts_make() {
    let bins = NAMED.map(|name| named(name).bins());
    assert_eq!(bins, [1, 8, 16, 21, 64, 64, 1]);
    assert_eq!(named("octahedral-63x65").bins(), MOST_BINS);
}

#[test]
fn sign_bins_have_a_bit_per_axis_and_zeros_and_no_numbers_are_negative() {
    assert_eq!(direction_bin("sign", [1.0, -1.0, -1.0]), 1);
    assert_eq!(direction_bin("sign", [-1.0, 1.0, -1.0]), 2);
    assert_eq!(direction_bin("sign", [-1.0, -1.0, 1.0]), 4);
    assert_eq!(direction_bin("sign", [1.0; 3]), 7);
    for low in [0.0, -0.0, f32::NAN] {
        assert_eq!(direction_bin("sign", [low; 3]), 0);
    }
}

#[test]
fn a_direction_that_has_none_is_in_the_first_octahedral_bin() {
    for none in [[0.0; 3], [-0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY; 3]] {
        assert_eq!(direction_bin("octahedral-4x4", none), 0);
    }
    // The pole is the middle of the square, its opposite the corners: z = -1 with positive zeros the last one.
    assert_eq!(direction_bin("octahedral-4x4", [0.0, 0.0, 1.0]), 2 + 2 * 4);
    assert_eq!(direction_bin("octahedral-4x4", [0.0, 0.0, -1.0]), 3 + 3 * 4);
    assert_eq!(direction_bin("octahedral-4x4", [-1e-6, -1e-6, -1.0]), 0);
}

#[test]
fn origins_follow_the_morton_curve_and_those_outside_the_nearest_part_of_the_box() {
    let bin = |origin| named("position-2").bin([0.0; 3], origin, &unit_box());
    assert_eq!(bin([0.0; 3]), 0);
    assert_eq!([bin([0.3, 0.0, 0.0]), bin([0.0, 0.3, 0.0]), bin([0.0, 0.0, 0.3])], [1, 2, 4]);
    assert_eq!([bin([0.6, 0.0, 0.0]), bin([0.0, 0.0, 0.6])], [8, 32]);
    assert_eq!([bin([1.0; 3]), bin([7.0; 3]), bin([f32::INFINITY; 3])], [63, 63, 63]);
    assert_eq!([bin([-7.0; 3]), bin([f32::NAN; 3])], [0, 0]);
    let flat = Aabb { max: [1.0, 0.0, 1.0].into(), ..unit_box() };
    assert_eq!(named("position-1").bin([0.0; 3], [0.9, 0.0, 0.9], &flat), 5);
    assert_eq!(named("position-1").bin([0.0; 3], [0.9; 3], &Aabb::EMPTY), 0);
}

#[test]
fn signs_come_before_the_origin_where_both_count() {
    let bin = named("position-sign-1").bin([1.0, -1.0, 1.0], [0.0, 0.9, 0.0], &unit_box());
    assert_eq!(bin, 5 * 8 + 2);
}

#[test]
fn octahedral_bins_share_the_sphere_within_the_distortion_of_the_map() {
    // With r = |x| + |y| + |z| of a unit direction, from 1 to sqrt(3), an area of the octahedron is seen under r^3 / sqrt(3) of it as solid angle: its plane is
    // 1 / sqrt(3) away from the centre, the point 1 / r. The octahedron's area is 4 sqrt(3) and the square's 1, so a part of the square is r^3 / pi times
    // its share of the sphere.
    const COUNT: u32 = 1 << 17;
    let (least, most) = (1.0 / std::f64::consts::PI, 27_f64.sqrt() / std::f64::consts::PI);
    for [columns, rows] in [[1, 1], [2, 2], [4, 4], [3, 5], [8, 8], [16, 16]] {
        let mean = f64::from(COUNT) / f64::from(columns * rows);
        // A bin's share of even points differs from its area by some of those along its border, of which there are about 4 sqrt(mean).
        let within = (least * mean - 4.0 * mean.sqrt())..=(most * mean + 4.0 * mean.sqrt());
        for count in shares(columns, rows, COUNT) {
            assert!(within.contains(&f64::from(count)), "{columns}x{rows}: {count} of a mean of {mean}");
        }
    }
}

#[test]
fn the_distortion_of_the_map_is_reached_at_the_axes_and_in_the_middle_of_the_faces() {
    const COUNT: u32 = 1 << 20;
    let counts = shares(60, 60, COUNT);
    let share = |column: usize, row: usize| {
        f64::from(counts[column + row * 60]) / f64::from(COUNT) * 3600.0 * std::f64::consts::PI
    };
    // The axis z is in the middle of the square, the middle of its first face a sixth further along both axes.
    assert!((share(30, 30) - 1.0).abs() < 0.15, "{}", share(30, 30));
    assert!((share(39, 39) - 27_f64.sqrt()).abs() < 0.4, "{}", share(39, 39));
}

#[test]
fn quadrants_of_the_octahedral_square_are_equal() {
    // By symmetry: a face of each half of the sphere.
    let counts = shares(2, 2, 1 << 16);
    assert!(counts.iter().all(|count| count.abs_diff(1 << 14) < 64), "{counts:?}");
}

proptest! {
    #[test]
    fn every_ray_has_a_bin(direction in anything(), origin in anything(), corner in anything()) {
        let bounds = Aabb { max: corner.into(), ..unit_box() };
        for name in NAMED {
            let binning = named(name);
            prop_assert!(binning.bin(direction, origin, &bounds) < binning.bins());
        }
    }

    #[test]
    fn the_length_of_a_direction_does_not_matter(direction in prop::array::uniform3(-1_f32..1.0), power in -20_i32..20) {
        for name in ["sign", "octahedral-4x4", "octahedral-7x3"] {
            let longer = direction.map(|coordinate| coordinate * 2_f32.powi(power));
            prop_assert_eq!(direction_bin(name, direction), direction_bin(name, longer));
        }
    }

    #[test]
    fn points_of_the_square_go_there_and_back(u in 0.001_f32..0.999, v in 0.001_f32..0.999) {
        // Folded up again as Cigolle et al. do.
        let (x, y) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
        let z = 1.0 - x.abs() - y.abs();
        let fold = (-z).max(0.0);
        let direction = [x - fold.copysign(x), y - fold.copysign(y), z];
        let [back_u, back_v] = unfolded(direction);
        prop_assert!((back_u - u).abs() < 1e-5 && (back_v - v).abs() < 1e-5, "{back_u} {back_v}");
    }

    #[test]
    fn near_directions_are_near_on_the_square_away_from_its_border(
        index in 0_u32..4096, step in prop::array::uniform3(-1_f32..1.0),
    ) {
        // A point p of the octahedron is d / r, with r from 1 to sqrt(3): it moves by |dd - p dr| / r <= (1 + |p| sqrt(3)) |dd| <= 2.8 |dd|, and (x, y) of the square by half
        // of that. The square is cut open where x = 0 or y = 0 below.
        const FAR: f32 = 1e-3;
        let direction = narrowed(directions(4096).nth(index as usize).unwrap_or_default());
        let near = [0, 1, 2].map(|axis| direction[axis] + step[axis] * FAR);
        prop_assume!(direction[2] > 0.01 || direction[0].abs().min(direction[1].abs()) > 0.01);
        let ([u, v], [near_u, near_v]) = (unfolded(direction), unfolded(near));
        let moved = (u - near_u).hypot(v - near_v);
        prop_assert!(moved <= 1.4 * FAR * 3_f32.sqrt(), "{moved}");
    }
}
