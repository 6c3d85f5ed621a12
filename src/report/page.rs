//! The HTML document around the content of a page, and the parts that all pages share.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::Serialize;
use sha2::{Digest, Sha256};

/// The style of all pages.
pub(crate) const STYLE: &str = concat!(
    include_str!("colours.css"),
    include_str!("drawing.css"),
    include_str!("chart.css"),
    include_str!("map.css"),
    include_str!("style.css")
);

/// A page loads nothing from outside.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

/// A file of a report folder: a page, a picture, or the data of a chart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportFile {
    /// Its name without a folder.
    pub name: String,
    /// Its content.
    pub text: String,
}

impl ReportFile {
    pub(super) fn new(name: impl Into<String>, text: String) -> Self {
        let name = name.into();
        Self { name, text }
    }
}

/// Returns a whole page as text. `style` is added to that of all pages; no script other than `script` can run.
pub(super) fn document(title: &str, style: &str, script: &str, content: &Markup) -> String {
    let policy = if script.is_empty() { String::new() } else { script_policy(script) };
    document_with(title, style, script, &policy, &Markup::default(), content)
}

/// The same for a page whose script may read from the server that sent the page.
#[cfg(feature = "server")]
pub(super) fn live_document(title: &str, style: &str, script: &str, content: &Markup) -> String {
    let policy = script_policy(script) + "; connect-src 'self'";
    // A browser asks a server for an icon otherwise.
    let icon = html! { link rel="icon" href="data:,"; };
    document_with(title, style, script, &policy, &icon, content)
}

fn script_policy(script: &str) -> String {
    format!("; script-src 'sha256-{}'", STANDARD.encode(Sha256::digest(script.as_bytes())))
}

fn document_with(
    title: &str,
    style: &str,
    script: &str,
    policy: &str,
    head: &Markup,
    content: &Markup,
) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content={ (POLICY) (policy) };
                (head)
                meta name="generator" content="inbye";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(style)) }
            }
            body {
                main {
                    (content)
                    @if !script.is_empty() { script { (PreEscaped(script)) } }
                }
            }
        }
    }
    .into_string()
}

/// The headline of a page, its introduction, and the machine of the measurements. Empty lines separate paragraphs.
pub(super) fn page_header(title: &str, intro: &str, machine: &str, rest: &Markup) -> Markup {
    let paragraphs = intro.split("\n\n").filter(|text| !text.trim().is_empty());
    html! {
        header {
            h1 { (title) }
            @for paragraph in paragraphs { p { (paragraph) } }
            @if !machine.is_empty() { p class="machine" { "Measured on: " (machine) } }
            (rest)
        }
    }
}

/// A result on top of a page: its name, its value and its unit.
pub(super) type Tile = (String, String, &'static str);

/// The most important results, as tiles.
pub(super) fn tiles(tiles: &[Tile]) -> Markup {
    html! {
        @if !tiles.is_empty() {
            dl class="cards" {
                @for (name, value, unit) in tiles {
                    div { dt { (name) } dd { (value) " " span { (unit) } } }
                }
            }
        }
    }
}

/// The command that makes a page again.
pub(super) fn reproduction(command: &str) -> Markup {
    html! {
        section {
            h2 { "Reproduction" }
            pre tabindex="0" { code { (command) } }
        }
    }
}

/// A short statement, marked as good or bad by colour and sign.
pub(super) fn badge(is_good: bool, text: &str) -> Markup {
    let (class, sign) = if is_good { ("badge good", "✓") } else { ("badge bad", "✗") };
    html! { span class=(class) { (sign) " " (text) } }
}

/// Data as indented JSON.
pub(super) fn json_text<T: Serialize + ?Sized>(data: &T) -> String {
    // Rows of numbers and texts always serialise.
    serde_json::to_string_pretty(data).unwrap_or_default() + "\n"
}
