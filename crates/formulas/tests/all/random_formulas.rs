//! Formulas at random: values against another evaluation, derivatives against differences.

use motes_models::Step;
use motes_models::batch::LANES;
use motes_models::equations::{Dual, Lanes};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::helpers::{bits, cases, measurement, measuring};

/// A formula of `x`, `y` and `t`.
#[derive(Debug, Clone)]
enum Tree {
    Number(f64),
    X,
    Y,
    Time,
    OfOne(&'static str, Box<Tree>),
    OfTwo(&'static str, Box<Tree>, Box<Tree>),
    Power(Box<Tree>, i32),
    /// A comparison of two, and what is chosen by it.
    If(&'static str, [Box<Tree>; 4]),
}

/// How near a number is to where a function jumps.
fn distance_to_jump(name: &str, at: f64) -> f64 {
    match name {
        "floor" | "ceil" => (at - at.round()).abs(),
        "round" => (at - 0.5 - (at - 0.5).round()).abs(),
        "sign" => at.abs(),
        _ => f64::INFINITY,
    }
}

/// What is nearer to a jump is not compared.
const NEAR_JUMP: f64 = 1e-3;

impl Tree {
    /// With parentheses only where they may be needed: the order of operations is the parser's.
    fn text(&self) -> String {
        match self {
            Tree::Number(value) => format!("{value}"),
            Tree::X => "x".into(),
            Tree::Y => "y".into(),
            Tree::Time => "t".into(),
            Tree::OfOne("-", a) => format!("(-{})", a.text()),
            Tree::OfOne(name, a) => format!("{name}({})", a.text()),
            Tree::OfTwo(name @ ("min" | "max" | "atan2" | "mod"), a, b) => {
                format!("{name}({}, {})", a.text(), b.text())
            }
            Tree::OfTwo(sign, a, b) => format!("({} {sign} {})", a.text(), b.text()),
            Tree::Power(a, n) => format!("({})^{n}", a.text()),
            Tree::If(sign, of) => {
                let [a, b, then, otherwise] = of.each_ref().map(|part| part.text());
                format!("if(not ({a} {sign} {b}) or 1 > 2, {otherwise}, {then})")
            }
        }
    }

    /// By the standard library, node by node.
    fn value(&self, at: [f64; 3]) -> f64 {
        let [x, y, t] = at;
        match self {
            Tree::Number(value) => *value,
            Tree::X => x,
            Tree::Y => y,
            Tree::Time => t,
            Tree::OfOne(name, a) => {
                let a = a.value(at);
                match *name {
                    "-" => -a,
                    "sqrt" => a.sqrt(),
                    "exp" => a.exp(),
                    "log" => a.ln(),
                    "abs" => a.abs(),
                    "sin" => a.sin(),
                    "cos" => a.cos(),
                    "tanh" => a.tanh(),
                    "atan" => a.atan(),
                    "floor" => a.floor(),
                    "ceil" => a.ceil(),
                    "round" => (a + 0.5).floor(),
                    "sign" if a == 0.0 => 0.0,
                    "sign" => a.signum(),
                    "log1p" => a.ln_1p(),
                    "expm1" => a.exp_m1(),
                    "logistic" => 1.0 / (1.0 + (-a).exp()),
                    _ => f64::NAN,
                }
            }
            Tree::OfTwo(name, a, b) => {
                let (a, b) = (a.value(at), b.value(at));
                match *name {
                    "+" => a + b,
                    "-" => a - b,
                    "*" => a * b,
                    "/" => a / b,
                    "min" | "max" if a.is_nan() || b.is_nan() => f64::NAN,
                    "min" => a.min(b),
                    "max" => a.max(b),
                    "atan2" => a.atan2(b),
                    "mod" => a - b * (a / b).floor(),
                    _ => f64::NAN,
                }
            }
            Tree::Power(a, n) => a.value(at).powi(*n),
            Tree::If(sign, of) => {
                let [a, b] = [of[0].value(at), of[1].value(at)];
                let is_so = if *sign == "<" { a < b } else { a >= b };
                match a.is_nan() || b.is_nan() {
                    true => f64::NAN,
                    false => of[if is_so { 2 } else { 3 }].value(at),
                }
            }
        }
    }

    /// The largest number on the way: rounding is relative to it. Infinite where a small change of an operand changes all.
    fn size(&self, at: [f64; 3]) -> f64 {
        let own = self.value(at).abs();
        let below = match self {
            Tree::OfOne(name, a) => {
                let inner = a.value(at);
                let steep = match *name {
                    "exp" | "expm1" => inner.abs().max(1.0) * (own + 1.0),
                    "log" => 1.0,
                    "sin" | "cos" => inner.abs(),
                    _ => 1.0,
                };
                let is_near_end = matches!(*name, "log" | "sqrt" | "abs") && inner.abs() < 1e-3
                    || *name == "log1p" && inner < -0.999
                    || distance_to_jump(name, inner) < NEAR_JUMP.max(1e-12 * a.size(at));
                if is_near_end {
                    f64::INFINITY
                } else {
                    a.size(at) * steep.max(1.0) / inner.abs().clamp(1e-3, 1.0)
                }
            }
            Tree::OfTwo("/", a, b) => {
                let divisor = b.value(at).abs();
                if divisor < 1e-3 {
                    f64::INFINITY
                } else {
                    (a.size(at) + own * b.size(at)) / divisor.min(1.0)
                }
            }
            Tree::OfTwo("*", a, b) => {
                a.size(at) * b.value(at).abs().max(1.0) + b.size(at) * a.value(at).abs().max(1.0)
            }
            Tree::OfTwo("atan2", a, b) => {
                let radius = a.value(at).hypot(b.value(at));
                if radius < 1e-3 { f64::INFINITY } else { (a.size(at) + b.size(at)) / radius.min(1.0) }
            }
            Tree::OfTwo("mod", a, b) => {
                let (count, divisor) = (a.value(at) / b.value(at), b.value(at).abs());
                let size = a.size(at) + count.abs().ceil() * b.size(at);
                let is_near = distance_to_jump("floor", count) < NEAR_JUMP.max(1e-12 * size);
                if divisor < 1e-2 || is_near { f64::INFINITY } else { size / divisor.min(1.0) }
            }
            Tree::OfTwo(_, a, b) => a.size(at) + b.size(at),
            Tree::If(_, of) => {
                let compared = of[0].size(at) + of[1].size(at);
                let is_near = (of[0].value(at) - of[1].value(at)).abs() < NEAR_JUMP.max(1e-12 * compared);
                if is_near { f64::INFINITY } else { of[2].size(at) + of[3].size(at) }
            }
            Tree::Power(a, n) => {
                let inner = a.value(at).abs();
                if inner < 1e-3 {
                    f64::INFINITY
                } else {
                    f64::from(n.abs()) * own.max(1.0) * a.size(at) / inner.min(1.0)
                }
            }
            _ => 0.0,
        };
        // An infinity on the way can make the size NaN, which max() would drop.
        if below.is_nan() { f64::INFINITY } else { own.max(below).max(1.0) }
    }
}

fn trees() -> impl Strategy<Value = Tree> {
    let leaf = prop_oneof![
        (-4_i32..=4).prop_map(|n| Tree::Number(f64::from(n.abs()) * 0.75)),
        Just(Tree::X),
        Just(Tree::Y),
        Just(Tree::Time),
    ];
    leaf.prop_recursive(6, 40, 4, |inner| {
        let one = prop::sample::select(vec![
            "-", "sqrt", "exp", "log", "abs", "sin", "cos", "tanh", "atan", "floor", "ceil", "round", "sign",
            "log1p", "expm1", "logistic",
        ]);
        let two = prop::sample::select(vec!["+", "-", "*", "/", "min", "max", "atan2", "mod"]);
        prop_oneof![
            (one, inner.clone()).prop_map(|(name, a)| Tree::OfOne(name, Box::new(a))),
            (two, inner.clone(), inner.clone()).prop_map(|(name, a, b)| Tree::OfTwo(
                name,
                Box::new(a),
                Box::new(b)
            )),
            (inner.clone(), -3..=5_i32).prop_map(|(a, n)| Tree::Power(Box::new(a), n)),
            (prop::sample::select(vec!["<", ">="]), [inner.clone(), inner.clone(), inner.clone(), inner])
                .prop_map(|(sign, of)| Tree::If(sign, of.map(Box::new))),
        ]
    })
}

/// The formula of a tree as a mean, unless it is a constant out of range, which is refused.
fn mean_of(tree: &Tree) -> Option<motes_formulas::FormulaModel> {
    // With a state in it no formula is a constant.
    let text = format!("normal({} + 0*x, 1)", tree.text());
    tree.value([0.5, 0.5, 3.0]).is_finite().then(|| measuring(&text, ""))
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: cases(400),
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Catches constants that are folded wrongly, common parts that are none, registers that are overwritten.
    #[test]
    fn values_are_those_of_another_evaluation(tree in trees(), x in -3.0..3.0_f64, y in -3.0..3.0_f64, t in 0_usize..9) {
        let Some(model) = mean_of(&tree) else { return Ok(()) };
        let at = [x, y, t as f64];
        let (expected, size) = (tree.value(at), tree.size(at));
        let found = measurement(&model, t, &[x, y])[0].moments()[0];
        if size < 1e9 && expected.is_finite() {
            // Each of up to 80 operations may be off by a few units in the last place.
            let error = (found - expected).abs();
            prop_assert!(error <= 1e-13 * size, "{}: {found} for {expected}", tree.text());
        }
        let lanes = |own: f64, other: f64| -> Lanes { Lanes(std::array::from_fn(|lane| if lane % 2 == 0 { own } else { other })) };
        let side = measurement(&model, t, &[lanes(x, y), lanes(y, x)])[0].moments()[0];
        for lane in (0..LANES).step_by(2) {
            // NaN of any kind is NaN.
            prop_assert!(side.0[lane] == found || side.0[lane].is_nan() && found.is_nan(), "{}", tree.text());
        }
    }

    /// Catches an operation without its derivative.
    #[test]
    fn slopes_are_those_of_differences(tree in trees(), x in 0.2..2.0_f64, y in 0.2..2.0_f64) {
        type Number = Dual<f64, 3>;
        let Some(model) = mean_of(&tree) else { return Ok(()) };
        let found = measurement(&model, 2, &[Number::variable(x, 0), Number::variable(y, 1)])[0].moments()[0];
        for (direction, slope) in found.derivatives().iter().enumerate() {
            // Differences at two distances tell where the formula is smooth enough for them to be compared with.
            let [coarse, fine] = [2e-5, 1e-5].map(|step| {
                let [mut above, mut below] = [[x, y, 2.0]; 2];
                above[direction] += step;
                below[direction] -= step;
                (tree.value(above) - tree.value(below)) / (2.0 * step)
            });
            let size = tree.size([x, y, 2.0]);
            // Rounding of the difference, and four times what halving the step changed.
            let allowed = 1e-10 * size + 4.0 * (coarse - fine).abs() + 1e-9 * fine.abs();
            if fine.is_finite() && coarse.is_finite() && size < 1e3 && (coarse - fine).abs() < 1e-4 * (1.0 + fine.abs()) {
                prop_assert!((slope - fine).abs() <= allowed, "{} along {direction}: {slope} for {fine}", tree.text());
            }
        }
    }

    /// An explanation is there exactly where the value is none: the two evaluations agree.
    #[test]
    fn what_is_no_number_is_explained(tree in trees(), x in -3.0..3.0_f64, y in -3.0..3.0_f64) {
        let Some(model) = mean_of(&tree) else { return Ok(()) };
        let mean = measurement(&model, 2, &[x, y])[0].moments()[0];
        let explained = model.explain(&Step::of_index(2), Some(&[x, y]), Some(&[x, y]));
        prop_assert_eq!(explained.is_none(), mean.is_finite(), "{}: {} {:?}", tree.text(), mean, explained);
    }

    /// The same formula twice is the same bits: what is shared is the same.
    #[test]
    fn what_stands_twice_is_the_same(tree in trees(), x in -3.0..3.0_f64, y in -3.0..3.0_f64) {
        if mean_of(&tree).is_none() {
            return Ok(());
        }
        let text = tree.text();
        let model = measuring(&format!("normal({text} + 0*x, 1)"), &format!("w = \"normal(d + 0*x, 1)\"\n[definitions]\nd = \"{text}\"\n"));
        let means: Vec<f64> = measurement(&model, 2, &[x, y]).iter().map(|found| found.moments()[0]).collect();
        prop_assert!(bits(&means[..1]) == bits(&means[1..]) || means.iter().all(|mean| mean.is_nan()), "{}", text);
    }
}
