//! Equations that are stated for many particles are the model that formulas state, to the last bit.

use std::cell::{Cell, RefCell};

use motes_models::batch::{LANES, Rows};
use motes_models::equations::{
    BatchDistribution, BatchEquations, Batched, Column, Coordinates, Distribution, Draws, Dual, Equations,
    Lanes, Scalar, Transport, laplace, log_normal, normal, poisson, student_t,
};
use motes_models::{
    ModelShape, OwnModel, OwnSteps, Seed, StateGradients, StateSpaceModel, Step, SystemGraph, simulate,
};

/// Three kinds of states, two of measurements; one of them has its scale from a state.
#[derive(Clone, Copy)]
struct ThreeDraws;

impl Equations for ThreeDraws {
    fn dimensions(&self) -> [usize; 2] {
        [3, 2]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(S::from(0.3), S::from(1.0)));
        x[1] = draws.draw(laplace(S::from(0.0), S::from(0.5)));
        x[2] = draws.draw(log_normal(S::from(0.0), S::from(0.3)));
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        before: &[S],
        draws: &mut impl Draws<S>,
        x: &mut [S],
    ) {
        x[0] = draws.draw(normal(before[0].sin() + before[1] * 0.5, (before[2] * 0.1).exp()));
        x[1] = draws.draw(laplace(before[1] * 0.9, S::from(0.3)).shifted(S::from(0.1 * step.time)));
        x[2] = draws.draw(log_normal(before[2].ln() * 0.8, S::from(0.2)).scaled(before[1].cos() * 0.1 + 1.0));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(poisson((x[0] * 0.3).exp() + x[2]));
        y.push(student_t(S::from(4.0), x[1] * x[0], S::from(0.5)));
    }
}

/// Numbers with a derivative along each state.
type Sloped = Dual<f64, 4>;

/// Collects the parameters of a row.
#[derive(Default)]
struct Row(Vec<Distribution<Sloped>>);

impl Draws<Sloped> for Row {
    fn draw(&mut self, distribution: Distribution<Sloped>) -> Sloped {
        self.0.push(distribution);
        Sloped::from(f64::NAN)
    }
}

impl Coordinates<Sloped> for Row {
    fn push(&mut self, distribution: Distribution<Sloped>) {
        self.0.push(distribution);
    }
}

/// The same model, asked row by row and told in columns.
struct InColumns {
    has_slopes: bool,
}

fn point(row: &[f64]) -> Vec<Sloped> {
    row.iter().enumerate().map(|(i, value)| Sloped::variable(*value, i)).collect()
}

fn columns(rows: &[Row]) -> Vec<BatchDistribution> {
    let column = |at: usize, of: &dyn Fn(&Distribution<Sloped>) -> Sloped| {
        let numbers: Vec<Sloped> = rows.iter().map(|row| of(&row.0[at])).collect();
        let slopes = (0..3).flat_map(|j| numbers.iter().map(move |number| number.derivatives()[j])).collect();
        Column::with_slopes(numbers.iter().map(|number| number.value()).collect(), slopes)
    };
    let parameters = |distribution: &Distribution<Sloped>| {
        let found = RefCell::new(Vec::new());
        distribution.map(|parameter| found.borrow_mut().push(*parameter));
        found.into_inner()
    };
    let of = |at: usize| {
        // The parameters of each family by their order.
        let next = Cell::new(0);
        BatchDistribution::new(rows[0].0[at].map(|_| {
            let number = next.replace(next.get() + 1);
            column(at, &|distribution| parameters(distribution)[number])
        }))
    };
    (0..rows[0].0.len()).map(of).collect()
}

impl BatchEquations for InColumns {
    fn dimensions(&self) -> [usize; 2] {
        ThreeDraws.dimensions()
    }

    fn initial(&self) -> Option<Vec<BatchDistribution>> {
        let mut row = Row::default();
        Step::of_index(0).lift(|step| ThreeDraws.initial(step, &mut row, &mut point(&[0.0; 3])));
        Some(columns(&[row]))
    }

    fn transition(&self, step: &Step<'_>, previous: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
        let of_row = |row: &[f64]| {
            let mut found = Row::default();
            step.lift(|step| ThreeDraws.transition(step, &point(row), &mut found, &mut point(row)));
            found
        };
        Some(columns(&previous.chunks_exact(3).map(of_row).collect::<Vec<_>>()))
    }

    fn measurement(&self, step: &Step<'_>, states: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
        let of_row = |row: &[f64]| {
            let mut found = Row::default();
            step.lift(|step| ThreeDraws.measurement(step, &point(row), &mut found));
            found
        };
        Some(columns(&states.chunks_exact(3).map(of_row).collect::<Vec<_>>()))
    }

    fn has_slopes(&self) -> bool {
        self.has_slopes
    }
}

fn batched(has_slopes: bool) -> Batched {
    Batched::new(InColumns { has_slopes })
}

/// States and measurements of one time.
fn step(particles: usize) -> [Vec<f64>; 3] {
    let mut steps = OwnSteps::new(&ThreeDraws, particles, &Seed::from_u64(5)).unwrap();
    steps.advance().unwrap();
    let step = steps.advance().unwrap();
    [step.previous.unwrap().to_vec(), step.states.to_vec(), step.measurements.to_vec()]
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn draws_and_densities_are_the_same_to_the_last_bit() {
    let model = batched(false);
    assert_eq!(
        simulate(&model, 20, &mut Seed::from_u64(1).stream()).unwrap(),
        simulate(&ThreeDraws, 20, &mut Seed::from_u64(1).stream()).unwrap()
    );
    for particles in [1, 31, 33, 500] {
        let [previous, states, measurements] = step(particles);
        let picked: Vec<usize> = (0..particles).map(|k| (7 * k) % particles).collect();
        let rows = Rows::picked(&previous, 3, &picked);
        let of = |model: &dyn AllOfIt| {
            let mut streams = [Seed::from_u64(2).stream()];
            let [mut drawn, mut later] = [vec![0.0; 3 * particles], vec![0.0; 3 * particles]];
            let mut counted = vec![0.0; 2 * particles];
            model.sample_states(&Step::of_index(0), None, &mut streams, &mut drawn);
            model.sample_states(&Step::of_index(1), Some(rows), &mut streams, &mut later);
            model.sample_measurements(&Step::of_index(1), &later, &mut streams, &mut counted);
            let mut densities = vec![vec![0.0; particles]; 5];
            model.density().unwrap().log_densities(&Step::of_index(0), None, &states, &mut densities[0]);
            model.density().unwrap().log_densities(
                &Step::of_index(1),
                Some(rows),
                &states,
                &mut densities[1],
            );
            let entries = [Some(measurements[0]), Some(measurements[1])];
            model.log_likelihoods(&Step::of_index(1), &states, &entries, &mut densities[2]).unwrap();
            model
                .log_likelihoods(&Step::of_index(1), &states, &[None, Some(0.4)], &mut densities[3])
                .unwrap();
            densities[4][0] =
                model.density().unwrap().log_density(&Step::of_index(1), Some(&previous[..3]), &states[..3]);
            bits(&[drawn, later, counted, densities.concat()].concat())
        };
        assert_eq!(of(&model), of(&ThreeDraws), "{particles} particles");
    }
}

/// All that a learned proposal asks of a model, and gradients.
trait AllOfIt: OwnModel + StateGradients {}
impl<M: OwnModel + StateGradients> AllOfIt for M {}

/// What proposals ask of the tiles of a block; the last tile has lanes without a particle, of which nothing is looked at.
fn of_tiles(model: &dyn AllOfIt, previous: &[f64], states: &[f64], is_foreseen: bool) -> [Vec<f64>; 2] {
    let particles = previous.len() / 3;
    let rows = Rows::all(previous, 3);
    if is_foreseen {
        model.foresee(&Step::of_index(1), rows);
    }
    let (mut exact, mut rounded) = (Vec::new(), Vec::new());
    let measurement = [Some(Lanes::from(2.0)), Some(Lanes::from(0.4))];
    for first in (0..particles).step_by(LANES) {
        let there = (particles - first).min(LANES);
        let mut before = vec![0.0; 3 * LANES];
        rows.load(first, &mut before);
        let keep = |kept: &mut Vec<f64>, tiles: &[f64]| {
            tiles.chunks(LANES).for_each(|row| kept.extend(&row[..there]));
        };
        let mut two = [vec![0.0; 3 * LANES], vec![0.0; 3 * LANES]];
        let [a, b] = &mut two;
        model.tile_moments(&Step::of_index(1), Some(&before), a, b);
        keep(&mut exact, &[a.as_slice(), b].concat());
        model.tile_centres(&Step::of_index(1), Some(&before), a, b);
        keep(&mut exact, &[a.as_slice(), b].concat());
        let centres = a.clone();
        let (mut slopes, mut information, mut jacobian) =
            (vec![0.0; 2 * LANES], vec![0.0; 2 * LANES], vec![0.0; 6 * LANES]);
        model.tile_scores(
            &Step::of_index(1),
            &centres,
            &measurement,
            &mut slopes,
            &mut information,
            &mut jacobian,
        );
        keep(&mut exact, &slopes);
        keep(&mut exact, &information);
        keep(&mut rounded, &jacobian);
        let mut values = vec![0.0; 3 * LANES];
        Rows::all(states, 3).load(first, &mut values);
        let mut log_slope = [0.0; LANES];
        model.tile_to_normal(&Step::of_index(1), Some(&before), &mut values, &mut log_slope);
        keep(&mut exact, &[values.as_slice(), &log_slope].concat());
        model.tile_from_normal(&Step::of_index(1), Some(&before), &mut values, &mut log_slope);
        keep(&mut exact, &[values.as_slice(), &log_slope].concat());
    }
    [exact, rounded]
}

#[test]
fn tiles_are_the_same_whether_they_were_foreseen_or_not() {
    for particles in [32, 45, 300] {
        let [previous, states, _] = step(particles);
        let expected = of_tiles(&ThreeDraws, &previous, &states, false);
        for (has_slopes, is_foreseen) in [(true, true), (true, false), (false, true), (false, false)] {
            let found = of_tiles(&batched(has_slopes), &previous, &states, is_foreseen);
            assert_eq!(bits(&found[0]), bits(&expected[0]), "{particles}, {has_slopes}, {is_foreseen}");
            match has_slopes {
                false => assert!(found[1].iter().all(|slope| *slope == 0.0)),
                true => near(&found[1], &expected[1]),
            }
        }
    }
}

#[test]
fn an_answer_for_some_particles_is_none_for_others() {
    let [previous, states, _] = step(64);
    for has_slopes in [true, false] {
        let model = batched(has_slopes);
        // The first tile of the other block begins with the last particle of this one.
        let last = previous.len() - 3;
        model.foresee(&Step::of_index(1), Rows::all(&previous[..33 * 3], 3));
        let mut out = [0.0];
        model
            .log_likelihoods(&Step::of_index(1), &states[last..], &[Some(2.0), Some(0.4)], &mut out)
            .unwrap();
        let mut other = previous[96..].to_vec();
        let mut others = states.clone();
        others[..3].copy_from_slice(&states[last..]);
        other[..3].copy_from_slice(&previous[96..99]);
        let expected = of_tiles(&ThreeDraws, &other, &others[..96], false);
        let found = of_tiles(&model, &other, &others[..96], true);
        assert_eq!(bits(&found[0]), bits(&expected[0]), "{has_slopes}");
    }
    // At t = 0 nothing is foreseen: one state was weighed before a tile that begins with it.
    let model = batched(false);
    let mut tile = vec![0.0; 3 * LANES];
    Rows::all(&states, 3).load(0, &mut tile);
    let scores = |model: &dyn AllOfIt| {
        let (mut slopes, mut information, mut jacobian) =
            (vec![0.0; 2 * LANES], vec![0.0; 2 * LANES], vec![0.0; 6 * LANES]);
        let measurement = [Some(Lanes::from(2.0)), None];
        model.tile_scores(
            &Step::of_index(0),
            &tile,
            &measurement,
            &mut slopes,
            &mut information,
            &mut jacobian,
        );
        [slopes, information].concat()
    };
    model.log_likelihood(&Step::of_index(0), &states[..3], &[2.0, 0.4]).unwrap();
    assert_eq!(bits(&scores(&model)), bits(&scores(&ThreeDraws)));
    assert_eq!(bits(&scores(&model)), bits(&scores(&ThreeDraws)), "asked again");
}

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{found} for {expected}");
    }
}

#[test]
fn gradients_follow_from_derivatives_of_parameters() {
    let [previous, states, measurements] = step(45);
    let of = |model: &dyn AllOfIt| {
        let mut found = vec![vec![0.0; states.len()]; 4];
        let [initial, before, now, likelihood] = &mut found[..] else { panic!("there are four") };
        model.initial_gradients(&Step::of_index(0), &states, initial);
        model.transition_gradients(&Step::of_index(1), &previous, &states, before, now);
        model.likelihood_gradients(&Step::of_index(1), &states, &measurements[..2], likelihood);
        found.concat()
    };
    near(&of(&batched(true)), &of(&ThreeDraws));
    assert!(batched(true).has_gradients() && !batched(false).has_gradients());
    assert!(of(&batched(false)).iter().skip(states.len()).all(|slope| slope.is_nan()));
}

#[test]
fn its_graph_is_that_of_the_formulas() {
    let seed = Seed::from_u64(3);
    let expected = SystemGraph::of_dependences(&ThreeDraws, &seed);
    assert_eq!(SystemGraph::of_dependences(&batched(true), &seed), expected);
    assert_eq!(ModelShape::of(&batched(false)), ModelShape::of(&ThreeDraws));
    assert!(!Transport::is_affine(&batched(false)));
}

/// What cannot be found.
struct Nothing;

impl BatchEquations for Nothing {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial(&self) -> Option<Vec<BatchDistribution>> {
        None
    }

    fn transition(&self, _: &Step<'_>, _: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
        None
    }

    fn measurement(&self, _: &Step<'_>, _: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
        Some(Vec::new())
    }
}

#[test]
fn what_is_not_found_or_ragged_is_not_a_number() {
    let model = Batched::new(Nothing);
    let mut state = [0.0];
    model.sample_states(
        &Step::of_index(0),
        None,
        std::slice::from_mut(&mut Seed::from_u64(1).stream()),
        &mut state,
    );
    assert!(state[0].is_nan());
    assert!(model.density().unwrap().log_density(&Step::of_index(1), Some(&[0.0]), &[0.0]).is_nan());
    assert!(model.log_likelihood(&Step::of_index(0), &[0.0], &[0.0]).unwrap().is_nan());
    let mut tile = [0.0; LANES];
    model.tile_from_normal(&Step::of_index(1), Some(&[0.0; LANES]), &mut tile, &mut [0.0; LANES]);
    assert!(tile.iter().all(|value| value.is_nan()));
}
