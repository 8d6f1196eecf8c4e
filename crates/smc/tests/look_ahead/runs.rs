//! Steps that are alike are asked about together.

use motes_models::Step;
use motes_models::equations::{Coordinates, Draws, Equations, NoiseSpace, Scalar};

use crate::common::{evidence_of_runs, rows};
use crate::models::Volatility;

/// The model, which says of itself that it is the same at all times.
struct Timeless(Volatility);

impl Equations for Timeless {
    fn dimensions(&self) -> [usize; 2] {
        self.0.dimensions()
    }

    fn depends_on_time(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, step: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        self.0.initial(step, draws, x);
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        before: &[S],
        draws: &mut impl Draws<S>,
        x: &mut [S],
    ) {
        self.0.transition(step, before, draws, x);
    }

    fn measurement<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        self.0.measurement(step, x, y);
    }
}

/// Catches lanes and steps that are mixed up: measurements have gaps, and the last run ends before its tile.
#[test]
fn alike_steps_have_the_potentials_that_each_has_alone() {
    let rows = rows(&Volatility { sd: 0.3 }, 77, 4);
    let alone = evidence_of_runs(&Volatility { sd: 0.3 }, &rows, 50, 3, None);
    let together = evidence_of_runs(&Timeless(Volatility { sd: 0.3 }), &rows, 50, 3, None);
    for (one, other) in alone.iter().zip(&together) {
        assert!((one - other).abs() < 1e-9, "{one} {other}");
    }
}

#[test]
fn steps_are_alike_where_all_but_their_time_is_the_same() {
    let model = Timeless(Volatility { sd: 0.3 });
    let step = Step::of_index(3);
    assert!(model.are_alike(&step, &Step::of_index(4)));
    assert!(!model.0.are_alike(&step, &Step::of_index(4)) && model.0.are_alike(&step, &step));
    let others = [
        Step::of_index(0),
        Step { length: 2.0, ..Step::of_index(4) },
        Step { sub_steps: 2, ..Step::of_index(4) },
        Step { inputs: &[1.0], ..Step::of_index(4) },
        Step { parameters: &[1.0], ..Step::of_index(4) },
    ];
    assert!(others.iter().all(|other| !model.are_alike(&step, other)));
}
