//! Plays a recording at its own pace, or another.

use std::time::Duration;

use super::read::{Film, Recorded};
use csat_mission::timing::Stopwatch;

/// The longest sleep, so that a user who ends it does not wait.
const NAP: Duration = Duration::from_millis(50);

/// Plays a film once: calls `show` with each document when its time has come, `speed` simulated
/// seconds per second, and `wait` with the simulated time while there is nothing to show. Ends early,
/// returning false, as soon as `goes_on` says no.
///
/// # Errors
/// The first of `show`.
pub fn play<E>(
    film: &Film,
    speed: f64,
    goes_on: impl Fn() -> bool,
    mut wait: impl FnMut(f64),
    mut show: impl FnMut(&Recorded) -> Result<(), E>,
) -> Result<bool, E> {
    let watch = Stopwatch::start();
    for recorded in &film.documents {
        loop {
            if !goes_on() {
                return Ok(false);
            }
            let now_s = watch.elapsed_s() * speed;
            let left_s = (recorded.time_s() - now_s) / speed;
            if left_s <= 0.0 {
                break;
            }
            wait(now_s);
            std::thread::sleep(Duration::from_secs_f64(left_s.min(NAP.as_secs_f64())));
        }
        show(recorded)?;
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_mission::documents::{Document, Encoding};
    use csat_proto::ids::RunId;
    use std::convert::Infallible;

    fn film() -> Film {
        let recorded = |tenths: u64| Recorded {
            time_ns: tenths * 100_000_000,
            document: Document {
                topic: "view/0/pose".to_owned(),
                encoding: Encoding::Json,
                body: tenths.to_string(),
            },
        };
        let documents = (0..5).map(recorded).collect();
        Film { run: RunId(1), scenario: "x".to_owned(), documents, warning: None }
    }

    #[test]
    fn documents_come_in_order_and_not_before_their_time() {
        let watch = Stopwatch::start();
        let mut shown = Vec::new();
        let ended = play(
            &film(),
            4.0,
            || true,
            |_| (),
            |recorded| {
                assert!(watch.elapsed_s() * 4.0 >= recorded.time_s());
                shown.push(recorded.document.body.clone());
                Ok::<_, Infallible>(())
            },
        );
        assert_eq!(ended, Ok(true));
        assert_eq!(shown, ["0", "1", "2", "3", "4"]);
    }

    #[test]
    fn it_ends_when_told_to() {
        let ended = play(&film(), 0.001, || false, |_| (), |_| Err("shown"));
        assert_eq!(ended, Ok(false));
    }
}
