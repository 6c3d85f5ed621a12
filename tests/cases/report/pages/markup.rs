//! A small markup parser that finds broken pictures.

/// Returns each `<svg ...>...</svg>` of a page.
pub fn pictures(page: &str) -> Vec<&str> {
    page.match_indices("<svg")
        .map(|(start, _)| {
            let length = page[start..].find("</svg>").expect("every picture is closed");
            &page[start..start + length + "</svg>".len()]
        })
        .collect()
}

/// Returns the first tag of a picture.
pub fn opening_tag(picture: &str) -> &str {
    &picture[..=picture.find('>').expect("a tag ends")]
}

/// Returns the value of an attribute of a tag.
pub fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let start = tag.find(&format!(" {name}=\""))? + name.len() + 3;
    tag[start..].split('"').next()
}

/// Checks that tags are closed in order, that attributes are quoted and unique, and that the text has no bare `<` or `&`.
pub fn check_well_formed(picture: &str) -> Result<(), String> {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = picture;
    while let Some(start) = rest.find('<') {
        check_entities(&rest[..start])?;
        let end = start + rest[start..].find('>').ok_or("a tag without end")?;
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            if open.pop() != Some(name) {
                return Err(format!("</{name}> closes no open tag: {open:?}"));
            }
        } else {
            let name = tag.split_whitespace().next().ok_or("a tag without name")?;
            check_attributes(&tag[name.len()..])?;
            if !tag.ends_with('/') {
                open.push(name);
            }
        }
    }
    check_entities(rest)?;
    if open.is_empty() { Ok(()) } else { Err(format!("left open: {open:?}")) }
}

fn check_attributes(mut text: &str) -> Result<(), String> {
    let mut seen: Vec<&str> = Vec::new();
    while !text.trim().trim_end_matches('/').is_empty() {
        let (name, rest) =
            text.split_once("=\"").ok_or(format!("an attribute is not quoted: {text}"))?;
        let (value, rest) = rest.split_once('"').ok_or(format!("a quote is not closed: {text}"))?;
        check_entities(value)?;
        if seen.contains(&name.trim())
            || name.trim().contains(|c: char| !c.is_ascii_alphanumeric() && c != '-')
        {
            return Err(format!("a bad or repeated attribute: {name}"));
        }
        seen.push(name.trim());
        text = rest;
    }
    Ok(())
}

fn check_entities(text: &str) -> Result<(), String> {
    for (start, _) in text.match_indices('&') {
        let name = text[start..].split(';').next().unwrap_or_default();
        if !["&amp", "&lt", "&gt", "&quot", "&#39"].contains(&name) {
            return Err(format!("a bare & in {text}"));
        }
    }
    Ok(())
}

/// Returns the words of a page that spell a number that is not finite. Embedded images are ignored.
pub fn numbers_that_are_none(page: &str) -> Vec<&str> {
    page.split(|c: char| !c.is_ascii_alphanumeric() && c != '+' && c != '/')
        .filter(|word| ["nan", "inf", "infinity"].contains(&word.to_lowercase().as_str()))
        .collect()
}
