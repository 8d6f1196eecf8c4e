//! The Python package: built into a virtual environment of its own and tested there, and its wheel.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Args;
use motes_cli::status;

use crate::process::{build, built, run};

/// What the package is built and tested with.
const PACKAGES: [&str; 6] = ["maturin>=1.9,<2", "numpy", "pandas", "polars", "matplotlib", "pytest>=8"];

/// What some tests need, which are skipped, and say so, where it is not to be had: not all is there for every platform.
const FOR_SOME_TESTS: [&str; 7] =
    ["jax", "xarray", "arviz", "h5netcdf", "joblib", "dask[distributed]", "mypy==2.4.1"];

/// Interpreters that are looked for, in this order.
const INTERPRETERS: [&str; 6] =
    ["python3", "python3.14", "python3.13", "python3.12", "python3.11", "python3.10"];

#[derive(Args)]
pub(crate) struct PythonArgs {
    /// The interpreter, of Python 3.10 or later; the first that is there if absent
    #[arg(long, value_name = "PROGRAM")]
    python: Option<PathBuf>,
    /// Build a wheel for this machine's platform instead, into target/wheels
    #[arg(long)]
    wheel: bool,
}

/// Builds and tests the package, or builds its wheel.
pub(crate) fn python(root: &Path, args: &PythonArgs) -> ExitCode {
    let Some(interpreter) = args.python.clone().or_else(|| interpreter(root)) else {
        status("error: there is no Python 3.10 or later; name one with --python");
        return ExitCode::from(3);
    };
    let done = environment(root, &interpreter).and_then(|environment| match args.wheel {
        true => wheel(root, &environment),
        false => build(root, "motes", &[], "; the package is tested beside it")
            .and_then(|()| maturin(root, &environment, &["develop", "--locked", "--quiet", "--release"]))
            .and_then(|()| tested(root, &environment, "release")),
    });
    done.map_or_else(|status| status, |()| ExitCode::SUCCESS)
}

/// How pyo3 is told to build a library that an interpreter loads, as maturin tells it.
pub(crate) const AS_EXTENSION: (&str, &str) = ("PYO3_BUILD_EXTENSION_MODULE", "1");

/// As the check of every change, with the library and beside the command that the regression run built.
///
/// It is left out, and says so, where there is no Python, or no network for its packages.
pub(crate) fn check(root: &Path) -> Result<(), ExitCode> {
    let Some(interpreter) = interpreter(root) else {
        println!("ci: the Python package is left out: there is no Python 3.10 or later");
        return Ok(());
    };
    let Ok(environment) = environment(root, &interpreter) else {
        println!(
            "ci: the Python package is left out: its virtual environment could not be made, or has no network"
        );
        return Ok(());
    };
    if cfg!(target_os = "linux") {
        let (library, module) = (built("debug", "lib_motes.so"), "crates/python/python/motes/_motes.abi3.so");
        if let Err(error) = std::fs::copy(&library, root.join(module)) {
            status(&format!("error: {} as {module}: {error}", library.display()));
            return Err(ExitCode::from(3));
        }
    } else {
        // Elsewhere linkers have to be told more, which maturin does.
        maturin(root, &environment, &["develop", "--locked", "--quiet", "--profile", "dev"])?;
    }
    tested(root, &environment, "debug")
}

/// The first interpreter that is new enough and can make virtual environments.
fn interpreter(root: &Path) -> Option<PathBuf> {
    let is_fit = |program: &str| {
        let asked = "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 10))";
        let mut command = Command::new(program);
        command.current_dir(root).args(["-c", asked]).stderr(std::process::Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    INTERPRETERS.into_iter().find(|program| is_fit(program)).map(PathBuf::from)
}

/// A virtual environment with what is needed, made if it is not there.
fn environment(root: &Path, interpreter: &Path) -> Result<PathBuf, ExitCode> {
    let folder = root.join("target/python");
    let program = folder.join("bin/python");
    if !program.exists() {
        run(Command::new(interpreter).args(["-m", "venv", "--clear"]).arg(&folder))?;
    }
    let install = |packages: &[&str]| {
        let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
        run(Command::new(&program).args(pip).args(packages))
    };
    install(&PACKAGES)?;
    for package in FOR_SOME_TESTS {
        if install(&[package]).is_err() {
            println!("python: without {package}: its tests are skipped");
        }
    }
    Ok(folder)
}

/// maturin of the environment, in the package's folder.
fn maturin(root: &Path, environment: &Path, arguments: &[&str]) -> Result<(), ExitCode> {
    let mut command = Command::new(environment.join("bin/maturin"));
    command.current_dir(root.join("crates/python")).env("VIRTUAL_ENV", environment).args(arguments);
    run(&mut command)
}

/// Runs the package's tests beside the command of that profile's folder.
fn tested(root: &Path, environment: &Path, folder: &str) -> Result<(), ExitCode> {
    let mut tests = Command::new(environment.join("bin/python"));
    tests.current_dir(root.join("crates/python")).args([
        "-m",
        "pytest",
        "--quiet",
        "-W",
        "ignore::motes.MotesWarning",
    ]);
    // Where nothing installed the package, it is found in its folder.
    tests.env("PYTHONPATH", root.join("crates/python/python"));
    run(tests.env("MOTES_COMMAND", built(folder, "motes")))
}

/// One wheel for Python 3.10 and all later ones.
fn wheel(root: &Path, environment: &Path) -> Result<(), ExitCode> {
    maturin(root, environment, &["build", "--release", "--locked", "--out", "../../target/wheels"])
}
