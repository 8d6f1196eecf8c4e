//! `cargo xtask docs`: runs what the pages say, makes a site of them, and follows its links.

mod blocks;
mod book;
mod help;
mod links;
mod markdown;
mod pages;
mod pictures;
mod run;
mod snippets;
mod text_file;
mod transcript;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use clap::Args;
use motes_cli::status;

use crate::process::{build, built};
use pages::Pages;

/// What makes the site, and how to get it.
const INSTALL: &str = "cargo install mdbook --version 0.5.4 --locked";

#[derive(Args)]
pub(crate) struct DocsArgs {
    /// Build the site and follow its links, but run nothing of what the pages say
    #[arg(long)]
    no_run: bool,
    /// Write what commands print, and the pictures of their reports, into the pages instead of comparing
    #[arg(long, conflicts_with = "no_run")]
    update_expectations: bool,
    /// Where links to files of the repository lead; to this checkout if absent
    #[arg(long, value_name = "URL")]
    repository: Option<String>,
    /// The command `motes` that pages are run with; built in release mode if absent
    #[arg(long, value_name = "PROGRAM")]
    motes: Option<PathBuf>,
    /// Run these pages alone, such as docs/gallery/nile.md, and build no site
    #[arg(value_name = "PAGE", conflicts_with_all = ["no_run", "repository"])]
    pages: Vec<String>,
}

/// Runs the pages, builds the site, and follows its links.
pub(crate) fn docs(root: &Path, args: &DocsArgs) -> ExitCode {
    let is_whole = args.pages.is_empty();
    if is_whole && !has_mdbook() {
        status(&format!("error: mdbook is not there; get it by: {INSTALL}"));
        return ExitCode::from(3);
    }
    let motes = match &args.motes {
        Some(program) => program.clone(),
        None => match build(root, "motes", &[], "; the pages are run with it") {
            Ok(()) => built("release", "motes"),
            Err(exit_status) => return exit_status,
        },
    };
    let here = format!("file://{}", root.display());
    let done = std::path::absolute(&motes).map_err(|error| error.to_string()).and_then(|motes| {
        if !args.no_run {
            run::pages(root, &motes, &args.pages, args.update_expectations)?;
        }
        if !is_whole {
            return Ok(());
        }
        site(root, &motes, args.repository.as_deref().unwrap_or(&here))
    });
    ended(done)
}

/// As one of the checks before a change lands: runs the gallery with the command that is there. What is learned on other pages may have other digits on other processors, whose products of
/// matrices add up in another order.
pub(crate) fn check_gallery(root: &Path) -> Result<(), ExitCode> {
    let gallery = Pages::read(root).map(|pages| {
        let names = pages.all.into_iter().map(|page| page.file);
        names.filter(|name| name.starts_with("docs/gallery/")).collect::<Vec<String>>()
    });
    checked(gallery.and_then(|gallery| run::pages(root, &built("debug", "motes"), &gallery, false)))
}

/// As one of the checks of the thorough run: all pages; the site and its links, where there is what makes it.
pub(crate) fn check_site(root: &Path) -> Result<(), ExitCode> {
    checked(run::pages(root, &built("debug", "motes"), &[], false))?;
    if !has_mdbook() {
        println!("ci: the site is left out: mdbook is not there; get it by: {INSTALL}");
        return Ok(());
    }
    checked(site(root, &built("debug", "motes"), &format!("file://{}", root.display())))
}

fn checked(done: Result<(), String>) -> Result<(), ExitCode> {
    if ended(done) == ExitCode::SUCCESS { Ok(()) } else { Err(ExitCode::FAILURE) }
}

fn ended(done: Result<(), String>) -> ExitCode {
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            status(&format!("error: {reason}"));
            ExitCode::FAILURE
        }
    }
}

fn has_mdbook() -> bool {
    let mut asked = Command::new("mdbook");
    asked.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    asked.status().is_ok_and(|status| status.success())
}

/// Makes the site and follows its links.
fn site(root: &Path, motes: &Path, repository: &str) -> Result<(), String> {
    let pages = Pages::read(root)?;
    let folder = root.join("target/docs");
    book::assemble(root, &folder, &pages, repository, &help::page(motes)?)?;
    let built = Command::new("mdbook").arg("build").arg(&folder).stdout(Stdio::null()).status();
    if !built.map_err(|error| format!("mdbook: {error}"))?.success() {
        return Err("mdbook failed".into());
    }
    let site = folder.join("site");
    let count = links::check(&site)?;
    println!(
        "docs: {} pages, {count} links within them: {}",
        pages.all.len(),
        site.join("index.html").display()
    );
    Ok(())
}
