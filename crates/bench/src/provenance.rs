//! What a unit was computed with: results are the same bytes where that agrees.

use std::process::Command;

use serde::{Deserialize, Serialize};

/// A source revision and a kind of processor.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Provenance {
    /// `-dirty` if there were changes, `unknown` outside a repository.
    pub(crate) revision: String,
    /// The architecture and those vector extensions that the linear algebra chooses its kernels by.
    pub(crate) processor: String,
}

impl Provenance {
    /// What this process computes with, started in the folder of the sources.
    pub(crate) fn here() -> Self {
        Provenance::of(revision())
    }

    /// What this machine computes with by a program of that revision.
    pub(crate) fn of(revision: String) -> Self {
        Provenance { revision, processor: processor() }
    }

    /// That of what was begun with `earlier` ones, one after the other, and ended with this: `… then …` where they differ.
    pub(crate) fn after(&self, earlier: &[Provenance]) -> Self {
        let joined = |of: fn(&Provenance) -> &String| {
            let mut all: Vec<&str> = earlier.iter().chain([self]).map(|one| of(one).as_str()).collect();
            all.dedup();
            all.join(" then ")
        };
        Provenance { revision: joined(|one| &one.revision), processor: joined(|one| &one.processor) }
    }
}

fn revision() -> String {
    let described =
        Command::new("git").args(["describe", "--always", "--abbrev=40", "--dirty", "--exclude=*"]).output();
    match described {
        Ok(output) if output.status.success() => String::from_utf8_lossy(&output.stdout).trim().to_string(),
        _ => "unknown".into(),
    }
}

fn processor() -> String {
    #[cfg(target_arch = "x86_64")]
    let extensions = [
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("fma", std::arch::is_x86_feature_detected!("fma")),
        ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
    ];
    #[cfg(not(target_arch = "x86_64"))]
    let extensions = [];
    let found = extensions.into_iter().filter(|(_, there)| *there).map(|(name, _): (&str, bool)| name);
    std::iter::once(std::env::consts::ARCH).chain(found).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_named_once_and_in_order() {
        let of = |revision: &str, processor: &str| Provenance {
            revision: revision.into(),
            processor: processor.into(),
        };
        let last = of("b", "x86_64 avx2");
        assert_eq!(last.after(&[]), last);
        assert_eq!(last.after(&[of("b", "x86_64 avx2")]), last);
        let mixed = last.after(&[of("a", "x86_64 avx512f"), of("a", "x86_64 avx2")]);
        assert_eq!(mixed, of("a then b", "x86_64 avx512f then x86_64 avx2"));
    }
}
