//! The owner of an object.

use behavior::Str;
use behavior::board::{Fault, Out};
use behavior::tree::{BindError, Binder};

use crate::nodes::Context;
use crate::setup::Setup;
use crate::shared::{self, RESERVED};

const AVAILABLE: &str = "available";
pub(super) const CARRIED: &str = "carried";
const PLACED: &str = "placed";

/// Relation of an arm to an object. On the blackboard it is `available`, or a word and the arm,
/// as `reserved:left`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// Any arm may reserve it.
    Available,
    /// This arm works on it.
    Reserved,
    /// This arm carries it.
    Carried,
    /// It is where this arm placed it.
    Placed,
    /// It belongs to another arm.
    Other,
}

/// Access of a node to the owners of the objects of the cell: a shared key `PREFIX:OBJECT` for
/// each.
#[derive(Clone, Debug)]
pub struct Reservations {
    available: Str,
    words: [(Owner, Str); 3],
    objects: Vec<Out<Str>>,
}

impl Reservations {
    /// The owners of all objects of a cell.
    ///
    /// # Errors
    /// Returns a [`BindError`] if a key is declared with another type, or a name is too long.
    #[allow(clippy::result_large_err, reason = "happens at load, once")]
    pub fn bind(setup: &Setup, binder: &mut Binder<'_>, prefix: &str) -> Result<Self, BindError> {
        let me = shared::robot(binder)?;
        let word = |word: &str| shared::word(&format!("{word}:{me}"));
        let available = shared::word(AVAILABLE)?;
        let mut objects = Vec::new();
        for object in &setup.objects {
            shared::word(&object.name)?;
            let key = format!("{prefix}:{}", object.name);
            objects.push(shared::key(binder, &key, available)?);
        }
        Ok(Self {
            available,
            words: [
                (Owner::Reserved, word(RESERVED)?),
                (Owner::Carried, word(CARRIED)?),
                (Owner::Placed, word(PLACED)?),
            ],
            objects,
        })
    }

    /// The owner of an object.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn owner(&self, cx: &Context<'_, '_>, object: usize) -> Result<Owner, Fault> {
        // An object that the cell does not have belongs to another: no arm may work on it.
        let Some(key) = self.objects.get(object) else {
            return Ok(Owner::Other);
        };
        let found = cx.read(key)?;
        if found == self.available {
            return Ok(Owner::Available);
        }
        let mine = self.words.iter().find(|(_, word)| *word == found);
        Ok(mine.map_or(Owner::Other, |(owner, _)| *owner))
    }

    /// Sets the owner of an object; an arm cannot assign it to another arm.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn set(&self, cx: &mut Context<'_, '_>, object: usize, owner: Owner) -> Result<(), Fault> {
        let word = match owner {
            Owner::Available => Some(self.available),
            _ => self
                .words
                .iter()
                .find(|(o, _)| *o == owner)
                .map(|(_, w)| *w),
        };
        match (self.objects.get(object), word) {
            (Some(key), Some(word)) => cx.set(key, word),
            _ => Ok(()),
        }
    }
}
