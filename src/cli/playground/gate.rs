//! A line that carries nothing until somebody has been asked.
//!
//! To a head that it cannot read `hyper` answers by itself, without a word of why, and cannot be told otherwise. What it says
//! then ends here, and the client is told in the words of the others.

use std::io;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll};

use tokio::io::AsyncWrite;

/// Forgets what is written until it is opened.
pub struct Gate<'a, W> {
    writer: W,
    is_open: &'a AtomicBool,
}

impl<'a, W> Gate<'a, W> {
    pub const fn new(writer: W, is_open: &'a AtomicBool) -> Self {
        Self { writer, is_open }
    }

    /// The writer behind, where the gate is open.
    fn behind(self: Pin<&mut Self>) -> Option<Pin<&mut W>>
    where
        W: Unpin,
    {
        let is_open = self.is_open.load(Ordering::Relaxed);
        is_open.then(|| Pin::new(&mut self.get_mut().writer))
    }
}

impl<W: AsyncWrite + Unpin> AsyncWrite for Gate<'_, W> {
    fn poll_write(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        match self.behind() {
            Some(writer) => writer.poll_write(context, bytes),
            None => Poll::Ready(Ok(bytes.len())),
        }
    }

    fn poll_flush(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        match self.behind() {
            Some(writer) => writer.poll_flush(context),
            None => Poll::Ready(Ok(())),
        }
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        match self.behind() {
            Some(writer) => writer.poll_shutdown(context),
            None => Poll::Ready(Ok(())),
        }
    }
}
