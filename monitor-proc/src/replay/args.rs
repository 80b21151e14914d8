//! `monitor-proc replay FILE --address A --secrets S [--host N] [--dist D] [--hint H]`.

use std::net::SocketAddr;
use std::path::PathBuf;

/// Recording and address.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReplayArgs {
    /// The recording: a file, or the directory of a flight recorder.
    pub file: PathBuf,
    /// Address and port to listen at.
    pub address: SocketAddr,
    /// Name by which other machines reach this one.
    pub host: Option<String>,
    /// File with the secrets of the page.
    pub secrets: PathBuf,
    /// The built page; the embedded one where missing.
    pub dist: Option<PathBuf>,
    /// Advice for people when there is no page.
    pub hint: String,
}

/// Invalid arguments.
#[derive(Debug, thiserror::Error)]
#[error(
    "{0}; the launcher starts this as `replay FILE --address A --secrets S [--dist D] \
     [--hint H]`, people start `robocell replay FILE`"
)]
pub struct ReplayArgsError(String);

impl ReplayArgs {
    /// Reads the arguments after `replay`.
    ///
    /// # Errors
    ///
    /// The argument that is missing or wrong.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, ReplayArgsError> {
        let missing = |what: &str| ReplayArgsError(format!("{what} is missing"));
        let file = arguments.next().ok_or_else(|| missing("the file"))?;
        let (mut address, mut host, mut secrets, mut dist) = (None, None, None, None);
        let mut hint = String::new();
        while let Some(name) = arguments.next() {
            let value = arguments.next();
            let value = value.ok_or_else(|| ReplayArgsError(format!("{name} has no value")))?;
            match name.as_str() {
                "--address" => {
                    let wrong = || ReplayArgsError(format!("--address is {value:?}, not IP:PORT"));
                    address = Some(value.parse().map_err(|_| wrong())?);
                }
                "--host" => host = Some(value),
                "--secrets" => secrets = Some(PathBuf::from(value)),
                "--dist" => dist = Some(PathBuf::from(value)),
                "--hint" => hint = value,
                _ => return Err(ReplayArgsError(format!("{name} is unknown"))),
            }
        }
        Ok(Self {
            file: PathBuf::from(file),
            address: address.ok_or_else(|| missing("--address"))?,
            host,
            secrets: secrets.ok_or_else(|| missing("--secrets"))?,
            dist,
            hint,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::ReplayArgs;

    fn parse(line: &str) -> Result<ReplayArgs, String> {
        let words = line.split_whitespace().map(str::to_owned);
        ReplayArgs::parse(words).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_missing_or_wrong_is_named() {
        let args = parse("a.mcap --address 127.0.0.1:8600 --secrets s --dist d").unwrap();
        assert_eq!((args.address.port(), args.dist.is_some()), (8600, true));
        for (line, named) in [
            ("", "file"),
            ("a.mcap --secrets s", "--address"),
            ("a.mcap --address here --secrets s", "here"),
            ("a.mcap --address 127.0.0.1:1", "--secrets"),
            ("a.mcap --speed 1", "--speed"),
            ("a.mcap --hint", "--hint"),
        ] {
            let error = parse(line).unwrap_err();
            assert!(error.contains(named), "{line}: {error}");
        }
    }
}
