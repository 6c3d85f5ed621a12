//! What the playground's server is asked.

use super::one_line;
use super::program::head::{MOST_BODY_BYTES, parse};

/// A head that is read ends where it says, whatever follows it; what comes before its end is no head yet, or refused.
pub fn head(data: &[u8]) {
    match parse(data) {
        Err(refusal) => {
            assert!((400..500).contains(&refusal.status));
            one_line(&refusal.what);
        }
        Ok(None) => {}
        Ok(Some((request, head))) => {
            assert!(head.bytes <= data.len() && head.body_bytes <= MOST_BODY_BYTES);
            assert!(!request.method.is_empty() && request.body.is_empty());
            assert!(!request.path.contains('?'));
            let again = parse(&data[..head.bytes]);
            let (same, its_head) = again.ok().flatten().expect("all of the head is there");
            assert_eq!(
                format!("{its_head:?} {same:?}"),
                format!("{head:?} {request:?}")
            );
            let shorter = parse(&data[..head.bytes - 1]);
            assert!(!matches!(shorter, Ok(Some(_))), "it ends sooner");
        }
    }
}
