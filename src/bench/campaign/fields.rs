//! A line of a CSV file from values, and back.

use serde_json::{Number, Value};

/// The line of these values, without its end. Nothing stands for null; text is quoted only where it could be taken for
/// something else. Lists and objects have no place in a line and are left empty.
pub(super) fn line<'a>(values: impl IntoIterator<Item = &'a Value>) -> String {
    let fields: Vec<String> = values.into_iter().map(field).collect();
    fields.join(",")
}

fn field(value: &Value) -> String {
    match value {
        Value::Null | Value::Array(_) | Value::Object(_) => String::new(),
        Value::Bool(_) | Value::Number(_) => value.to_string(),
        Value::String(text) => {
            // A line is a line: breaks within a text become spaces.
            let text = text.replace(['\n', '\r'], " ");
            let is_plain = !text.contains([',', '"']) && bare(&text).as_str() == Some(&text);
            if is_plain {
                text
            } else {
                format!("\"{}\"", text.replace('"', "\"\""))
            }
        }
    }
}

/// The values of a line; none where a quotation is not closed, or goes on after it was.
pub(super) fn values(line: &str) -> Option<Vec<Value>> {
    let mut values = Vec::new();
    let mut rest = line;
    loop {
        let (value, after) = if let Some(quoted) = rest.strip_prefix('"') {
            quotation(quoted)?
        } else {
            let end = rest.find(',').unwrap_or(rest.len());
            (bare(&rest[..end]), &rest[end..])
        };
        values.push(value);
        if after.is_empty() {
            return Some(values);
        }
        rest = after.strip_prefix(',')?;
    }
}

/// The text up to the closing quotation mark, and what follows it.
fn quotation(quoted: &str) -> Option<(Value, &str)> {
    let mut text = String::new();
    let mut rest = quoted;
    loop {
        let end = rest.find('"')?;
        text.push_str(&rest[..end]);
        rest = &rest[end + 1..];
        match rest.strip_prefix('"') {
            Some(after) => {
                text.push('"');
                rest = after;
            }
            None => return Some((Value::String(text), rest)),
        }
    }
}

/// What a field without quotation marks stands for.
fn bare(text: &str) -> Value {
    let real = || text.parse().ok().and_then(Number::from_f64);
    match text {
        "" => Value::Null,
        "true" => Value::Bool(true),
        "false" => Value::Bool(false),
        _ => text
            .parse::<u64>()
            .map(Number::from)
            .ok()
            .or_else(real)
            .map_or_else(|| Value::String(text.to_owned()), Value::Number),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_value_comes_back() {
        let all = json!([
            null,
            true,
            false,
            0,
            12,
            u64::MAX,
            -3.5,
            0.1,
            1e-300,
            5e-324,
            1.797e308,
            "word",
            "two words",
            "a,b",
            "say \"no\"",
            "\"",
            "12",
            "1e5",
            "true",
            "NaN",
            "-",
            " ",
            "",
            ",",
            "12e45678",
            "é, ü"
        ]);
        let all = all.as_array().expect("a list");
        let line = line(all);
        assert_eq!(values(&line).as_ref(), Some(all), "{line}");
        assert!(line.contains(",word,two words,\"a,b\","), "{line}");
    }

    #[test]
    fn a_line_break_in_a_text_does_not_break_the_line() {
        assert_eq!(line(&[json!("one\ntwo")]), "one two");
    }

    #[test]
    fn quotations_that_are_not_closed_are_no_line() {
        for bad in ["\"open", "1,\"open", "\"a\"b", "\"a\" ,1"] {
            assert_eq!(values(bad), None, "{bad}");
        }
        assert_eq!(values(""), Some(vec![Value::Null]));
        assert_eq!(values("1,"), Some(vec![json!(1), Value::Null]));
    }
}
