//! What a step draws.

use motes_formulas::{FileModel, parse};
use motes_models::Step;
use motes_models::equations::{Draw, NoiseSpace};

/// Catches draws of one step taken for those of another with more sub-steps, and those of the start for later ones.
#[test]
fn draws_are_kept_for_the_start_and_for_a_sub_step() {
    let text = "[initial]\nx = \"normal(0, 1)\"\nn = \"poisson(3)\"\nz = \"x\"\n[transition]\nx = \"log_normal(x, 1)\"\nn = \"n\"\n\
                z = \"normal(z, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    let FileModel::Formulas(model) = parse(text, "m.toml", &[]).unwrap().model else {
        panic!("it has formulas");
    };
    let draws = |index, sub_steps| model.draws(&Step { sub_steps, ..Step::of_index(index) });
    let of_one = [Draw::Continuous, Draw::Normal];
    for sub_steps in [3, 1, 2, 0] {
        assert_eq!(draws(4, sub_steps), of_one.repeat(sub_steps));
        assert_eq!(draws(0, 1), [Draw::Normal, Draw::Count]);
    }
}
