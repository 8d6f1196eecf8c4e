//! Files of matrices are the model of these matrices.

use faer::mat;
use motes_formulas::{FileModel, parse};
use motes_models::{Gaussian, LinearGaussian, Seed, simulate};

use super::helpers::bits;

/// Catches matrices that are exchanged or transposed, and a mean that is lost.
#[test]
fn they_draw_the_same_bits() {
    let text = r#"
        name = "spring"
        kind = "linear-gaussian"
        states = ["position", "speed"]
        measurements = ["y", "z", "w"]
        m0 = [1, -2.5]
        P0 = [[1.0, 0.5], [0.5, 2]]
        A = [[1.0, 0.1], [-0.3, 0.9]]
        Q = [[0.1, 0.02], [0.02, 0.2]]
        C = [[1, 0], [0.5, 0.25], [0, 1]]
        R = [[0.5, 0, 0.1], [0, 0.25, 0], [0.1, 0, 1]]
    "#;
    let file = parse(text, "spring.toml", &[]).unwrap();
    assert_eq!((file.name.as_str(), file.parameters.len()), ("spring", 0));
    assert_eq!(
        (file.states.join(" "), file.measurements.join(" ")),
        ("position speed".into(), "y z w".into())
    );
    let FileModel::LinearGaussian(found) = file.model else { panic!("the file has matrices") };
    let expected = LinearGaussian::new(
        Gaussian::new("P_0", vec![1.0, -2.5], mat![[1.0, 0.5], [0.5, 2.0]]).unwrap(),
        mat![[1.0, 0.1], [-0.3, 0.9]],
        mat![[0.1, 0.02], [0.02, 0.2]],
        mat![[1.0, 0.0], [0.5, 0.25], [0.0, 1.0]],
        mat![[0.5, 0.0, 0.1], [0.0, 0.25, 0.0], [0.1, 0.0, 1.0]],
    )
    .unwrap();
    let draw = |model| simulate(model, 20, &mut Seed::from_u64(3).stream()).unwrap();
    let (found, expected) = (draw(&*found), draw(&expected));
    assert_eq!(bits(found.states.values()), bits(expected.states.values()));
    assert_eq!(bits(found.measurements.values()), bits(expected.measurements.values()));
}
