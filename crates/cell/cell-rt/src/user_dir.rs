//! The directories of a user, by the XDG base directory specification.

use std::ffi::OsString;
use std::path::PathBuf;

/// The directory that the variable `own` names, as it is; else `robocell` in that of the
/// specification's variable `shared`; else `robocell` in `in_home` of the home directory.
/// `None` where no variable tells. `get` reads a variable, as [`std::env::var_os`] does.
pub fn user_dir(
    get: impl Fn(&str) -> Option<OsString>,
    own: &str,
    shared: &str,
    in_home: &str,
) -> Option<PathBuf> {
    let set = |name: &str| get(name).filter(|value| !value.is_empty());
    if let Some(dir) = set(own) {
        return Some(PathBuf::from(dir));
    }
    // The specification: a relative path there is ignored.
    let absolute = |name: &str| set(name).map(PathBuf::from).filter(|dir| dir.is_absolute());
    let base = absolute(shared).or_else(|| Some(absolute("HOME")?.join(in_home)))?;
    Some(base.join("robocell"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn cache(variables: &[(&str, &str)]) -> Option<PathBuf> {
        let get = |name: &str| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| OsString::from(value))
        };
        user_dir(get, "ROBOCELL_CACHE_DIR", "XDG_CACHE_HOME", ".cache")
    }

    #[test]
    fn a_relative_path_of_the_specification_is_ignored_and_home_is_used() {
        let home = ("HOME", "/home/me");
        let in_home = Path::new("/home/me/.cache/robocell");
        for xdg in ["", "cache", "./cache"] {
            let found = cache(&[home, ("XDG_CACHE_HOME", xdg)]);
            assert_eq!(found.as_deref(), Some(in_home), "{xdg}");
        }
        assert_eq!(
            cache(&[home, ("XDG_CACHE_HOME", "/cache")]),
            Some("/cache/robocell".into())
        );
        assert_eq!(
            cache(&[home, ("ROBOCELL_CACHE_DIR", "own")]),
            Some("own".into())
        );
        assert_eq!(cache(&[("HOME", "me")]), None);
        assert_eq!(cache(&[]), None);
    }
}
