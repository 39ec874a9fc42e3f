//! Writing to standard output and standard error, either of which its reader may have closed.
//!
//! A reader that closes its pipe early (`csat keys | head -1`) is no failure: the command drops what it
//! writes from then on, runs to its end and exits as if all had been read. The macros of the standard
//! library panic instead, so clippy forbids them here.

use std::io::{self, Write};

/// Writes a line to standard error, as `eprintln!` does; nothing happens when it is closed.
#[macro_export]
macro_rules! tell {
    ($($argument:tt)*) => {
        $crate::terminal::tell(format_args!($($argument)*))
    };
}

/// The function behind [`tell!`].
pub fn tell(line: std::fmt::Arguments<'_>) {
    // An error has nowhere to go.
    let _ = writeln!(io::stderr(), "{line}");
}

/// Writes to standard output.
///
/// # Errors
/// When the system refuses, as when the disk is full; not when the reader has closed its pipe.
pub fn say(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}
