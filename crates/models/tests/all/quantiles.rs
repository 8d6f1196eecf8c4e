//! Transports of normal noise, number by number: against tables, back again, and against draws.

use motes_models::equations::{
    Distribution, Dual, Scalar, beta, binomial, exponential, gamma, laplace, log_normal, negative_binomial,
    normal, normal_quantile, poisson, student_t, uniform,
};
use motes_models::{Seed, fill_standard_normal};

/// Families, parameters and places of all kinds, in no place of their own: a mirrored one has its tails exchanged.
fn continuous() -> Vec<Distribution<f64>> {
    let plain = [
        normal(0.7, 1.4),
        student_t(0.8, 0.0, 1.0),
        student_t(4.5, 0.0, 1.4),
        student_t(700.0, 0.0, 0.3),
        student_t(3e5, 0.0, 0.3),
        laplace(0.0, 0.4),
        log_normal(0.3, 0.5),
        exponential(1.7),
        gamma(0.4, 2.0),
        gamma(1.0, 0.3),
        gamma(2.6, 0.8),
        gamma(900.0, 0.8),
        gamma(4e5, 0.8),
        beta(0.3, 2.0),
        beta(1.0, 3.0),
        beta(1.0, 1.0),
        beta(2.6, 1.8),
        beta(900.0, 20.0),
        beta(4e5, 2e5),
        uniform(0.0, 1.9),
    ];
    plain.into_iter().flat_map(|distribution| [distribution, distribution.scaled(-0.6)]).collect()
}

/// Numbers on both sides of 0, from `−most` to `most`, none of them round.
fn grid(most: f64, count: i32) -> impl Iterator<Item = f64> {
    (-count..=count).map(move |i| most * f64::from(i) / f64::from(count) + 1e-4 * f64::from(i).sin())
}

/// Quantiles of a distribution: `v` and `T(v)`.
type Row = (Distribution<f64>, &'static [(f64, f64)]);

/// Catches a wrong family, a tail computed from the other one, and a search that stops too early. The table is mpmath's, with 40 digits, but
/// for those of beta from 4e5 on, which are Boost's.
#[test]
fn quantiles_are_those_of_a_table() {
    let table: Vec<Row> = vec![
        (exponential(1.0), &[(8.0, 35.013437159915), (1.0, 1.8410216450093), (-8.0, 6.2209605742718e-16)]),
        (laplace(0.0, 1.0), &[(6.0, 20.043621769415), (0.001, 7.9820290701987e-4)]),
        (uniform(0.0, 1.0), &[(-8.0, 6.2209605742718e-16), (0.0, 0.5)]),
        (beta(0.1, 2.0), &[(-8.0, 3.34693777540043e-153), (0.3, 0.00313743153395277)]),
        (beta(2.0, 0.1), &[(-8.0, 1.06352417396155e-7)]),
        (
            beta(0.5, 0.5),
            &[(-8.0, 9.54892873223224e-31), (-1.0, 0.0608329540229506), (2.0, 0.99872349443018)],
        ),
        // Of a power of 1 in closed form.
        (beta(1.0, 1.0), &[(-8.0, 6.2209605742718e-16), (0.3, 0.6179114221889526)]),
        (beta(1.0, 3.0), &[(-2.0, 0.007641622975085902), (1.5, 0.5942351469872282)]),
        (beta(4.0, 1.0), &[(-3.0, 0.19167931161653265)]),
        (beta(3.0, 1.5), &[(-8.0, 6.57612640842029e-6), (-0.2, 0.646160419087459), (5.0, 0.999983747388272)]),
        (beta(80.0, 30.0), &[(-8.0, 0.353052364683663), (1.0, 0.769660541396847), (8.0, 0.955243297204719)]),
        (beta(900.0, 20.0), &[(-6.0, 0.936812033207761), (2.0, 0.986795835746742)]),
        (beta(20.0, 900.0), &[(-8.0, 0.00170563894453736), (-2.0, 0.013204164253258)]),
        (beta(4e5, 2e5), &[(-6.0, 0.6630087523754896), (1.5, 0.6675793055382309)]),
        (beta(1e7, 3.0), &[(-4.0, 0.9999984753523675)]),
        (beta(2.0, 1e8), &[(5.0, 1.800995981479517e-7)]),
        (beta(1e8, 1e8), &[(3.0, 0.5001060660161174)]),
        (gamma(0.1, 1.0), &[(0.01, 6.4250131321225e-4), (1.0, 0.12004253412959), (8.0, 29.680322992367)]),
        (gamma(0.9, 1.0), &[(-8.0, 1.2175147028814e-17), (-3.0, 6.2054818568108e-4), (4.0, 10.053853817737)]),
        (gamma(3.0, 1.0), &[(-8.0, 1.5512123390557e-5), (0.3, 3.189551791285), (8.0, 41.835572610073)]),
        (gamma(150.0, 1.0), &[(-8.0, 71.876256771993), (-3.0, 115.90821238081), (8.0, 269.91533254408)]),
        (gamma(9e4, 1.0), &[(-8.0, 87620.957602891), (1.0, 90299.999444527), (8.0, 92421.04204814)]),
        (gamma(2e5, 1.0), &[(-8.0, 196443.26283383), (4.0, 201793.85661274), (8.0, 203598.73700913)]),
        (
            student_t(0.3, 0.0, 1.0),
            &[(0.002, 3.4793895194099e-3), (1.0, 13.903422063798), (8.0, 1.4631946346073e49)],
        ),
        (
            student_t(1.0, 0.0, 1.0),
            &[(0.3, 0.38835753857298), (-4.0, -10050.439032691), (8.0, 5.1167320927934e14)],
        ),
        (
            student_t(3.5, 0.0, 1.0),
            &[(0.01, 0.010730907827242), (1.0, 1.1647761055119), (-8.0, -26070.189921792)],
        ),
        (student_t(30.0, 0.0, 1.0), &[(1.0, 1.016946754115), (4.0, 4.6451246994737), (8.0, 15.194553083066)]),
        (
            student_t(9900.0, 0.0, 1.0),
            &[(0.002, 2.0000505058901e-3), (1.0, 1.0000505076013), (8.0, 8.0131496181241)],
        ),
        (
            student_t(2e4, 0.0, 1.0),
            &[(1.0, 1.000025000625), (-4.0, -4.0008501603352), (8.0, 8.0065044828793)],
        ),
    ];
    for (distribution, row) in table {
        for &(v, expected) in row {
            let found = distribution.from_normal(v);
            assert!((found / expected - 1.0).abs() < 1e-10, "{distribution:?} at {v}: {found:e}");
        }
    }
}

/// Catches an inverse of another function: in the tails, at the changes between formulas, and of mirrored ones.
#[test]
fn there_and_back_is_where_one_was() {
    for distribution in continuous() {
        for v in grid(7.0, 500) {
            let x = distribution.from_normal(v);
            let back = distribution.to_normal(x);
            // Near an end of the range other than 0 numbers themselves lie apart: by half a unit of x, which the slope makes one of v.
            let density = distribution.log_density(x) + 0.5 * v * v;
            let grain = f64::EPSILON * x.abs() * density.exp() * 2.6;
            let error = (back - v).abs();
            assert!(error < 1e-8 * (1.0 + v.abs()) + grain, "{distribution:?} at {v}: {x:e}, back {back}");
        }
    }
}

/// Catches steps where formulas take turns: a transport that falls anywhere gives densities below 0.
#[test]
fn a_transport_grows_far_beyond_what_is_drawn() {
    for distribution in continuous() {
        let mut last = f64::NEG_INFINITY;
        for v in grid(60.0, 1500) {
            let x = distribution.from_normal(v);
            assert!(
                x >= last || x > last - 1e-13 * last.abs(),
                "{distribution:?} at {v}: {x:e} after {last:e}"
            );
            last = x;
        }
        let ends = [f64::NEG_INFINITY, f64::INFINITY].map(|v| distribution.from_normal(v));
        assert!(ends[0] < ends[1] && ends[1] >= last, "{distribution:?}: {ends:?}");
        for v in [-1e300, -1e5, 1e5, 1e300] {
            assert!(!distribution.from_normal(v).is_nan(), "{distribution:?} at {v}");
        }
        let inside = distribution.from_normal(0.3);
        assert!(ends[0] < inside && inside < ends[1]);
    }
}

/// Catches draws of another distribution: the two empirical distribution functions of as many draws differ by more than one time in a million.
#[test]
fn normal_noise_becomes_draws() {
    const DRAWS: usize = 20_000;
    for (number, distribution) in continuous().into_iter().enumerate() {
        let seed = Seed::from_u64(60).nth(number as u64);
        let mut transported = vec![0.0; DRAWS];
        fill_standard_normal(&mut seed.child("noise").stream(), &mut transported);
        transported.iter_mut().for_each(|v| *v = distribution.from_normal(*v));
        let mut stream = seed.child("draws").stream();
        let drawn: Vec<f64> = (0..DRAWS).map(|_| distribution.sample(&mut stream)).collect();
        let most = (-(0.5e-6_f64).ln() / DRAWS as f64).sqrt();
        let found = distance(transported, drawn);
        assert!(found < most, "{distribution:?}: {found} of {most}");
    }
}

/// Kolmogorov's and Smirnov's largest difference between the distribution functions of two samples of the same size.
fn distance(mut one: Vec<f64>, mut other: Vec<f64>) -> f64 {
    one.sort_by(f64::total_cmp);
    other.sort_by(f64::total_cmp);
    let below = |x: &f64| other.partition_point(|y| y <= x) as f64;
    let differences = one.iter().enumerate().map(|(rank, x)| ((rank + 1) as f64 - below(x)).abs());
    differences.fold(0.0, f64::max) / one.len() as f64
}

/// Catches an end of the range that becomes a finite number, and a NaN that is hidden.
#[test]
fn beyond_the_range_is_infinite_and_out_of_range_is_nan() {
    let ends: [(Distribution<f64>, f64, f64); 9] = [
        (beta(2.0, 0.5), 0.0, 1.0),
        (beta(2.0, 0.5).scaled(-2.0).shifted(1.0), -1.0, 1.0),
        (log_normal(0.3, 0.5), 0.0, f64::INFINITY),
        (exponential(2.0).shifted(1.0), 1.0, f64::INFINITY),
        (exponential(2.0).scaled(-1.0), f64::NEG_INFINITY, 0.0),
        (gamma(2.0, 0.5), 0.0, f64::INFINITY),
        (gamma(2.0, 0.5).scaled(-1.0), f64::NEG_INFINITY, 0.0),
        (log_normal(0.0, 1.0).scaled(-1.0).shifted(3.0), f64::NEG_INFINITY, 3.0),
        (uniform(-1.0, 2.0), -1.0, 2.0),
    ];
    let counts: [Distribution<f64>; 3] = [poisson(2.0), negative_binomial(2.0, 0.5), binomial(3.0, 0.5)];
    assert_eq!(counts.map(|count| count.ends()[1]), [f64::INFINITY, f64::INFINITY, 3.0]);
    assert_eq!(normal(0.0, 1.0).ends(), [f64::NEG_INFINITY, f64::INFINITY]);
    for (distribution, low, high) in ends {
        assert_eq!(distribution.ends(), [low, high], "{distribution:?}");
        for x in [low, low - 1.0] {
            assert_eq!(distribution.to_normal(x), f64::NEG_INFINITY, "{distribution:?} at {x}");
        }
        for x in [high, high + 1.0] {
            assert_eq!(distribution.to_normal(x), f64::INFINITY, "{distribution:?} at {x}");
        }
    }
    let wrong: [Distribution<f64>; 9] = [
        beta(1.0, 0.0),
        normal(0.0, -1.0),
        student_t(0.0, 0.0, 1.0),
        student_t(3.0, 0.0, -1.0),
        laplace(0.0, 0.0),
        log_normal(0.0, 0.0),
        exponential(0.0),
        gamma(-1.0, 1.0),
        uniform(1.0, 1.0),
    ];
    for distribution in wrong {
        for x in [-1.0, 0.0, 0.5] {
            assert!(distribution.from_normal(x).is_nan() && distribution.to_normal(x).is_nan());
        }
    }
    // Noise is transported to counts, and no count back.
    let counts: [Distribution<f64>; 3] = [poisson(2.0), negative_binomial(2.0, 1.0), binomial(3.0, 0.5)];
    for count in counts {
        assert!(count.from_normal(f64::NAN).is_nan() && count.to_normal(1.0).is_nan());
    }
    for distribution in continuous() {
        assert!(distribution.from_normal(f64::NAN).is_nan() && distribution.to_normal(f64::NAN).is_nan());
    }
}

/// Catches a tail without digits, and a share that is none.
#[test]
fn the_standard_normal_quantile_undoes_the_distribution_function() {
    for p in [1e-300, 1e-20, 1e-3, 0.3, 0.5, 0.7] {
        let v = normal_quantile(p);
        assert!((v.normal_cdf() / p - 1.0).abs() < 1e-12, "{p}: {v}");
    }
    assert!((normal_quantile(0.999) + normal_quantile(0.001)).abs() < 1e-12);
    assert_eq!([0.0, 1.0].map(normal_quantile), [f64::NEG_INFINITY, f64::INFINITY]);
    assert!([-0.1, 1.1, f64::NAN].map(normal_quantile).iter().all(|v| v.is_nan()));
}

/// Catches a quantile whose derivatives are not its own: in its argument, in where and how wide a distribution is, and in its shapes.
#[test]
fn quantiles_have_derivatives() {
    type Number = Dual<f64, 4>;
    fn all<S: Scalar>([a, b, x]: [S; 3]) -> Vec<S> {
        let scaled = |distribution: Distribution<S>| distribution.scaled(b).shifted(a * 0.2);
        let found = [
            normal(a, b),
            student_t(a * 3.0, a, b),
            laplace(a, b),
            log_normal(a, b),
            scaled(exponential(a)),
            scaled(exponential(a)).scaled(-1.0).shifted(3.0),
            scaled(gamma(a, b)),
            scaled(gamma(a, b)).scaled(-1.0).shifted(4.0),
            scaled(beta(a, b)).scaled(2.0),
            scaled(beta(b, a)).scaled(-2.0).shifted(2.0),
            uniform(a * -0.3, b * 6.0),
        ];
        found.iter().map(|distribution| distribution.to_normal(x)).collect()
    }
    for point in [[1.3, 0.7, 0.9], [0.8, 0.9, 1.2]] {
        let found = all([0, 1, 2].map(|direction| Number::variable(point[direction], direction)));
        for direction in 0..3 {
            let moved = |by: f64| {
                let mut moved = point;
                moved[direction] += by;
                all(moved)
            };
            let (up, down) = (moved(1e-5), moved(-1e-5));
            for (which, found) in found.iter().enumerate() {
                let difference = (up[which] - down[which]) / 2e-5;
                let error = (found.derivatives()[direction] - difference).abs();
                assert!(error < 1e-7 * (1.0 + difference.abs()), "{which}, direction {direction}: {error}");
            }
        }
    }
}
