//! How the builder of the book is called.

#![expect(clippy::unwrap_used, reason = "a failed step fails the test")]

use std::process::Command;

#[test]
fn help_and_options_that_do_not_exist_write_nothing() {
    let scratch = tempfile::tempdir().unwrap();
    for (option, status) in [("--help", 0), ("-h", 0), ("--out", 2)] {
        let run = Command::new(env!("CARGO_BIN_EXE_hangtime-book"))
            .arg(option)
            .current_dir(scratch.path())
            .output()
            .unwrap();
        assert_eq!(run.status.code(), Some(status));
        let said = String::from_utf8([run.stdout, run.stderr].concat()).unwrap();
        assert!(said.contains("hangtime-book [FOLDER]"), "{said}");
    }
    assert_eq!(std::fs::read_dir(scratch.path()).unwrap().count(), 0);
}
