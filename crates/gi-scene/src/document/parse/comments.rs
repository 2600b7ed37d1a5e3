//! Accepts comments that contain `--`. XML forbids this, but scenes contain it in command lines and rulers.

use std::borrow::Cow;

/// Replace the dashes inside comments by underscores. No byte moves, so all positions stay valid.
pub(super) fn without_dashes(text: &str) -> Cow<'_, str> {
    let mut out = String::new();
    let mut at = 0;
    while let Some(inside) = next_comment(text, at) {
        let comment = &text[inside.clone()];
        if comment.contains("--") || comment.ends_with('-') {
            out.push_str(&text[out.len()..inside.start]);
            out.push_str(&comment.replace('-', "_"));
        }
        at = inside.end + "-->".len();
    }
    if out.is_empty() {
        return Cow::Borrowed(text);
    }
    out.push_str(&text[out.len()..]);
    Cow::Owned(out)
}

/// Byte range of the contents of the next comment after `at`. An unterminated comment is left to the parser to report.
fn next_comment(text: &str, mut at: usize) -> Option<std::ops::Range<usize>> {
    loop {
        at += text[at..].find('<')?;
        let rest = &text[at..];
        // Inside these, `<!--` does not start a comment.
        let skipped = [("<![CDATA[", "]]>"), ("<?", "?>")];
        if let Some((open, close)) = skipped.iter().find(|(open, _)| rest.starts_with(open)) {
            at += open.len() + rest[open.len()..].find(close)? + close.len();
        } else if let Some(comment) = rest.strip_prefix("<!--") {
            let start = at + "<!--".len();
            return Some(start..start + comment.find("-->")?);
        } else {
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_dashes_inside_comments_are_replaced_and_no_byte_moves() {
        let text = "<?a --?><!-- \u{e4} --spp 64 ---><a b='--'/><!-- fine --><![CDATA[<!-- -- -->]]><!--->-->";
        let clean = without_dashes(text);
        assert_eq!(clean.len(), text.len());
        let expected = "<?a --?><!-- \u{e4} __spp 64 _--><a b='--'/><!-- fine --><![CDATA[<!-- -- -->]]><!--->-->";
        assert_eq!(clean, expected);
        assert!(matches!(without_dashes("<a/><!-- a-b -->"), Cow::Borrowed(_)));
        assert!(matches!(without_dashes("<!-- -- no end"), Cow::Borrowed(_)));
    }
}
