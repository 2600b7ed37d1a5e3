//! Comments with two dashes in them, which XML forbids and people write: command lines, rulers.

use std::borrow::Cow;

/// The text with the dashes inside of comments replaced by underscores, byte by byte, so that all places stay the same.
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

/// What stands inside of the next comment after byte `at`. A comment without an end is left to the parser.
fn next_comment(text: &str, mut at: usize) -> Option<std::ops::Range<usize>> {
    loop {
        at += text[at..].find('<')?;
        let rest = &text[at..];
        // What looks like a comment in these is none.
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
    fn dashes_vanish_inside_of_comments_only_and_no_byte_moves() {
        let text = "<?a --?><!-- \u{e4} --spp 64 ---><a b='--'/><!-- fine --><![CDATA[<!-- -- -->]]><!--->-->";
        let clean = without_dashes(text);
        assert_eq!(clean.len(), text.len());
        let expected = "<?a --?><!-- \u{e4} __spp 64 _--><a b='--'/><!-- fine --><![CDATA[<!-- -- -->]]><!--->-->";
        assert_eq!(clean, expected);
        assert!(matches!(without_dashes("<a/><!-- a-b -->"), Cow::Borrowed(_)));
        assert!(matches!(without_dashes("<!-- -- no end"), Cow::Borrowed(_)));
    }
}
