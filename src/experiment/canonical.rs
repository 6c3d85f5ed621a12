//! Canonical JSON: one text for each value, independent of the order of its fields.

use serde_json::Value;

/// Returns the value as JSON without spaces, the fields of every object sorted by name.
pub(super) fn canonical(value: &Value) -> String {
    match value {
        Value::Array(values) => {
            let values: Vec<String> = values.iter().map(canonical).collect();
            format!("[{}]", values.join(","))
        }
        Value::Object(fields) => {
            let mut fields: Vec<(&String, &Value)> = fields.iter().collect();
            fields.sort_by_key(|(name, _)| *name);
            let field = |(name, value): (&String, &Value)| {
                format!("{}:{}", Value::from(name.as_str()), canonical(value))
            };
            let fields: Vec<String> = fields.into_iter().map(field).collect();
            format!("{{{}}}", fields.join(","))
        }
        plain => plain.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::canonical;

    #[test]
    fn canonical_json_ignores_only_the_order_of_fields() {
        let text = |json: &str| canonical(&serde_json::from_str(json).expect("JSON"));
        let expected = r#"{"a":[1,{"c":null,"d":"x\"y"}],"b":0.1}"#;
        assert_eq!(text(r#"{ "b": 0.1, "a": [1, {"d": "x\"y", "c": null}] }"#), expected);
        assert_eq!(text(expected), expected);
        assert_ne!(text(r#"{"a":[{"c":null,"d":"x\"y"},1],"b":0.1}"#), expected);
    }
}
