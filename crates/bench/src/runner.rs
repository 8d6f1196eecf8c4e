//! Units on worker threads, each of which has helpers if there are few; each result is handed over as soon as it is there.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread::Builder;

use crate::evaluate::Evaluation;
use crate::threads;
use crate::unit::UnitConfig;
use crate::unit_error::UnitError;
use motes_cli::{Interrupt, status};

/// What a worker reports.
pub(crate) enum Event {
    /// It has begun unit number `.0`.
    Started(usize),
    /// It has ended unit number `.0`.
    Ended(usize, Result<Evaluation, UnitError>),
}

/// What evaluates a unit; the tests put something in its place that takes no time.
pub(crate) type Evaluate<'a> = dyn Fn(&UnitConfig, &Interrupt) -> Result<Evaluation, UnitError> + Sync + 'a;

/// Evaluates `units` on `jobs` threads and calls `observe` on the calling thread for each event.
///
/// Parallel units do not compete for cores: each has its share of the threads, one if there are units enough. The number of threads cannot
/// change a result. An error from `observe` (a result that cannot be stored) stops the run, as the interrupt does. Threads that the system
/// refuses are done without; if it refuses all of them, the calling one does their work.
pub(crate) fn run<E>(
    units: &[UnitConfig],
    jobs: usize,
    interrupt: &Interrupt,
    evaluate: &Evaluate<'_>,
    mut observe: impl FnMut(Event) -> Result<(), E>,
) -> Result<(), E> {
    let next = AtomicUsize::new(0);
    let take = || {
        let index = interrupt.check().is_continue().then(|| next.fetch_add(1, Ordering::Relaxed))?;
        units.get(index).map(|unit| (index, unit))
    };
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for (started, count) in threads::of_workers(jobs, units.len()).enumerate() {
            let (sender, take) = (sender.clone(), &take);
            let work = move || {
                while let Some((index, unit)) = take() {
                    // If nobody listens any more, nobody wants the result.
                    if sender.send(Event::Started(index)).is_err() {
                        return;
                    }
                    let result = guarded(|| evaluate(unit, interrupt));
                    if sender.send(Event::Ended(index, result)).is_err() {
                        return;
                    }
                }
            };
            if let Err(error) = Builder::new().spawn_scoped(scope, move || threads::on(count, work)) {
                status(&format!("the system refuses more than {started} threads: {error}"));
                if started == 0 {
                    while let Some((index, unit)) = take() {
                        observe(Event::Started(index))?;
                        observe(Event::Ended(index, guarded(|| evaluate(unit, interrupt))))?;
                    }
                }
                break;
            }
        }
        drop(sender);
        for event in receiver {
            if let Err(error) = observe(event) {
                interrupt.raise();
                return Err(error);
            }
        }
        Ok(())
    })
}

/// A panic inside a unit (a library's, say) fails that unit and not the run.
pub(crate) fn guarded(
    evaluate: impl FnOnce() -> Result<Evaluation, UnitError>,
) -> Result<Evaluation, UnitError> {
    catch_unwind(AssertUnwindSafe(evaluate)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        Err(UnitError::Failed(format!("panic: {text}")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::Metric;
    use crate::unit::tests::unit;

    fn fake(unit: &UnitConfig, _: &Interrupt) -> Result<Evaluation, UnitError> {
        match unit.repetition {
            3 => panic!("three"),
            4 => Err(UnitError::Failed("four".into())),
            repetition => {
                let metrics = vec![Metric::new("ess", repetition as f64)];
                Ok(Evaluation { metrics, timings: vec![], series: None, earlier: vec![] })
            }
        }
    }

    fn units(count: usize) -> Vec<UnitConfig> {
        (0..count).map(|repetition| UnitConfig { repetition, ..unit(10, 12, 10) }).collect()
    }

    #[test]
    fn every_unit_ends_once_and_a_failing_one_takes_no_other_with_it() {
        for jobs in [1, 2, 7] {
            let mut ends = vec![None; 6];
            run(&units(6), jobs, &Interrupt::default(), &fake, |event| {
                if let Event::Ended(index, result) = event {
                    assert!(ends[index].replace(result).is_none());
                }
                Ok::<(), ()>(())
            })
            .unwrap();
            let ends: Vec<_> = ends.into_iter().map(Option::unwrap).collect();
            assert_eq!(ends[3], Err(UnitError::Failed("panic: three".into())));
            assert_eq!(ends[4], Err(UnitError::Failed("four".into())));
            assert_eq!(ends[5].as_ref().unwrap().metrics[0].value, 5.0);
        }
    }

    #[test]
    fn a_unit_has_the_threads_that_no_other_needs() {
        for (count, expected) in [(1, 3), (3, 1)] {
            let evaluate = |_: &UnitConfig, _: &Interrupt| {
                let metrics = vec![Metric::new("threads", threads::here() as f64)];
                Ok(Evaluation { metrics, timings: vec![], series: None, earlier: vec![] })
            };
            run(&units(count), 3, &Interrupt::default(), &evaluate, |event| {
                if let Event::Ended(_, result) = event {
                    assert_eq!(result.unwrap().metrics[0].value, f64::from(expected));
                }
                Ok::<(), ()>(())
            })
            .unwrap();
        }
    }

    #[test]
    fn an_interrupt_and_a_failing_observer_stop_the_run() {
        let mut started = 0;
        let raise = |unit: &UnitConfig, interrupt: &Interrupt| {
            interrupt.raise();
            fake(unit, interrupt)
        };
        run(&units(3), 1, &Interrupt::default(), &raise, |event| {
            started += usize::from(matches!(event, Event::Started(_)));
            Ok::<(), ()>(())
        })
        .unwrap();
        assert_eq!(started, 1);
        let result = run(&units(3), 2, &Interrupt::default(), &fake, |_| Err("disk full"));
        assert_eq!(result, Err("disk full"));
    }
}
