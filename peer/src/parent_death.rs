//! A child holds the end of a pipe as a leash: its standard input.

/// Calls `then` when whoever holds the other end is gone, however it went.
pub fn when_let_go(then: impl FnOnce() + Send + 'static) {
    std::thread::spawn(move || {
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        then();
    });
}
