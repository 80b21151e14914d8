//! Enumerations whose values have names in a behaviour file.

/// Values and their names, both in the same order. The index of a value is its id in the
/// engines of `behavior`, so this order is that of their vocabulary.
pub trait Named: Copy + 'static {
    /// All values.
    const ALL: &'static [Self];
    /// Their names, in the same order.
    const NAMES: &'static [&'static str];

    /// Index of the value.
    fn index(self) -> u16;

    /// The value of an index; `None` after the last.
    fn at(index: u16) -> Option<Self> {
        Self::ALL.get(usize::from(index)).copied()
    }

    /// Its name.
    fn name(self) -> &'static str {
        let name = Self::NAMES.get(usize::from(self.index()));
        name.copied().unwrap_or_default()
    }
}

/// Declares an enumeration with the name of each value and makes it [`Named`].
#[macro_export]
macro_rules! named {
    ($(#[$about:meta])* $vis:vis enum $type:ident {
        $($(#[$of:meta])* $value:ident = $name:literal,)+
    }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis enum $type {
            $($(#[$of])* $value,)+
        }

        impl $crate::Named for $type {
            const ALL: &'static [Self] = &[$(Self::$value),+];
            const NAMES: &'static [&'static str] = &[$($name),+];

            fn index(self) -> u16 {
                self as u16
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::Named as _;

    crate::named! {
        enum Colour {
            Red = "RED",
            Green = "GREEN",
        }
    }

    #[test]
    fn values_names_and_indices_belong_together() {
        assert_eq!(Colour::NAMES, ["RED", "GREEN"]);
        assert_eq!((Colour::Red.index(), Colour::Green.index()), (0, 1));
        assert_eq!(Colour::at(1), Some(Colour::Green));
        assert_eq!(Colour::at(2), None);
        assert_eq!(Colour::Green.name(), "GREEN");
    }
}
