//! Kalman filter and smoother against the dense joint Gaussian of all states and measurements, and NEES.

use faer::prelude::Solve;
use faer::{Col, Mat, Side, mat};
use motes_models::{
    Gaussian, LinearGaussian, Measurements, ModelError, PartialMeasurements, Seed, StateSpaceModel, kalman,
    simulate,
};

fn model() -> LinearGaussian {
    let initial =
        Gaussian::new("P_0", vec![0.5, -1.0, 0.2], mat![[1.0, 0.3, 0.0], [0.3, 2.0, -0.2], [0.0, -0.2, 0.7]])
            .unwrap();
    LinearGaussian::new(
        initial,
        mat![[0.9, 0.2, 0.0], [-0.1, 0.8, 0.3], [0.0, 0.1, 0.95]],
        mat![[0.5, 0.1, 0.0], [0.1, 0.4, 0.05], [0.0, 0.05, 0.3]],
        mat![[1.0, 0.0, 0.5], [0.0, 1.0, -0.3]],
        mat![[0.6, 0.1], [0.1, 0.9]],
    )
    .unwrap()
}

/// The joint mean and covariance of (x_0 … x_{T−1}, y_0 … y_{T−1}), written down without any recursion over beliefs.
fn joint(model: &LinearGaussian, horizon: usize) -> (Col<f64>, Mat<f64>) {
    use motes_models::AdditiveGaussian;
    let (n, m) = (model.state_dim(), model.measurement_dim());
    // z = F ξ + mean with ξ = (x_0 − μ₀, v_1, …, v_{T−1}, w_0, …, w_{T−1}) of block-diagonal covariance D.
    let size = horizon * (n + m);
    let mut f = Mat::<f64>::zeros(size, size);
    let mut d = Mat::<f64>::zeros(size, size);
    let mut mean = Col::<f64>::zeros(size);
    let mut power = vec![Mat::<f64>::identity(n, n)];
    for t in 1..horizon {
        power.push(model.transition_matrix() * &power[t - 1]);
    }
    let c = model.measurement_matrix();
    let initial_mean = Col::from_fn(n, |i| model.initial().mean()[i]);
    for t in 0..horizon {
        let (x, y) = (t * n, horizon * n + t * m);
        for s in 0..=t {
            let block = &power[t - s];
            f.submatrix_mut(x, s * n, n, n).copy_from(block);
            f.submatrix_mut(y, s * n, m, n).copy_from(c * block);
        }
        f.submatrix_mut(y, y, m, m).copy_from(Mat::<f64>::identity(m, m));
        let noise = if t == 0 { model.initial().covariance() } else { model.transition_covariance() };
        d.submatrix_mut(x, x, n, n).copy_from(noise);
        d.submatrix_mut(y, y, m, m).copy_from(model.measurement_covariance());
        let state_mean = &power[t] * &initial_mean;
        mean.subrows_mut(x, n).copy_from(&state_mean);
        mean.subrows_mut(y, m).copy_from(c * &state_mean);
    }
    (mean, &f * d * f.transpose())
}

/// Mean and covariance of the `n` coordinates from `at` on, given `values` of the coordinates `seen`.
fn condition(
    (mean, covariance): &(Col<f64>, Mat<f64>),
    at: usize,
    n: usize,
    seen: &[usize],
    values: &[f64],
) -> (Col<f64>, Mat<f64>) {
    let m = seen.len();
    let of_seen = Mat::from_fn(m, m, |i, j| covariance[(seen[i], seen[j])]);
    let s = of_seen.llt(Side::Lower).unwrap();
    let cross = Mat::from_fn(n, m, |i, j| covariance[(at + i, seen[j])]);
    let deviation = Col::from_fn(m, |i| values[i] - mean[seen[i]]);
    let kept = covariance.submatrix(at, at, n, n) - &cross * s.solve(cross.transpose());
    (mean.subrows(at, n) + cross * s.solve(&deviation), kept)
}

fn assert_close(found: impl Fn(usize, usize) -> f64, expected: &Mat<f64>) {
    for j in 0..expected.ncols() {
        for i in 0..expected.nrows() {
            let difference = (found(i, j) - expected[(i, j)]).abs();
            assert!(difference < 1e-10, "({i}, {j}) differs by {difference:e}");
        }
    }
}

/// Holds filter, smoother and evidence of measurements with gaps against the joint Gaussian.
fn assert_exact(model: &LinearGaussian, measurements: &PartialMeasurements) {
    let (n, m, horizon) = (model.state_dim(), model.measurement_dim(), measurements.len());
    let filtered = kalman::filter_partial(model, measurements).unwrap();
    let smoothed = kalman::smooth(&filtered).unwrap();
    let joint = joint(model, horizon);
    let entries: Vec<Option<f64>> = measurements.rows().flatten().copied().collect();
    // Which coordinates of the joint Gaussian the first `rows` measurements are, and their values.
    let seen = |rows: usize| -> (Vec<usize>, Vec<f64>) {
        let there = entries[..rows * m].iter().enumerate();
        there.filter_map(|(i, value)| Some((horizon * n + i, (*value)?))).unzip()
    };
    for t in 0..horizon {
        for (rows, belief) in [(t + 1, &filtered.steps[t].filtered), (horizon, &smoothed.beliefs[t])] {
            let (seen, values) = seen(rows);
            let (mean, covariance) = condition(&joint, t * n, n, &seen, &values);
            assert_close(|i, _| belief.mean[i], &Mat::from_fn(n, 1, |i, _| mean[i]));
            assert_close(|i, j| belief.covariance[(i, j)], &covariance);
        }
    }
    let (seen, values) = seen(horizon);
    let of_seen = Mat::from_fn(seen.len(), seen.len(), |i, j| joint.1[(seen[i], seen[j])]);
    let means = seen.iter().map(|&i| joint.0[i]).collect();
    let marginal = Gaussian::new("joint", means, symmetric(of_seen)).unwrap();
    assert!((filtered.log_evidence() - marginal.log_density(&values)).abs() < 1e-10);
}

fn simulated(horizon: usize) -> Measurements {
    simulate(&model(), horizon, &mut Seed::from_u64(4).stream()).unwrap().measurements
}

#[test]
fn filter_smoother_and_evidence_agree_with_the_dense_joint_gaussian() {
    assert_exact(&model(), &PartialMeasurements::from(&simulated(6)));
}

#[test]
fn so_they_do_where_measurements_are_missing() {
    // An entry of the first measurement, the whole third, an entry of the fifth, the whole last.
    let missing = [1, 4, 5, 8, 10, 11];
    let values = simulated(6)
        .values()
        .iter()
        .enumerate()
        .map(|(i, &v)| (!missing.contains(&i)).then_some(v))
        .collect();
    assert_exact(&model(), &PartialMeasurements::new(2, values).unwrap());
}

fn symmetric(matrix: Mat<f64>) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| 0.5 * (matrix[(i, j)] + matrix[(j, i)]))
}

#[test]
fn normalised_estimation_error_squared_is_chi_squared() {
    let (model, horizon, runs) = (model(), 8, 2000);
    let n = model.state_dim();
    let seed = Seed::from_u64(6);
    let (mut sums, mut smoothed_sums) = (vec![], vec![]);
    for run in 0..runs {
        let trajectory = simulate(&model, horizon, &mut seed.nth(run).stream()).unwrap();
        let filtered = kalman::filter(&model, &trajectory.measurements).unwrap();
        let smoothed = kalman::smooth(&filtered).unwrap();
        let nees = |belief: &kalman::Belief, t: usize| {
            let truth = trajectory.states.row(t);
            let error = Col::from_fn(n, |i| truth[i] - belief.mean[i]);
            error.transpose() * belief.covariance.llt(Side::Lower).unwrap().solve(&error)
        };
        sums.push(nees(&filtered.steps[horizon - 1].filtered, horizon - 1));
        smoothed_sums.push(nees(&smoothed.beliefs[horizon / 2], horizon / 2));
    }
    // χ²_N has mean N and variance 2N.
    for sums in [sums, smoothed_sums] {
        let mean = sums.iter().sum::<f64>() / runs as f64;
        let z = (mean - n as f64) / (2.0 * n as f64 / runs as f64).sqrt();
        assert!(z.abs() < 5.0, "NEES has mean {mean}, z = {z}");
    }
}

#[test]
fn measurements_of_the_wrong_width_are_refused() {
    let error = kalman::filter(&model(), &Measurements::new(3, vec![0.0; 6]).unwrap()).unwrap_err();
    assert_eq!(error.to_string(), "measurements have width 3; this model measures 2 numbers at each time");
}

#[test]
fn what_leaves_the_range_of_numbers_is_refused_with_its_time() {
    let failed_at = |result: Result<kalman::Filtered, ModelError>| match result {
        Err(ModelError::Numerical { time, .. }) => time,
        other => panic!("{other:?}"),
    };
    let measured = |values: &[f64]| Measurements::new(2, values.to_vec()).unwrap();
    for value in [1e300, -1e200, f64::MAX] {
        assert_eq!(failed_at(kalman::filter(&model(), &measured(&[0.1, 0.2, 0.3, value, 0.0, 0.0]))), 1);
    }
    let error = kalman::filter(&model(), &measured(&[1e300, 0.0])).unwrap_err();
    let expected = "correcting a belief failed at time 0: the log-density of the measurement is -inf";
    assert_eq!(error.to_string(), expected);
    assert!(kalman::filter(&model(), &measured(&[1e100, 0.0])).is_ok());

    // A belief that nothing corrects grows by a factor of 10¹⁰⁰ at each time.
    let initial = Gaussian::new("P_0", vec![1.0], mat![[1.0]]).unwrap();
    let one = || mat![[1.0]];
    let growing = LinearGaussian::new(initial, mat![[1e100]], one(), one(), one()).unwrap();
    let gaps = PartialMeasurements::new(1, vec![None; 5]).unwrap();
    assert_eq!(failed_at(kalman::filter_partial(&growing, &gaps)), 2);
}
