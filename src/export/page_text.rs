//! The document of a page put together from its parts: texts as HTML, and sums of what a browser may run.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

/// Puts `values` in the place of `{{their names}}` in `template`. What stands in a value stays as it is.
pub fn filled(template: &str, values: &[(&str, &str)]) -> String {
    let mut pieces = template.split("{{");
    let mut text = pieces.next().unwrap_or_default().to_owned(); // a split has a first piece
    for piece in pieces {
        let (name, after) = piece.split_once("}}").unwrap_or(("", piece));
        text.push_str(values.iter().find(|(key, _)| *key == name).map_or("", |(_, value)| value));
        text.push_str(after);
    }
    text
}

/// Returns `text` as HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Returns names and values as the content of a list of definitions.
pub fn definitions(pairs: &[(String, String)]) -> String {
    pairs
        .iter()
        .map(|(name, value)| format!("<dt>{}</dt><dd>{}</dd>", escaped(name), escaped(value)))
        .collect()
}

/// Returns `lines` as the items of a list.
pub fn items(lines: &[String]) -> String {
    lines.iter().map(|line| format!("<li>{}</li>", escaped(line))).collect()
}

/// Returns the source of a Content-Security-Policy that allows an element with exactly this content.
pub fn source_of(content: &str) -> String {
    format!("'sha256-{}'", BASE64_STANDARD.encode(hmac_sha256::Hash::hash(content.as_bytes())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_become_no_tags_and_values_no_names() {
        let values = [("a", "{{b}}"), ("b", "2")];
        assert_eq!(filled("{{a}} {{b}} {{c}}.", &values), "{{b}} 2 .");
        let pairs = [("<b>".to_owned(), "\"&\"".to_owned())];
        assert_eq!(definitions(&pairs), "<dt>&lt;b&gt;</dt><dd>&quot;&amp;&quot;</dd>");
        assert_eq!(items(&["<".to_owned(), "x".to_owned()]), "<li>&lt;</li><li>x</li>");
    }

    #[test]
    fn an_element_is_named_by_the_sum_of_its_content() {
        // printf 'abc' | openssl dgst -sha256 -binary | base64
        assert_eq!(source_of("abc"), "'sha256-ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0='");
    }
}
