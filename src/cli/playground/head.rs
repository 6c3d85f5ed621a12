//! The head of a request over HTTP/1.1, read with `httparse`, and what it says of its body.

use super::refusal::Refusal;

/// Longest body, bytes: a problem with all the obstacles that are allowed takes a twentieth of it.
pub const MOST_BODY_BYTES: usize = 65_536;
/// Longest head, bytes.
pub const MOST_HEAD_BYTES: usize = 16_384;
/// Most headers.
const MOST_HEADERS: usize = 64;
/// What somebody asked for.
#[derive(Debug, Default)]
pub struct Request {
    /// As it was sent.
    pub method: String,
    /// Without what follows a question mark.
    pub path: String,
    /// The host that the client believes to talk to.
    pub host: String,
    /// Where the page that asks is from; only browsers say so.
    pub origin: Option<String>,
    /// What the body is said to be.
    pub content_type: String,
    /// The body; nothing where there is none.
    pub body: Vec<u8>,
}

/// What the head says of itself and of the body.
#[derive(Debug)]
pub struct Head {
    /// Its own length.
    pub bytes: usize,
    /// How many bytes follow it, at most [`MOST_BODY_BYTES`].
    pub body_bytes: usize,
    /// Whether the client waits to be told that it may send them.
    pub is_asked_for: bool,
}

/// The head of a request, once all of it is there; the body is still to be read.
pub fn parse(bytes: &[u8]) -> Result<Option<(Request, Head)>, Refusal> {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let head_bytes = match parsed.parse(bytes) {
        Ok(httparse::Status::Complete(head_bytes)) => head_bytes,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(httparse::Error::TooManyHeaders) => return Err(head_too_large()),
        Err(error) => return Err(Refusal::new(400, format!("this is not HTTP/1.1: {error}"))),
    };
    let path = parsed.path.unwrap_or_default();
    let mut request = Request {
        method: parsed.method.unwrap_or_default().to_owned(),
        path: path.split('?').next().unwrap_or_default().to_owned(),
        ..Request::default()
    };
    let mut head = Head {
        bytes: head_bytes,
        body_bytes: 0,
        is_asked_for: false,
    };
    let (mut hosts, mut lengths) = (0, 0);
    for header in parsed.headers {
        let text = || String::from_utf8_lossy(header.value).into_owned();
        match header.name.to_ascii_lowercase().as_str() {
            "host" => {
                hosts += 1;
                request.host = text();
            }
            "origin" => request.origin = Some(text()),
            "content-type" => request.content_type = text(),
            "content-length" => {
                lengths += 1;
                head.body_bytes = body_bytes(&text())?;
            }
            "transfer-encoding" => {
                let mend = "send the body with a Content-Length, not in chunks";
                return Err(Refusal::new(411, mend));
            }
            "expect" => head.is_asked_for = true,
            _ => {}
        }
    }
    if hosts != 1 {
        return Err(Refusal::new(400, "a request names its Host once"));
    }
    if lengths > 1 {
        return Err(Refusal::new(400, "a request has one Content-Length"));
    }
    if request.method == "POST" && lengths == 0 {
        let mend = "a POST needs the Content-Length of its body";
        return Err(Refusal::new(411, mend));
    }
    Ok(Some((request, head)))
}

fn body_bytes(length: &str) -> Result<usize, Refusal> {
    let is_number = !length.is_empty() && length.bytes().all(|byte| byte.is_ascii_digit());
    if !is_number {
        let what = "Content-Length must be a number of bytes";
        return Err(Refusal::new(400, what));
    }
    // More digits than a number has are too many bytes as well.
    let bytes = length.parse().unwrap_or(usize::MAX);
    if bytes > MOST_BODY_BYTES {
        let what = format!("the body has {length} bytes: send at most {MOST_BODY_BYTES}");
        return Err(Refusal::new(413, what));
    }
    Ok(bytes)
}

/// For a head beyond the bounds.
pub fn head_too_large() -> Refusal {
    let what = format!(
        "the head is too large: at most {MOST_HEAD_BYTES} bytes and {MOST_HEADERS} headers"
    );
    Refusal::new(431, what)
}
