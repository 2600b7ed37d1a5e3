use std::path::Path;

use super::*;

fn read(text: &str) -> (Vec<Entry>, Result<Vec<String>, String>) {
    let report = Report::default();
    let file = report.add_file(Path::new("a.mtl"), text);
    let entries = parse(text, file, &report);
    (entries, report.finish().map_err(|e| e.to_string()))
}

fn entry(statements: &str) -> (Entry, Vec<String>) {
    let (mut entries, warnings) = read(&format!("newmtl m\n{statements}\n"));
    (entries.pop().unwrap(), warnings.unwrap())
}

#[test]
fn a_clean_library_is_read_as_tobj_reads_it() {
    let text = "newmtl a\nKd 0.1 0.2 0.3\nKs 0.4 0.5 0.6\nNs 20\nNi 1.4\nd 0.5\nillum 2\nmap_Kd a.png\n\
                    newmtl b\nKd 1 0 0\nillum 7\nmap_d b.png\n";
    let (ours, _) = read(text);
    let (theirs, _) = tobj::load_mtl_buf(&mut text.as_bytes()).unwrap();
    assert_eq!(ours.len(), theirs.len());
    for (a, b) in ours.iter().zip(&theirs) {
        assert_eq!(a.name, b.name);
        assert_eq!(a.diffuse.map(Rgb::to_array), b.diffuse);
        assert_eq!(a.specular.map(Rgb::to_array), b.specular);
        assert_eq!((a.exponent, a.index), (b.shininess, b.optical_density));
        assert_eq!(a.opacity, b.dissolve);
        assert_eq!(a.illumination, b.illumination_model.map(i64::from));
        let name = |map: &Option<Map>| map.as_ref().map(|m| m.text.clone());
        assert_eq!(name(&a.diffuse_map), b.diffuse_texture);
        assert_eq!(name(&a.opacity_map), b.dissolve_texture);
    }
}

#[test]
fn one_number_is_a_grey_and_two_give_a_warning() {
    let (m, warnings) = entry("Kd 0.5\nKs .25 # grey\nKe 2");
    assert_eq!(m.diffuse, Some(Rgb::grey(0.5)));
    assert_eq!((m.specular, m.emission), (Some(Rgb::grey(0.25)), Some(Rgb::grey(2.0))));
    assert!(warnings.is_empty(), "{warnings:?}");
    let (m, warnings) = entry("Kd 0.5 0.2");
    assert_eq!(m.diffuse, Some(Rgb::new(0.5, 0.2, 0.2)));
    assert!(warnings[0].contains("a.mtl:2") && warnings[0].contains("two numbers"));
    let (m, warnings) = entry("Kd\nKd 0.1 0.2 0.3 0.4\nNs");
    assert_eq!((m.diffuse, warnings.len()), (Some(Rgb::new(0.1, 0.2, 0.3)), 2));
}

#[test]
fn lines_that_exporters_write_are_understood() {
    let (m, warnings) = entry("map_Kd\nmap_Ke \nillum 2.0\nd -halo 1.0\nKa 1 1 1\nPm 0.0\nkd 0.5");
    assert!(m.diffuse_map.is_none() && m.emission_map.is_none());
    assert_eq!((m.illumination, m.opacity), (Some(2), Some(1.0)));
    assert_eq!(m.diffuse, Some(Rgb::grey(0.5)), "keywords in any case");
    assert!(warnings.is_empty(), "{warnings:?}");
    let (m, _) = entry("Tr 0.75");
    assert_eq!(m.opacity, Some(0.25));
    let (m, _) = entry("Tr 0.75\nd 0.5");
    assert_eq!(m.opacity, Some(0.5));
    let (m, _) = entry("Kd xyz 0.4124564 0.2126729 0.0193339");
    assert!((m.diffuse.unwrap() - Rgb::new(1.0, 0.0, 0.0)).map(f32::abs).max() < 2e-3);
}

#[test]
fn ignored_statements_that_change_the_picture_give_a_warning() {
    for (statement, shown) in [
        ("Kd spectral a.rfl 1", "`Kd spectral` is not supported"),
        ("map_Bump -bm 0.5 a.png", "`map_Bump` is ignored"),
        ("Pr 0.5", "`Pr` is ignored"),
        ("illum -1", "`illum -1` is not an illumination model"),
        ("d -halo 0.5", "`-halo` is ignored"),
        ("Kd 2 1 1", "`Kd` is outside [0, 1]: clamped"),
        ("wibble 3", "unknown statement `wibble`"),
    ] {
        let (_, warnings) = entry(statement);
        assert_eq!(warnings.len(), 1, "{statement}: {warnings:?}");
        assert!(warnings[0].contains(shown), "{statement}: {warnings:?}");
    }
    let (_, warnings) = read("Kd 1 1 1\nnewmtl m\n");
    assert!(warnings.unwrap()[0].contains("before the first `newmtl`"));
}

#[test]
fn an_absurd_value_is_ignored_with_its_line_and_does_not_refuse_the_file() {
    for statement in ["Kd red", "Kd 1 nan 0", "Ke 1 -1 1", "Ni x", "illum two", "Ns 1e40"] {
        let (entries, warnings) = read(&format!("newmtl m\n{statement}\nKs 0.5\n"));
        let warnings = warnings.unwrap();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        let shown = &warnings[0];
        assert!(
            shown.contains("a.mtl:2") && shown.contains("`m`") && shown.contains("ignored"),
            "{shown}"
        );
        let m = &entries[0];
        assert_eq!(m.specular, Some(Rgb::grey(0.5)), "the rest of the material is read");
        assert!(
            m.diffuse.is_none()
                && m.emission.is_none()
                && m.index.is_none()
                && m.exponent.is_none()
        );
    }
}
