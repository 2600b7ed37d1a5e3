//! Refuses text for which the XML parser would take too much time or memory, before the parser sees it.

use std::ops::Range;

use super::MAX_NESTING;

/// Largest number of attributes of an element: the parser compares each with all others.
const MAX_ATTRIBUTES: usize = 256;
/// Largest number of namespace declarations: the parser copies all that are valid for each new one. Scenes have none.
const MAX_NAMESPACES: usize = 64;

/// What is wrong, and where.
pub(super) type Refused = (Range<usize>, String);

/// Check the tags of a text. Malformed text passes: the parser reports it.
pub(super) fn check(text: &str) -> Result<(), Refused> {
    let namespace = "xmlns";
    if let Some((at, _)) = text.match_indices(namespace).nth(MAX_NAMESPACES) {
        let message = format!("more than {MAX_NAMESPACES} namespaces");
        return Err((at..at + namespace.len(), message));
    }
    let (mut at, mut depth) = (0, 0usize);
    while let Some(found) = text[at..].find('<') {
        let start = at + found;
        let rest = &text[start..];
        // Inside these, `<` does not start a tag.
        let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
        if let Some((open, close)) = skipped.iter().find(|(open, _)| rest.starts_with(open)) {
            let Some(end) = rest[open.len()..].find(close) else { return Ok(()) };
            at = start + open.len() + end + close.len();
            continue;
        }
        let tag = Tag::at_start_of(rest);
        let place = start..start + rest.chars().next().map_or(0, char::len_utf8);
        if tag.attributes > MAX_ATTRIBUTES {
            return Err((place, format!("an element with more than {MAX_ATTRIBUTES} attributes")));
        }
        match tag.kind {
            Kind::Open => depth += 1,
            Kind::Close => depth = depth.saturating_sub(1),
            Kind::Empty => {}
        }
        // The scene itself and a value's elements are around and inside what the reader counts.
        if depth > MAX_NESTING + 4 {
            return Err((place, "elements are nested too deeply".into()));
        }
        at = start + tag.length;
    }
    Ok(())
}

/// A tag: its length in bytes and the number of its attributes.
struct Tag {
    kind: Kind,
    length: usize,
    attributes: usize,
}

enum Kind {
    Open,
    Close,
    Empty,
}

impl Tag {
    fn at_start_of(text: &str) -> Tag {
        let bytes = text.as_bytes();
        let (mut quote, mut attributes, mut length) = (None, 0, bytes.len());
        for (i, &byte) in bytes.iter().enumerate().skip(1) {
            match (quote, byte) {
                (Some(open), _) if open == byte => quote = None,
                (Some(_), _) => {}
                (None, b'\'' | b'"') => quote = Some(byte),
                (None, b'=') => attributes += 1,
                (None, b'>') => {
                    length = i + 1;
                    break;
                }
                (None, _) => {}
            }
        }
        let kind = if text.starts_with("</") {
            Kind::Close
        } else if text.starts_with("<!") || text[..length].ends_with("/>") {
            Kind::Empty
        } else {
            Kind::Open
        };
        Tag { kind, length, attributes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> Option<String> {
        check(text).err().map(|(_, message)| message)
    }

    #[test]
    fn crowded_and_deep_elements_are_refused() {
        let attributes = |n| format!("<a {}/>", "b='>='  ".repeat(n));
        assert_eq!(refused(&attributes(MAX_ATTRIBUTES)), None);
        assert!(refused(&attributes(MAX_ATTRIBUTES + 1)).unwrap().contains("attributes"));
        let nested = |n| "<a b='/>'>".repeat(n) + &"</a>".repeat(n);
        assert_eq!(refused(&nested(MAX_NESTING).repeat(3)), None);
        assert!(refused(&nested(1000)).unwrap().contains("too deep"));
        assert!(refused(&"<a xmlns:a='b'/>".repeat(65)).unwrap().contains("namespaces"));
    }

    #[test]
    fn comments_and_malformed_text_pass() {
        let commented = format!("<a><!--{0}--><![CDATA[{0}]]><?{0}?></a>", "<a>".repeat(1000));
        for text in
            [commented.as_str(), "<", "<a b='", "<!-- <a>", "a > b", "", "<!DOCTYPE a>", "<\u{e4}"]
        {
            assert_eq!(refused(text), None, "{text}");
        }
    }
}
