//! What does not fit the networks is refused with what was found and what was expected; what was there before stays.

use motes_models::Seed;
use motes_networks::layers::{Cell, Mlp, RecurrentLayer};
use motes_networks::{
    Arithmetic, Backend, Compute, Inference, Inputs, Known, NetworkError, NetworkTape, Networks, Outputs,
    Parameters, Precision, SliceMut, Workspace,
};

/// A recurrent layer of three hidden values, of which come two numbers and one: for states of two coordinates and one that is measured.
#[derive(Clone)]
struct Small {
    layer: RecurrentLayer,
    heads: [Mlp; 2],
    /// Whether what it carries on is left out, which its [`Networks::hidden_widths`] deny.
    forgets: bool,
}

impl Networks for Small {
    fn horizon(&self) -> Option<usize> {
        Some(2)
    }

    fn hidden_widths(&self) -> Vec<usize> {
        self.layer.carried_widths()
    }

    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        _time: usize,
        known: Known<'_, A::Rows>,
    ) -> Outputs<A::Rows> {
        let inputs = arithmetic.stacked(&known.previous, &known.measurement);
        let hidden = self.layer.forward(arithmetic, &inputs, known.hidden);
        let values: Vec<A::Rows> =
            self.heads.iter().map(|head| head.forward(arithmetic, hidden[0].clone())).collect();
        Outputs::new(values, if self.forgets { Vec::new() } else { hidden })
    }
}

fn made(backend: Backend, precision: Precision) -> (Small, Parameters) {
    let (mut weights, seed) = (Parameters::new(Compute { backend, precision }), Seed::from_u64(1));
    let layer = RecurrentLayer::draw(&mut weights, "layer", Cell::Elman, [3, 3], &seed);
    let heads = [("wide", 2), ("narrow", 1)].map(|(name, to)| Mlp::draw(&mut weights, name, &[3, to], &seed));
    (Small { layer, heads, forgets: false }, weights)
}

/// Each backend that was built, in 64 bits.
fn each(check: impl Fn(Small, Parameters)) {
    Backend::built(Precision::F64).for_each(|backend| {
        let (networks, weights) = made(backend, Precision::F64);
        check(networks, weights);
    });
}

const PREVIOUS: [f64; 8] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];

fn later() -> Inputs<'static> {
    Inputs { time: 1, width: 2, previous: Some(&PREVIOUS), measurement: &[0.5], particles: 4 }
}

fn first() -> Inputs<'static> {
    Inputs { time: 0, previous: None, ..later() }
}

fn shape<T>(what: &'static str, found: usize, expected: usize) -> Result<T, NetworkError> {
    Err(NetworkError::Shape { what, found, expected })
}

/// Runs with places of these lengths; they must be as they were if that is refused.
fn run(
    (networks, weights): (&Small, &Parameters),
    inputs: &Inputs<'_>,
    hidden: &[usize],
    outputs: &[usize],
) -> Result<(), NetworkError> {
    let of = |lengths: &[usize]| lengths.iter().map(|length| vec![0.25; *length]).collect::<Vec<_>>();
    let (mut hidden, mut outputs) = (of(hidden), of(outputs));
    let mut slices: Vec<SliceMut<'_>> = hidden.iter_mut().map(|values| SliceMut::F64(values)).collect();
    let mut places: Vec<&mut [f64]> = outputs.iter_mut().map(Vec::as_mut_slice).collect();
    let found = Inference::default().run(networks, weights, inputs, &mut slices, &mut places);
    if found.is_err() {
        assert!(hidden.iter().chain(&outputs).flatten().all(|value| *value == 0.25), "something was written");
    } else if inputs.particles > 0 {
        assert!(hidden.iter().chain(&outputs).flatten().all(|value| *value != 0.25), "something is missing");
    }
    found
}

#[test]
fn inference_refuses_what_does_not_fit() {
    each(|networks, weights| {
        let of = (&networks, &weights);
        for inputs in [first(), later()] {
            assert_eq!(run(of, &inputs, &[12], &[8, 4]), Ok(()));
            assert_eq!(run(of, &inputs, &[12], &[8]), shape("the number of outputs", 1, 2));
            assert_eq!(run(of, &inputs, &[12], &[8, 4, 4]), shape("the number of outputs", 3, 2));
            assert_eq!(run(of, &inputs, &[12], &[8, 8]), shape("the length of an output", 8, 4));
            assert_eq!(run(of, &inputs, &[12], &[7, 4]), shape("the length of an output", 7, 8));
            assert_eq!(
                run(of, &inputs, &[], &[8, 4]),
                shape("the number of matrices of hidden values", 0, 1)
            );
            let said = shape("the number of matrices of hidden values", 2, 1);
            assert_eq!(run(of, &inputs, &[12, 12], &[8, 4]), said);
            let said = shape("the length of a matrix of hidden values", 16, 12);
            assert_eq!(run(of, &inputs, &[16], &[8, 4]), said);
        }
        let short = Inputs { previous: Some(&PREVIOUS[1..]), ..later() };
        assert_eq!(run(of, &short, &[12], &[8, 4]), shape("the length of x_{t−1}", 7, 8));
        let flat = Inputs { width: 0, previous: Some(&[]), ..later() };
        let said = Err(NetworkError::Empty { what: "the width of a state" });
        assert_eq!(run(of, &flat, &[12], &[8, 4]), said);
        let late = Inputs { time: 2, ..later() };
        let said = Err(NetworkError::PastHorizon { horizon: 2, time: 2 });
        assert_eq!(run(of, &late, &[12], &[8, 4]), said);
    });
}

#[test]
fn no_particle_is_no_error() {
    each(|networks, weights| {
        let (of, none) = ((&networks, &weights), Inputs { particles: 0, previous: Some(&[]), ..later() });
        assert_eq!(run(of, &none, &[0], &[0, 0]), Ok(()));
        assert_eq!(run(of, &none, &[0], &[0, 2]), shape("the length of an output", 2, 0));
    });
}

#[test]
fn networks_that_forget_what_they_should_carry_are_refused() {
    each(|networks, weights| {
        let networks = Small { forgets: true, ..networks };
        let said = "the number of matrices of hidden values";
        assert_eq!(run((&networks, &weights), &later(), &[12], &[8, 4]), shape(said, 1, 0));
        let mut tape = NetworkTape::new(&networks, &weights, 4, Workspace::new(&weights)).unwrap();
        let (mut wide, mut narrow) = ([0.0; 8], [0.0; 4]);
        assert!(matches!(
            tape.forward(&first(), &mut [&mut wide, &mut narrow]),
            Err(NetworkError::Shape { what, .. }) if what == said
        ));
    });
}

#[test]
fn hidden_values_in_another_precision_are_refused() {
    for backend in Backend::built(Precision::F32) {
        let (networks, weights) = made(backend, Precision::F32);
        let (mut hidden, mut wide, mut narrow) = ([0.0; 12], [0.0; 8], [0.0; 4]);
        let found = Inference::default().run(
            &networks,
            &weights,
            &later(),
            &mut [SliceMut::F64(&mut hidden)],
            &mut [&mut wide, &mut narrow],
        );
        let said = NetworkError::Precision { found: Precision::F64, expected: Precision::F32 };
        assert_eq!(found, Err(said));
    }
}

/// What a step forward gives into places of these lengths.
fn forward(
    tape: &mut NetworkTape<'_, Small>,
    inputs: &Inputs<'_>,
    outputs: &[usize],
) -> Result<Vec<f64>, NetworkError> {
    let mut outputs: Vec<Vec<f64>> = outputs.iter().map(|length| vec![0.0; *length]).collect();
    let mut places: Vec<&mut [f64]> = outputs.iter_mut().map(Vec::as_mut_slice).collect();
    tape.forward(inputs, &mut places)?;
    Ok(outputs.concat())
}

#[test]
fn a_recording_refuses_what_does_not_fit_and_goes_on_as_if_it_had_not_been_asked() {
    each(|networks, weights| {
        let tape = || NetworkTape::new(&networks, &weights, 4, Workspace::new(&weights)).unwrap();
        let (mut disturbed, mut plain) = (tape(), tape());
        for inputs in [first(), later()] {
            let tape = &mut disturbed;
            assert_eq!(forward(tape, &inputs, &[8]), shape("the number of outputs", 1, 2));
            assert_eq!(forward(tape, &inputs, &[8, 3]), shape("the length of an output", 3, 4));
            let fewer = Inputs { particles: 3, previous: inputs.previous.map(|_| &PREVIOUS[..6]), ..inputs };
            assert_eq!(forward(tape, &fewer, &[6, 3]), shape("the number of particles", 3, 4));
            let short = Inputs { previous: Some(&PREVIOUS[1..]), ..inputs };
            assert_eq!(forward(tape, &short, &[8, 4]), shape("the length of x_{t−1}", 7, 8));
            let late = Inputs { time: 2, ..inputs };
            let said = Err(NetworkError::PastHorizon { horizon: 2, time: 2 });
            assert_eq!(forward(tape, &late, &[8, 4]), said);
            assert_eq!(forward(tape, &inputs, &[8, 4]), forward(&mut plain, &inputs, &[8, 4]));
        }
        let (wide, narrow) = ([0.3; 8], [0.7; 4]);
        for _ in 0..2 {
            let mut d = [0.0; 8];
            let found = disturbed.backward(&[&wide], &mut d);
            assert_eq!(found, shape("the number of derivatives of outputs", 1, 2));
            let found = disturbed.backward(&[&wide, &wide], &mut d);
            assert_eq!(found, shape("the length of the derivative of an output", 8, 4));
            let found = disturbed.backward(&[&wide, &narrow], &mut d[1..]);
            assert_eq!(found, shape("the length of the derivative of x_{t−1}", 7, 8));
            let mut expected = [0.0; 8];
            disturbed.backward(&[&wide, &narrow], &mut d).unwrap();
            plain.backward(&[&wide, &narrow], &mut expected).unwrap();
            assert_eq!(d, expected);
        }
        let [found, expected] = [disturbed, plain].map(|tape| {
            let gradients = tape.finish().into_gradients();
            (0..weights.len()).map(|index| gradients.host(index)).collect::<Vec<_>>()
        });
        assert_eq!(found, expected);
    });
}

/// What particles carry into a step has a row for each of them after the first state, and only then.
#[test]
fn a_native_recording_begins_before_the_first_state_and_does_not_go_back_to_it() {
    let (networks, weights) = made(Backend::Native, Precision::F64);
    let mut tape = NetworkTape::new(&networks, &weights, 4, Workspace::new(&weights)).unwrap();
    let said = "the length of a matrix of hidden values";
    assert_eq!(forward(&mut tape, &later(), &[8, 4]), shape(said, 3, 12));
    forward(&mut tape, &first(), &[8, 4]).unwrap();
    assert_eq!(forward(&mut tape, &first(), &[8, 4]), shape(said, 12, 3));
}

#[test]
fn a_recording_of_nothing_or_in_the_workspace_of_other_weights_is_refused() {
    each(|networks, weights| {
        let refused = |particles: usize, workspace: Workspace| {
            NetworkTape::new(&networks, &weights, particles, workspace).err().unwrap()
        };
        let none = NetworkError::Empty { what: "the number of particles" };
        assert_eq!(refused(0, Workspace::new(&weights)), none);
        let mut more = weights.clone();
        more.draw("more".into(), [1, 1], 1.0, &Seed::from_u64(2));
        assert_eq!(refused(4, Workspace::new(&more)), NetworkError::Workspace);
        let (_, narrow) = made(weights.compute().backend, Precision::F32);
        assert_eq!(refused(4, Workspace::new(&narrow)), NetworkError::Workspace);
    });
}
