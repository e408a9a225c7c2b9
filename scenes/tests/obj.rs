//! Does an OBJ file become exactly the triangles it describes, in file order, and is a bad one refused with its line?

mod common;

use common::{bits, plain_triangles};
use scenes::{Error, Vec3, obj};
use std::fmt::Write;

fn refused(text: &str) -> Error {
    obj::parse(text.as_bytes(), "bad.obj").expect_err(text)
}

fn triangles(text: &str) -> Vec<[u32; 3]> {
    obj::parse(text.as_bytes(), "good.obj").unwrap().mesh.triangles
}

/// Groups, objects, materials, smoothing, polygons, relative indices, comments and orphans, all mixed.
fn mixed_file() -> String {
    let mut text = String::from("# mixed\r\nmtllib none.mtl\nv 9 9 9\n");
    for i in 0..200 {
        let f = f64::from(i) * 0.137;
        writeln!(text, "o object{}\ng group{}\nusemtl m{}\ns {}", i % 5, i % 7, i % 3, i % 2).unwrap();
        for k in 0..6 {
            writeln!(text, "v {} {:.6} {:e}", f + f64::from(k), f * f - f64::from(k * k), -f).unwrap();
            writeln!(text, "vt {f} 0.5\nvn 0 {k} 1").unwrap();
        }
        let v = i * 6 + 2;
        writeln!(text, "f {}/1/1 {}/1/1 {}/1/1", v, v + 1, v + 2).unwrap();
        writeln!(text, "f {} {} {} {} {} {}", v, v + 1, v + 2, v + 3, v + 4, v + 5).unwrap();
        writeln!(text, "f -1//-1 -2//-2 -3//-3 -4//-4").unwrap();
    }
    text
}

#[test]
fn polygons_become_fans_in_file_order() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 2 0\nf 1 2 3 4 5\nf 3 2 1\n";
    assert_eq!(triangles(text), [[0, 1, 2], [0, 2, 3], [0, 3, 4], [2, 1, 0]]);
}

#[test]
fn groups_objects_and_materials_do_not_change_the_triangles() {
    let text = mixed_file();
    let ours = obj::parse(text.as_bytes(), "mixed.obj").unwrap();
    let ours: Vec<_> = (0..ours.mesh.triangles.len()).map(|i| ours.mesh.triangle(i)).collect();
    let plain = plain_triangles(&text);
    assert_eq!(plain.len(), 200 * 7);
    assert_eq!(bits(&ours), bits(&plain));
}

#[test]
fn tobj_gives_the_same_triangles() {
    let text = mixed_file();
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let (models, _) =
        tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| Err(tobj::LoadError::OpenFileFailed)).unwrap();
    let theirs: Vec<u32> = models
        .iter()
        .flat_map(|m| m.mesh.indices.iter().map(move |&i| &m.mesh.positions[3 * i as usize..][..3]))
        .flatten()
        .map(|x| x.to_bits())
        .collect();
    let ours = obj::parse(text.as_bytes(), "mixed.obj").unwrap();
    let ours: Vec<_> = (0..ours.mesh.triangles.len()).map(|i| ours.mesh.triangle(i)).collect();
    assert_eq!(bits(&ours), theirs);
}

#[test]
fn coordinates_are_rounded_once_from_the_decimal() {
    // Just above the middle of two f32: rounding to f64 first would lose the excess and round to even, down.
    let text =
        "v 1.00000005960464477539062501 16777217.0000000000000001 0.1\nv 0 1 0\nv -0 0 1e-46\nf 1 2 3\n";
    let p = obj::parse(text.as_bytes(), "r.obj").unwrap().mesh.positions;
    assert_eq!(p[0].to_array().map(f32::to_bits), [0x3f80_0001, 16_777_218f32.to_bits(), 0x3dcc_cccd]);
    assert_eq!(p[2].to_array().map(f32::to_bits), [0x8000_0000, 0, 0]);
}

#[test]
fn relative_indices_count_from_the_last_vertex_and_absolute_ones_may_point_ahead() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nf 1 2 4\nv 5 5 5\nf -1 -2 -3\n";
    assert_eq!(triangles(text), [[0, 1, 2], [0, 1, 3], [3, 2, 1]]);
}

#[test]
fn carriage_returns_tabs_continued_lines_and_comments_are_read_as_the_format_has_them() {
    let text =
        "v\t0 0 0 1.0\r\n  v 1 0 0 0.5 0.5 0.5\r\nv 0 \\\n 1 0\nf 1 2 \\\r\n3 # f 9 9 9\n#f 7 8 9\nf 3 2 1";
    assert_eq!(triangles(text), [[0, 1, 2], [2, 1, 0]]);
}

#[test]
fn text_that_is_not_utf8_is_read() {
    let text = b"# caf\xe9\nusemtl b\xe9ton\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let file = obj::parse(text, "latin1.obj").unwrap();
    assert_eq!(file.material_names.len(), 1);
}

#[test]
fn materials_follow_usemtl_and_faces_before_it_have_none() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let file = obj::parse(
        format!("{v}f 1 2 3\nusemtl a\nf 1 2 3\nusemtl b c\nf 1 2 3\nusemtl a\nf 1 2 3\n").as_bytes(),
        "m.obj",
    )
    .unwrap();
    assert_eq!(file.material_names, [None, Some("a".into()), Some("b c".into())]);
    assert_eq!(file.mesh.materials, [0, 1, 2, 1]);
}

#[test]
fn normals_keep_their_own_indices_and_gaps_are_noted() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 2\nf 1 2 3\nf 1//2 2//1 3//-1\n";
    let file = obj::parse(text.as_bytes(), "n.obj").unwrap();
    let normals = file.mesh.normals.unwrap();
    assert_eq!(normals.vectors, [Vec3::Z, Vec3::Z * 2.0]);
    assert_eq!(normals.triangles, [None, Some([1, 0, 1])]);
    assert_eq!(file.notes[0].text(), "1 of 2 triangles have no shading normals.");
}

#[test]
fn a_normal_that_is_not_finite_costs_the_normals_but_not_the_geometry() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 nan 1\nf 1//1 2//1 3//1\n";
    let file = obj::parse(text.as_bytes(), "n.obj").unwrap();
    assert!(file.mesh.normals.is_none());
    assert!(file.notes[0].text().contains("line 4"), "{:?}", file.notes);
}

#[test]
fn degenerate_faces_are_kept_so_that_ids_do_not_shift() {
    assert_eq!(triangles("v 0 0 0\nv 1 0 0\nf 1 1 1\nf 1 2 1 2\n"), [[0, 0, 0], [0, 1, 0], [0, 0, 1]]);
}

#[test]
fn a_coordinate_that_is_not_finite_is_refused_with_its_line() {
    for word in ["nan", "NaN", "inf", "-inf", "infinity", "1e39", "-1e400"] {
        let e = refused(&format!("v 0 0 0\n\nv 1 {word} 0\nf 1 2 1\n"));
        assert_eq!((e.line(), e.place()), (Some(3), "bad.obj"), "{e}");
        assert!(e.problem().contains("finite"), "{e}");
    }
    let largest = format!("v 0 0 0\nv {} 0 0\nf 1 2 1\n", f32::MAX);
    assert_eq!(triangles(&largest).len(), 1);
}

#[test]
fn an_index_out_of_range_is_refused_with_its_line() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for face in
        ["f 0 1 2", "f 1 2 -4", "f 1 2 4", "f 1 2 99999999999999999999", "f 1 2 4294967297", "f 1//1 2 3"]
    {
        let e = refused(&format!("{v}{face}\nf 1 2 3\n"));
        assert_eq!(e.line(), Some(4), "{face}: {e}");
    }
    assert_eq!(triangles(&format!("{v}f 1 2 -3\nf 1 2 3\n")).len(), 2);
}

#[test]
fn a_malformed_face_or_vertex_is_refused_with_its_line() {
    for line in
        ["f 1 2", "f", "f 1 2 x", "f 1/ 2/ 3.5", "f 1/1/1/1 2 3", "f 1/x 2 3", "v 1 2", "v 1 2 three", "v"]
    {
        let e = refused(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{line}\nf 1 2 3\n"));
        assert_eq!(e.line(), Some(4), "{line}: {e}");
        assert!(!e.remedy().is_empty());
    }
}

#[test]
fn an_empty_file_one_without_faces_and_a_binary_one_are_told_apart() {
    assert!(refused("").problem().contains("empty"));
    assert!(refused("v 0 0 0\n# nothing\n").problem().contains("no face"));
    let e = obj::parse(b"\x7fELF\x02\x01\0\0\0\0\n\0\0", "a.obj").unwrap_err();
    assert!(e.remedy().contains("binary"), "{e}");
}

#[test]
fn a_line_at_the_limit_is_read_and_a_longer_one_is_refused() {
    let with_comment = |length: usize| {
        let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n#";
        format!("{head}{}\n", "x".repeat(length - 2))
    };
    assert!(obj::parse(with_comment(obj::MAX_LINE).as_bytes(), "long.obj").is_ok());
    let e = obj::parse(with_comment(obj::MAX_LINE + 1).as_bytes(), "long.obj").unwrap_err();
    assert_eq!(e.line(), Some(5), "{e}");
}

#[test]
fn points_and_lines_are_skipped_with_a_note() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1\nl 1 2 3\nf 1 2 3\n";
    let file = obj::parse(text.as_bytes(), "pl.obj").unwrap();
    assert!(file.notes.iter().any(|n| n.text().starts_with("2 point or line")), "{:?}", file.notes);
}
