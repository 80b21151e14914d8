//! States: full names, ranks, contained states and the states that are entered with them.

use super::Compiler;
use crate::descriptor::json::shortened;
use crate::known::Known;
use crate::machine::definition::{Final, Name, StateDef};
use crate::machine::ids::{BehaviorId, StateId};
use crate::machine::record::name_hash;
use crate::machine::set::SmallSet;
use crate::machine::table::{During, Span, State};

/// Largest depth of nested states.
// Bounds the work of a change of state, and the recursion below.
const MAX_DEPTH: usize = 16;

/// A state of the file with its place in the hierarchy.
struct Flat<'a> {
    def: &'a StateDef,
    full: String,
    parent: Option<usize>,
    depth: usize,
}

impl<'a> Compiler<'a> {
    /// Adds all states; if the set of states is empty, none.
    pub(super) fn add_states(&mut self) {
        let definition = self.definition;
        let mut flat = Vec::new();
        self.flatten(&definition.states, None, 0, &mut flat);
        if flat.is_empty() {
            let place = definition.initial.as_ref().map(|name| name.place);
            self.problems.add(
                place.unwrap_or_default(),
                "no states; give at least one: states = [\"idle\"]",
            );
            return;
        }
        self.states = Known::new(flat.iter().map(|it| &it.full));
        self.out.states = (0..flat.len())
            .map(|at| Self::plain_state(&flat, at))
            .collect();
        // Ranks first: the sets below are sets of ranks.
        self.rank();
        self.sets(&flat);
        self.add_callbacks(&flat);
        // The first state is the initial one where the file does not name one.
        let first = flat.first().map(|it| it.def.name.clone());
        if let Some(initial) = definition.initial.as_ref().or(first.as_ref()) {
            self.out.initial = self.state_id(initial).unwrap_or(StateId(0));
        }
    }

    fn flatten(
        &mut self,
        states: &'a [StateDef],
        parent: Option<usize>,
        depth: usize,
        out: &mut Vec<Flat<'a>>,
    ) {
        let prefix = parent
            .and_then(|parent| out.get(parent))
            .map(|it| format!("{}.", it.full))
            .unwrap_or_default();
        for def in states {
            self.check_name(&def.name, &prefix, out);
            out.push(Flat {
                def,
                full: format!("{prefix}{}", def.name.text),
                parent,
                depth,
            });
            if depth >= MAX_DEPTH && !def.children.is_empty() {
                let message = format!("states more than {MAX_DEPTH} deep in one another");
                self.problems.add(def.name.place, message);
            } else {
                // Parents come before their children, as `sets` and a restore rely on.
                self.flatten(&def.children, Some(out.len() - 1), depth + 1, out);
            }
        }
    }

    fn check_name(&mut self, name: &Name, prefix: &str, known: &[Flat<'_>]) {
        let text = &name.text;
        if text.is_empty() || text.contains(['.', '*', '=', ' ', '\n', '\t']) {
            let text = shortened(text);
            let message = format!(
                "'{text}' cannot be the name of a state; it must not be empty nor contain '.', '*', '=' or spaces"
            );
            self.problems.add(name.place, message);
        }
        // Compared by full name: states of different parents may share their own name.
        let full = format!("{prefix}{text}");
        if let Some(first) = known.iter().find(|it| it.full == full) {
            let line = match first.def.name.place.line {
                0 => String::new(),
                line => format!(" (first in line {line})"),
            };
            let message = format!("state '{full}' is defined twice{line}; rename one of them");
            self.problems.add(name.place, message);
        }
    }

    fn plain_state(flat: &[Flat<'_>], at: usize) -> State {
        let full = flat.get(at).map(|it| it.full.clone()).unwrap_or_default();
        let it = flat.get(at);
        State {
            hash: name_hash(&full),
            name: full,
            parent: it.and_then(|it| it.parent).map(StateId::of),
            rank: 0,
            depth: it.map_or(0, |it| it.depth),
            enter: Span::default(),
            exit: Span::default(),
            end: it.map_or(Final::No, |it| it.def.end),
            parallel: it.is_some_and(|it| it.def.parallel),
            has_children: it.is_some_and(|it| !it.def.children.is_empty()),
            during: None,
            subtree: SmallSet::default(),
            entry: SmallSet::default(),
            path: SmallSet::default(),
        }
    }

    /// Deepest level first; within a level the order of the file. Sets of ranks are iterated in
    /// the order in which states are tried and left.
    fn rank(&mut self) {
        let mut order: Vec<usize> = (0..self.out.states.len()).collect();
        let depth = |at: usize| self.out.states.get(at).map_or(0, |state| state.depth);
        order.sort_by_key(|at| (std::cmp::Reverse(depth(*at)), *at));
        let deepest = order.first().map_or(0, |at| depth(*at));
        let mut levels = vec![SmallSet::default(); deepest + 1];
        for (rank, at) in order.iter().enumerate() {
            if let Some(level) = levels.get_mut(depth(*at)) {
                level.insert(rank);
            }
        }
        for (rank, at) in order.iter().enumerate() {
            if let Some(state) = self.out.states.get_mut(*at) {
                state.rank = rank;
            }
        }
        self.out.by_rank = order.into_iter().map(StateId::of).collect();
        self.out.levels = levels;
    }

    /// Computes paths from the top down, subtrees and entries from the bottom up.
    fn sets(&mut self, flat: &[Flat<'_>]) {
        for at in 0..flat.len() {
            let Some((rank, parent)) = self.out.states.get(at).map(|it| (it.rank, it.parent))
            else {
                continue;
            };
            let above = parent
                .and_then(|parent| self.out.get(parent))
                .map(|it| it.path);
            let mut path = above.unwrap_or_default();
            path.insert(rank);
            self.set(at, |state| {
                state.path = path;
                state.subtree.insert(rank);
                state.entry.insert(rank);
            });
        }
        // From the last to the first: children are complete before their parent adds them.
        for at in (0..flat.len()).rev() {
            self.add_to_parent(flat, at);
        }
        for it in flat {
            self.check_children(it);
        }
    }

    fn add_to_parent(&mut self, flat: &[Flat<'_>], at: usize) {
        let (Some(it), Some(state)) = (flat.get(at), self.out.states.get(at)) else {
            return;
        };
        let (subtree, entry) = (state.subtree, state.entry);
        let Some((parent, def)) = it.parent.and_then(|at| Some((at, flat.get(at)?.def))) else {
            return;
        };
        let chosen = def
            .initial
            .as_ref()
            .is_some_and(|name| name.text == it.def.name.text);
        // The entry has all children of a parallel state, else the initial child alone.
        self.set(parent, |state| {
            state.subtree = state.subtree.union(&subtree);
            if def.parallel || chosen {
                state.entry = state.entry.union(&entry);
            }
        });
    }

    fn check_children(&mut self, it: &Flat<'_>) {
        let def = it.def;
        if let Some(initial) = &def.initial {
            if def.parallel {
                let message = format!(
                    "state '{}' is parallel: all its children are entered; drop its 'initial'",
                    it.full
                );
                self.problems.add(initial.place, message);
            } else {
                let known = Known::new(def.children.iter().map(|it| &it.name.text));
                let what = format!("initial child of '{}':", it.full);
                known.look_up(&what, initial, &mut self.problems);
            }
        }
        if def.parallel && def.children.is_empty() {
            let message = format!("state '{}' is parallel but has no children", it.full);
            self.problems.add(def.name.place, message);
        }
    }

    fn add_callbacks(&mut self, flat: &[Flat<'_>]) {
        for (at, it) in flat.iter().enumerate() {
            let enter = self.calls(&it.def.enter);
            let exit = self.calls(&it.def.exit);
            let run = it.def.during.as_ref().and_then(|during| {
                let problems = &mut self.problems;
                self.behaviors
                    .look_up("sub-behaviour", &during.run, problems)
            });
            self.set(at, |state| {
                state.enter = enter;
                state.exit = exit;
                state.during = run.map(|run| During {
                    run: BehaviorId::of(run),
                    success: None,
                    failure: None,
                });
            });
            if run.is_some()
                && let Some(rank) = self.out.states.get(at).map(|state| state.rank)
            {
                self.out.during.insert(rank);
            }
        }
    }

    /// The triggers that sub-behaviours fire; called when all rows are known.
    pub(super) fn add_results(&mut self) {
        let definition = self.definition;
        let mut flat = Vec::new();
        collect(&definition.states, &mut flat);
        for (at, def) in flat.into_iter().enumerate() {
            let Some(during) = &def.during else { continue };
            let success = during
                .success
                .as_ref()
                .and_then(|name| self.known_trigger(name));
            let failure = during
                .failure
                .as_ref()
                .and_then(|name| self.known_trigger(name));
            self.set(at, |state| {
                if let Some(during) = &mut state.during {
                    during.success = success;
                    during.failure = failure;
                }
            });
        }
    }

    fn set(&mut self, at: usize, change: impl FnOnce(&mut State)) {
        if let Some(state) = self.out.states.get_mut(at) {
            change(state);
        }
    }
}

/// States in the order of the file, the same as in [`Compiler::flatten`].
fn collect<'a>(states: &'a [StateDef], out: &mut Vec<&'a StateDef>) {
    for state in states {
        out.push(state);
        collect(&state.children, out);
    }
}
