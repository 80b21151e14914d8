//! The owner of a collider, kept in its user data.

/// Owner of a collider.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tag {
    /// Something fixed, by its place in the cell.
    Fixture(usize),
    /// An object by its place in the cell.
    Object(usize),
    /// A link of an arm: 0 the base, then the children of the joints.
    Link { arm: usize, link: usize },
}

impl Tag {
    /// As user data.
    pub(crate) fn encode(self) -> u128 {
        match self {
            Self::Fixture(index) => index as u128,
            Self::Object(index) => (1 << 64) | index as u128,
            Self::Link { arm, link } => (2 << 64) | ((arm as u128) << 32) | link as u128,
        }
    }

    /// From user data.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "encode put small numbers there"
    )]
    pub(crate) fn decode(data: u128) -> Self {
        let low = data as u64;
        match data >> 64 {
            1 => Self::Object(low as usize),
            2 => Self::Link {
                arm: (low >> 32) as usize,
                link: (low & 0xffff_ffff) as usize,
            },
            _ => Self::Fixture(low as usize),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Tag;

    #[test]
    fn tags_survive() {
        for tag in [
            Tag::Fixture(3),
            Tag::Object(159),
            Tag::Link { arm: 1, link: 9 },
        ] {
            assert_eq!(Tag::decode(tag.encode()), tag);
        }
    }
}
