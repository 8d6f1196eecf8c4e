//! Saved proposals: what comes back is what was saved, and what does not fit is refused in one line.

use std::path::Path;

use faer::{Mat, mat};
use motes_models::{Gaussian, GraphDiffusion, GraphDiffusionConfig, LinearGaussian, ModelShape, Noise, Seed};
use motes_proposals::{
    Adapter, Backend, Cell, Compute, Family, Fcnn, FcnnConfig, Gnn, GnnConfig, Learnable, OverTime,
    Parametric, Psi, PsiConfig, Rnn, SavedError, load, save,
};
use motes_tests::{reference, small_fcnn, small_gnn, small_psi, small_rnn, trained_family};
use motes_train::TrainConfig;

fn system() -> GraphDiffusion {
    GraphDiffusion::random(&GraphDiffusionConfig::new(5), &mut Seed::from_u64(120).stream()).unwrap()
}

fn compute() -> Compute {
    Backend::Native.into()
}

fn weights(proposal: &dyn Learnable) -> Vec<Vec<f64>> {
    (0..proposal.parameters().len()).map(|at| proposal.parameters().host(at)).collect()
}

fn back_and_forth<F: Family + Learnable>(folder: &Path, config: &F::Config) {
    let (system, folder) = (system(), folder.join(F::NAME));
    let trained: F = trained_family(config, &system, 3, compute());
    // Twice: the second replaces the first.
    for _ in 0..2 {
        save(&folder, &trained, &system, &ModelShape::on_graph(&system), &TrainConfig::paper(10)).unwrap();
    }
    let loaded: F = load(&folder, &system, &ModelShape::on_graph(&system), compute()).unwrap();
    assert_eq!(weights(&loaded), weights(&trained));
    assert_eq!(loaded.horizon(), trained.horizon());
    let names: Vec<_> =
        std::fs::read_dir(folder.parent().unwrap()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(names.iter().all(|name| !name.to_string_lossy().contains("partial")), "{names:?}");
    // A path may end in a separator.
    save(&folder.join(""), &trained, &system, &ModelShape::on_graph(&system), &TrainConfig::paper(10))
        .unwrap();
    // Weights of another precision fit too.
    let wide = Compute { precision: motes_proposals::Precision::F64, ..compute() };
    let loaded: F = load(&folder, &system, &ModelShape::on_graph(&system), wide).unwrap();
    assert_eq!(weights(&loaded), weights(&trained));
}

#[test]
fn every_family_comes_back_as_it_was_saved() {
    let folder = tempfile::tempdir().unwrap();
    back_and_forth::<Fcnn>(folder.path(), &small_fcnn());
    back_and_forth::<Rnn>(folder.path(), &small_rnn(Cell::Gru));
    back_and_forth::<Gnn>(folder.path(), &small_gnn(Adapter::Learned));
    back_and_forth::<Psi>(folder.path(), &small_psi());
}

#[test]
fn so_does_one_whose_networks_are_shared_over_time() {
    let (folder, networks) = (tempfile::tempdir().unwrap(), OverTime::Shared);
    back_and_forth::<Fcnn>(folder.path(), &FcnnConfig { networks, ..small_fcnn() });
    back_and_forth::<Gnn>(folder.path(), &GnnConfig { networks, ..small_gnn(Adapter::Learned) });
    back_and_forth::<Psi>(folder.path(), &PsiConfig { networks, ..small_psi() });
    for family in ["fcnn", "gnn", "psi"] {
        let text = std::fs::read_to_string(folder.path().join(family).join("proposal.toml")).unwrap();
        assert!(text.contains("networks = \"shared\"") && !text.contains("horizon"), "{text}");
    }
}

/// Files of before the setting have no word of it, and go on meaning the same.
#[test]
fn a_network_for_each_time_is_saved_as_ever() {
    let (folder, system) = (tempfile::tempdir().unwrap(), system());
    back_and_forth::<Fcnn>(folder.path(), &small_fcnn());
    let folder = folder.path().join("fcnn");
    let text = std::fs::read_to_string(folder.join("proposal.toml")).unwrap();
    assert!(!text.contains("networks"), "{text}");
    let loaded: Fcnn = load(&folder, &system, &ModelShape::on_graph(&system), compute()).unwrap();
    assert_eq!(loaded.config().networks, OverTime::EachTime);
}

#[test]
fn what_else_lies_in_a_replaced_folder_is_kept_each_time() {
    let (folder, system) = (tempfile::tempdir().unwrap(), system());
    let rnn =
        Rnn::create(&small_rnn(Cell::Lstm), &ModelShape::of(&system), 0, compute(), &Seed::from_u64(121))
            .unwrap();
    let saved = folder.path().join("rnn");
    save(&saved, &rnn, &system, &ModelShape::of(&system), &TrainConfig::paper(10)).unwrap();
    for note in ["first", "second", "third"] {
        std::fs::write(saved.join("notes.txt"), note).unwrap();
        save(&saved, &rnn, &system, &ModelShape::of(&system), &TrainConfig::paper(10)).unwrap();
        load::<Rnn>(&saved, &system, &ModelShape::of(&system), compute()).unwrap();
    }
    let others = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    let mut notes: Vec<String> =
        others.filter_map(|path| std::fs::read_to_string(path.join("notes.txt")).ok()).collect();
    notes.sort();
    assert_eq!(notes, ["first", "second", "third"]);
}

/// Additive noise has the same density wherever it is added, and the last coordinate is two steps from the one that is measured.
#[test]
fn a_parameter_that_moves_unmeasured_coordinates_is_noticed() {
    let chain = |last: f64| {
        let initial = Gaussian::new("P_0", vec![0.0; 3], Mat::identity(3, 3)).unwrap();
        let transition = mat![[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, last]];
        let (q, c) = (Mat::identity(3, 3), mat![[1.0, 0.0, 0.0]]);
        LinearGaussian::new(initial, transition, q, c, mat![[1.0]]).unwrap()
    };
    let (folder, config) = (tempfile::tempdir().unwrap(), small_rnn(Cell::Gru));
    let shape = ModelShape::of(&chain(0.95));
    let rnn = Rnn::create(&config, &shape, 0, compute(), &Seed::from_u64(121)).unwrap();
    let folder = folder.path().join("rnn");
    save(&folder, &rnn, &chain(0.95), &shape, &TrainConfig::paper(10)).unwrap();
    assert!(load::<Rnn>(&folder, &chain(0.95), &shape, compute()).is_ok());
    let error = load::<Rnn>(&folder, &chain(0.2), &shape, compute())
        .err()
        .expect("another system was taken for the same");
    assert!(error.to_string().contains("a fixed draw of x_1"), "{error}");
}

/// A saved rnn, changed on disk, and what loading it says.
fn told(change: impl FnOnce(&Path)) -> String {
    let (folder, system) = (tempfile::tempdir().unwrap(), system());
    let config = small_rnn(Cell::Lstm);
    let shape = ModelShape::on_graph(&system);
    let rnn = Rnn::create(&config, &shape, 0, compute(), &Seed::from_u64(121)).unwrap();
    let folder = folder.path().join("rnn");
    save(&folder, &rnn, &system, &shape, &TrainConfig::paper(10)).unwrap();
    change(&folder);
    let error = load::<Rnn>(&folder, &system, &shape, compute()).err().expect("it was loaded").to_string();
    assert_eq!(error.lines().count(), 1, "{error}");
    error.replace(&folder.display().to_string(), "DIR")
}

/// Changes the description and makes its hash right again, as somebody could who means to.
fn edit(folder: &Path, from: &str, to: &str) {
    let path = folder.join("proposal.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{text}");
    let body = text.split_once('\n').unwrap().1.replace(from, to);
    let weights = std::fs::read(folder.join("weights.safetensors")).unwrap();
    let hash = blake3::hash(&[body.as_bytes(), &weights].concat());
    std::fs::write(path, format!("blake3 = \"{hash}\"\n{body}")).unwrap();
}

fn flip(folder: &Path, file: &str) {
    let path = folder.join(file);
    let mut bytes = std::fs::read(&path).unwrap();
    let last = bytes.len() - 3;
    bytes[last] ^= 1;
    std::fs::write(path, bytes).unwrap();
}

/// The lines are in `snapshots/`.
#[test]
fn what_does_not_fit_is_refused() {
    let truncated = told(|folder| {
        let path = folder.join("weights.safetensors");
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(path, &bytes[..bytes.len() - 1]).unwrap();
    });
    let of_edit = |from: &str, to: &str| told(|folder| edit(folder, from, to));
    let not_a_file =
        |name: &'static str| told(move |folder| std::fs::remove_file(folder.join(name)).unwrap());
    let said = [
        ("weights truncated", truncated),
        ("a bit of the weights flipped", told(|folder| flip(folder, "weights.safetensors"))),
        ("a bit of the description flipped", told(|folder| flip(folder, "proposal.toml"))),
        ("no description", not_a_file("proposal.toml")),
        ("no weights", not_a_file("weights.safetensors")),
        ("another format", of_edit("format = 3", "format = 4")),
        ("another family", of_edit("family = \"rnn\"", "family = \"fcnn\"")),
        ("a horizon that it has not", of_edit("format = 3", "format = 3\nhorizon = 4")),
        ("another shape", of_edit("hidden = 5", "hidden = 6")),
        ("a shape beyond all memory", of_edit("hidden = 5", "hidden = 9000000000000000000")),
        ("a ridge that cannot be", of_edit("ridge = 0.001", "ridge = -0.001")),
        ("an unknown key", of_edit("hidden = 5", "hiden = 5")),
    ];
    let lines: String = said.iter().map(|(name, line)| format!("{name}\n    {line}\n")).collect();
    insta::with_settings!({ omit_expression => true }, { insta::assert_snapshot!(lines) });
}

#[test]
fn another_system_is_refused_with_what_differs() {
    let (folder, system) = (tempfile::tempdir().unwrap(), system());
    let rnn =
        Rnn::create(&small_rnn(Cell::Lstm), &ModelShape::of(&system), 0, compute(), &Seed::from_u64(122))
            .unwrap();
    save(folder.path(), &rnn, &system, &ModelShape::of(&system), &TrainConfig::paper(10)).unwrap();
    let refused = |model: &dyn motes_models::StateSpaceModel| {
        let error = load::<Rnn>(folder.path(), model, &ModelShape::of(model), compute()).err().unwrap();
        assert!(matches!(error, SavedError::OtherSystem { .. }), "{error}");
        error.to_string()
    };
    let same_but_noise = system.with_noise(Noise::Exponential);
    let error = refused(&same_but_noise);
    assert!(error.contains("trained for another system: log p("), "{error}");
    let config = GraphDiffusionConfig { snr_db: 5.000001, ..GraphDiffusionConfig::new(5) };
    let nearly = GraphDiffusion::random(&config, &mut Seed::from_u64(120).stream()).unwrap();
    refused(&nearly);
    let elsewhere =
        GraphDiffusion::random(&GraphDiffusionConfig::new(5), &mut Seed::from_u64(2).stream()).unwrap();
    refused(&elsewhere);
    let error = refused(&reference().model);
    assert!(error.contains("the state dimension N is 5 there and 1 in the model given"), "{error}");
}

#[test]
fn weights_that_are_not_finite_are_refused() {
    let (folder, system) = (tempfile::tempdir().unwrap(), system());
    let mut rnn =
        Rnn::create(&small_rnn(Cell::Elman), &ModelShape::of(&system), 0, compute(), &Seed::from_u64(123))
            .unwrap();
    let mut values = rnn.parameters().host(0);
    values[7] = f64::NAN;
    rnn.parameters_mut().set_host(0, &values).unwrap();
    save(folder.path(), &rnn, &system, &ModelShape::of(&system), &TrainConfig::paper(10)).unwrap();
    let error =
        load::<Rnn>(folder.path(), &system, &ModelShape::of(&system), compute()).err().unwrap().to_string();
    assert!(error.ends_with("recurrent.0.input holds NaN at row 1, column 2"), "{error}");
}

#[test]
fn another_graph_of_the_same_system_is_refused() {
    let (folder, system) = (tempfile::tempdir().unwrap(), system());
    let shape = ModelShape::on_graph(&system);
    let config = small_gnn(Adapter::Fixed);
    let gnn = Gnn::create(&config, &shape, 3, compute(), &Seed::from_u64(124)).unwrap();
    save(folder.path(), &gnn, &system, &shape, &TrainConfig::paper(10)).unwrap();
    assert!(load::<Gnn>(folder.path(), &system, &shape, compute()).is_ok());
    let refused = |shape: &ModelShape| {
        let error = load::<Gnn>(folder.path(), &system, shape, compute()).err().unwrap();
        assert!(matches!(error, SavedError::OtherSystem { .. }), "{error}");
        error.to_string()
    };
    assert!(refused(&ModelShape::of(&system)).contains("the number of graphs is 1 there and 0"));
    let mut other = shape.clone();
    other.graph.as_mut().unwrap().shift[(0, 1)] += 0.1;
    assert!(refused(&other).contains("the graph's matrix S"));
}
