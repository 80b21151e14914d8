//! The jobs of this task program.

mod policy;

use std::sync::Arc;

use robocell_skills::{Places, Setup};
use robocell_task::{Kind, Policies{{imports}}};

/// `kind = "{{name}}"` in a cell file, and the policies that do it.
pub fn policies() -> Policies {
    let kind = Kind::<Places>::new("{{name}}").policy("{{policy}}", |task, cell| {
        let setup = Arc::new(Setup::new(cell, &task.place));
        let cube = setup.need_object(cell, "cube")?;
        let mark = setup.need_place(cell, "mark")?;
        {{make}}
    });
    Policies::new().with(kind)
}
