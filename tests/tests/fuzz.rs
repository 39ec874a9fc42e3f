//! Replays the inputs that fuzzers kept: `fuzz/README.md`.

use std::path::Path;

use csat_tests::fuzz::{TARGETS, clearing, factors, seeds, spoil};

#[test]
fn whatever_was_kept_is_harmless() {
    for (target, check) in TARGETS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(target);
        let mut files: Vec<_> = std::fs::read_dir(&folder)
            .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
            .map(|entry| entry.expect("an entry").path())
            .collect();
        files.sort();
        assert!(files.len() >= 4, "{target}: {} files", files.len());
        for file in files {
            // Shown only if it fails.
            println!("{}", file.display());
            check(&std::fs::read(&file).expect("a file"));
        }
    }
}

/// Valid inputs, and false messages that decode.
#[test]
fn the_fuzzers_begin_with_what_is_harmless() {
    let (mut lies, seeds) = (0, seeds());
    for (target, check) in TARGETS {
        let honest: Vec<_> = seeds.iter().filter(|(of, ..)| *of == target).collect();
        assert!(honest.len() >= 2, "{target}");
        for (_, name, bytes) in honest {
            println!("{target} {name}");
            check(bytes);
            let spoil = match target {
                "fact" => spoil::fact,
                "snapshot" => spoil::snapshot,
                "factors" => factors::lie::talk,
                "clearing" => clearing::talk,
                _ => continue,
            };
            for seed in 0..20 {
                println!("{target} {name} spoilt by {seed}");
                check(&spoil(bytes, seed).expect("an honest body"));
                lies += 1;
            }
        }
    }
    assert!(lies > 100, "{lies}");
}
