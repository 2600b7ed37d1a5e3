use super::words::edit_distance;
use super::*;

#[test]
fn distance_counts_edits_and_swapped_neighbours() {
    assert_eq!(edit_distance("kitten", "sitting"), 3);
    assert_eq!(edit_distance("dielectirc", "dielectric"), 1);
    assert_eq!(edit_distance("", "abc"), 3);
}

#[test]
fn only_near_words_are_proposed() {
    let names = ["diffuse", "dielectric", "conductor"];
    assert_eq!(did_you_mean("difuse", names), Some("diffuse"));
    assert_eq!(did_you_mean("dielectirc", names), Some("dielectric"));
    assert_eq!(did_you_mean("hair", names), None);
}

#[test]
fn an_error_is_shown_with_place_line_caret_expectation_and_suggestion() {
    let report = Report::default();
    let text = "<scene>\n  <bsdf type=\"difuse\"/>\n</scene>\n";
    let file = report.add_file(Path::new("a.xml"), text);
    let start = text.find("difuse").unwrap();
    report.error_help(
        Span { file, start, end: start + 6 },
        "unknown bsdf `difuse`",
        "expected a bsdf plugin",
        report.suggestion("difuse", ["diffuse"]),
    );
    let shown = report.finish().unwrap_err().to_string();
    let expected = [
        "error: unknown bsdf `difuse`",
        " --> a.xml:2:15",
        "  |",
        "2 |   <bsdf type=\"difuse\"/>",
        "  |               ^^^^^^ expected a bsdf plugin",
        "  |",
        "help: did you mean `diffuse`?",
    ];
    assert_eq!(shown.trim_end(), expected.join("\n"));
}

#[test]
fn many_misspelt_names_get_no_more_suggestions() {
    let report = Report::default();
    let names: Vec<String> = (0..1000).map(|k| format!("b{k}")).collect();
    let suggest = || report.suggestion("b7", names.iter().map(String::as_str));
    assert!((0..MAX_COMPARISONS / 1000).all(|_| suggest().is_some()));
    assert_eq!(suggest(), None);
}

#[test]
fn errors_of_one_kind_are_counted() {
    let report = Report::default();
    (0..1994 + 24).for_each(|k| report.error_nowhere(format!("nothing has the id `c{k}`")));
    report.error_nowhere("another error");
    let problems = report.finish().unwrap_err();
    assert_eq!(problems.len(), 1994 + 25);
    let shown = problems.to_string();
    assert_eq!(shown.lines().filter(|line| line.starts_with("error")).count(), 26);
    assert!(
        shown.ends_with("error: and 1,994 more like this: nothing has the id `c24`"),
        "{shown}"
    );
    assert!(shown.contains("error: another error"));
}

#[test]
fn the_place_in_a_very_long_line_is_named_instead_of_shown() {
    let report = Report::default();
    let text = format!("<a/>\n{}<b/>", "\u{e4}".repeat(LONG));
    let file = report.add_file(Path::new("a.xml"), &text);
    let start = text.find("<b").unwrap();
    report.error(Span { file, start, end: start + 1 }, "a mistake", "expected nothing");
    let shown = report.finish().unwrap_err().to_string();
    let place = format!("a.xml:2:{}: expected nothing", LONG + 1);
    assert!(shown.contains("a mistake") && shown.contains(&place), "{shown}");
    assert!(shown.len() < 200);
}
