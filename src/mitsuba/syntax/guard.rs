//! What is done with a text before the XML parser sees it: limits that keep hostile files from taking its
//! time, and comments as Mitsuba has them.

use std::borrow::Cow;

/// Largest number of attributes of an element. No element that means anything has more than five.
pub const MOST_ATTRIBUTES: usize = 64;

/// The place of the first tag with more than [`MOST_ATTRIBUTES`] attributes.
///
/// The parser looks for duplicates by comparing each attribute with all before it. That takes half a minute
/// for a hundred thousand of them; this pass is linear.
pub fn crowded_tag(text: &str) -> Option<usize> {
    let mut at = 0;
    while let Some(open) = text[at..].find('<') {
        at += open;
        let rest = &text[at..];
        let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")]
            .into_iter()
            .find(|(begin, _)| rest.starts_with(begin));
        if let Some((begin, end)) = skipped {
            at += begin.len() + rest[begin.len()..].find(end)? + end.len();
            continue;
        }
        let (length, attributes) = tag(rest.as_bytes());
        if attributes > MOST_ATTRIBUTES {
            return Some(at);
        }
        at += length;
    }
    None
}

/// The text with blanks for hyphens that a comment must not hold: `--`, or one before its end. Mitsuba's
/// parser takes them as they are. All places stay the same.
pub fn with_plain_comments(text: &str) -> Cow<'_, str> {
    let mut plain = Cow::Borrowed(text);
    let mut at = 0;
    while let Some(open) = text[at..].find("<!--") {
        let begin = at + open + "<!--".len();
        let Some(length) = text[begin..].find("-->") else {
            break;
        };
        let comment = &text[begin..begin + length];
        if comment.contains("--") || comment.ends_with('-') {
            plain
                .to_mut()
                .replace_range(begin..begin + length, &comment.replace('-', " "));
        }
        at = begin + length + "-->".len();
    }
    plain
}

/// The length of the tag that the text begins with, and the number of equal signs outside its quotes.
fn tag(text: &[u8]) -> (usize, usize) {
    let mut quote = None;
    let mut attributes = 0;
    for (index, byte) in text.iter().enumerate() {
        match (quote, byte) {
            (None, b'"' | b'\'') => quote = Some(byte),
            (None, b'=') => attributes += 1,
            (None, b'>') => return (index + 1, attributes),
            (Some(open), byte) if open == byte => quote = None,
            _ => {}
        }
    }
    (text.len(), attributes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_may_hold_hyphens_and_nothing_moves() {
        let text = "<a><!-- x -- y ---><b/><!-- z - --><!---->--</a><!-- open --";
        let plain = with_plain_comments(text);
        assert_eq!(
            plain,
            "<a><!-- x    y  --><b/><!-- z - --><!---->--</a><!-- open --"
        );
        assert!(matches!(with_plain_comments("<a>--</a>"), Cow::Borrowed(_)));
    }

    #[test]
    fn only_attributes_of_one_tag_count() {
        let many = |count: usize| " a='='".repeat(count);
        assert_eq!(
            crowded_tag(&format!("<a{}/><a{}/>", many(40), many(40))),
            None
        );
        assert_eq!(
            crowded_tag(&format!(
                "<!--{}--><?x {}?><a>{}</a>",
                many(99),
                many(99),
                many(99)
            )),
            None
        );
        assert_eq!(crowded_tag(&format!("<a>\n<b{}>", many(65))), Some(4));
        assert_eq!(crowded_tag("<a b='>'><![CDATA[<"), None);
        assert_eq!(crowded_tag("<"), None);
    }
}
