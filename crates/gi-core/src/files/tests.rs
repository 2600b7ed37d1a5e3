use super::*;

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder");
    let name = |e: Result<std::fs::DirEntry>| e.expect("an entry").file_name();
    entries.map(|e| name(e).into_string().expect("UTF-8")).collect()
}

#[test]
fn a_write_that_fails_half_way_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.txt");
    write(&path, b"old").expect("written");
    let half = |out: &mut Out| {
        out.write_all(b"ne")?;
        out.flush()?;
        Err(Error::other("no more"))
    };
    let error = write_with(&path, half).expect_err("errors are passed on");
    assert_eq!(error.to_string(), "no more");
    assert_eq!(std::fs::read(&path).expect("a file"), b"old");
    assert_eq!(names(folder.path()), ["a.txt"]);
    write(&path, b"new").expect("written");
    assert_eq!(std::fs::read(&path).expect("a file"), b"new");
    assert_eq!(names(folder.path()), ["a.txt"]);
}

#[test]
fn what_killed_processes_left_is_removed_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let old = std::time::SystemTime::now() - 2 * ABANDONED;
    let abandoned = "a.exr.0123456789.part";
    let others =
        ["a.exr.9876543210.part", "a.exr.012345678.part", "b.exr.0123456789.part", "a.exr.part"];
    for name in [&[abandoned], &others[..]].concat() {
        let file = std::fs::File::create(at(name)).expect("a file");
        // The first of the others is being written.
        if name != others[0] {
            file.set_modified(old).expect("its time");
        }
    }
    write(&at("a.exr"), b"new").expect("written");
    let mut expected = [&["a.exr"], &others[..]].concat();
    let mut left = names(folder.path());
    expected.sort_unstable();
    left.sort();
    assert_eq!(left, expected);
}

#[cfg(unix)]
#[test]
fn a_new_content_keeps_the_files_rights() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.txt");
    write(&path, b"old").expect("written");
    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o600)).expect("its rights");
    write(&path, b"new").expect("written");
    let mode = std::fs::metadata(&path).expect("a file").permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
    let error = write(&folder.path().join("no/a.txt"), b"new").expect_err("no such folder");
    assert!(!error.to_string().contains(".part"), "{error}");
}

#[test]
fn a_check_changes_nothing_and_finds_what_a_write_would() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    write(&at("a.txt"), b"old").expect("written");
    std::fs::create_dir(at("b.txt")).expect("made");
    check_writable(&at("a.txt")).expect("it can be written anew");
    check_writable(&at("c.txt")).expect("it can be made");
    for refused in [at("b.txt"), at("no/such/d.txt"), PathBuf::new()] {
        assert!(check_writable(&refused).is_err(), "{refused:?} passed the check");
        assert!(write(&refused, b"new").is_err(), "{refused:?} was written");
    }
    assert_eq!(std::fs::read(at("a.txt")).expect("a file"), b"old");
    let mut left = names(folder.path());
    left.sort();
    assert_eq!(left, ["a.txt", "b.txt"]);
}

#[cfg(unix)]
#[test]
fn a_symbolic_link_is_written_through_even_if_its_target_does_not_exist() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, at(name)).expect("a link");
    link("b.txt", "a.txt");
    link("a.txt", "chain.txt");
    for text in [b"one", b"two"] {
        write(&at("chain.txt"), text).expect("written");
        assert_eq!(std::fs::read(at("b.txt")).expect("the target"), text);
    }
    assert!(at("a.txt").is_symlink() && at("chain.txt").is_symlink() && !at("b.txt").is_symlink());
    assert!(is_same(&at("chain.txt"), &at("b.txt")));
    link("to.txt", "fro.txt");
    link("fro.txt", "to.txt");
    assert!(check_writable(&at("to.txt")).is_err() && write(&at("to.txt"), b"").is_err());
}

#[cfg(unix)]
#[test]
fn devices_are_refused_by_any_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let link = folder.path().join("null.txt");
    std::os::unix::fs::symlink("/dev/null", &link).expect("a link");
    for path in [Path::new("/dev/null"), &link] {
        let error = check_writable(path).expect_err("a device");
        assert!(error.to_string().contains("device"), "{error}");
        assert!(write(path, b"new").is_err());
    }
}

#[test]
fn files_of_points_are_known_by_their_names() {
    assert!(["a.ply", "a.csv", "b/a.CSV"].iter().all(|name| points_file(name).is_ok()));
    assert!(["a.txt", "csv", "a.csv.gz"].iter().all(|name| points_file(name).is_err()));
    let table = ["a.ply", "a.csv", "a.CSV"].map(|name| is_table(Path::new(name)));
    assert_eq!(table, [false, true, true]);
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = folder.path().join("missing");
    for path in [folder.path(), &missing] {
        let message = read(path).expect_err("it cannot be read");
        assert!(message.contains(&path.display().to_string()), "{message}");
    }
}

#[test]
fn different_names_of_the_same_file_are_recognised() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    write(&at("a.txt"), b"there").expect("written");
    for name in ["a.txt", "b.txt"] {
        assert!(is_same(&at(name), &at("./").join(name)), "{name}");
        assert!(!is_same(&at(name), &at("c.txt")), "{name}");
    }
}
