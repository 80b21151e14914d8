// The editor itself; loaded when it is opened first.
import {
  autocompletion,
  type CompletionContext,
  type CompletionResult,
  closeBrackets,
  closeBracketsKeymap,
  completionKeymap,
} from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { json } from "@codemirror/lang-json";
import {
  bracketMatching,
  HighlightStyle,
  indentOnInput,
  indentUnit,
  StreamLanguage,
  syntaxHighlighting,
  syntaxTree,
} from "@codemirror/language";
import { toml } from "@codemirror/legacy-modes/mode/toml";
import { type Diagnostic, lintGutter, lintKeymap, setDiagnostics } from "@codemirror/lint";
import { highlightSelectionMatches, search, searchKeymap } from "@codemirror/search";
import { EditorState, type Text } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLine, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import type { Mistake } from "./api";
import { theme } from "./theme";
import { type Words, wordsOf } from "./words";

export interface Editor {
  root: HTMLElement;
  text: () => string;
  /** Shows mistakes at their places, in the place of those before. */
  blame: (mistakes: Mistake[]) => void;
  goTo: (line: number, column: number) => void;
  focus: () => void;
  close: () => void;
}

const colours = HighlightStyle.define([
  { tag: tags.propertyName, color: "#9cdcfe" },
  { tag: [tags.string, tags.special(tags.string)], color: "#e6b380" },
  { tag: [tags.number, tags.bool, tags.null, tags.atom], color: "#b5cea8" },
  { tag: [tags.comment, tags.meta], color: "#8fa08a" },
  { tag: tags.keyword, color: "#c8a2e8" },
]);

/** Place of a line and column that count from 1; within the text in any case. */
function placeOf(doc: Text, line: number, column: number): number {
  const { from, to } = doc.line(Math.min(Math.max(line, 1), doc.lines));
  return Math.min(from + Math.max(column - 1, 0), to);
}

function options(words: Map<string, string>, type: string) {
  return [...words].map(([label, info]) => ({ label, type, ...(info === "" ? {} : { info }) }));
}

/** In JSON the tree tells whether a key or a value is written. */
function completeJson(words: Words) {
  return (context: CompletionContext): CompletionResult | null => {
    const node = syntaxTree(context.state).resolveInner(context.pos, -1);
    const known = node.name === "PropertyName" ? words.keys : node.name === "String" ? words.values : null;
    if (known === null) return null;
    const text = context.state.sliceDoc(node.from, context.pos);
    const from = node.from + (text.startsWith('"') ? 1 : 0);
    return { from, options: options(known, "property"), validFor: /^[\w.-]*$/ };
  };
}

/** In TOML keys come before the equals sign, and in tables. */
function completeToml(words: Words) {
  return (context: CompletionContext): CompletionResult | null => {
    const word = context.matchBefore(/[\w-]+/);
    if (word === null) return null;
    const before = context.state.sliceDoc(context.state.doc.lineAt(word.from).from, word.from);
    if (before.includes("#")) return null;
    const known = before.endsWith('"') ? words.values : words.keys;
    return { from: word.from, options: options(known, "property"), validFor: /^[\w-]*$/ };
  };
}

export function makeEditor(spec: {
  text: string;
  language: "json" | "toml";
  schema: unknown;
  onChange: () => void;
  readOnly: boolean;
}): Editor {
  const words = wordsOf(spec.schema);
  const isJson = spec.language === "json";
  const view = new EditorView({
    state: EditorState.create({
      doc: spec.text,
      extensions: [
        lineNumbers(),
        lintGutter(),
        history(),
        drawSelection(),
        highlightActiveLine(),
        highlightSelectionMatches(),
        bracketMatching(),
        closeBrackets(),
        indentOnInput(),
        indentUnit.of("  "),
        search({ top: true }),
        isJson ? json() : StreamLanguage.define(toml),
        syntaxHighlighting(colours),
        autocompletion({ override: [isJson ? completeJson(words) : completeToml(words)] }),
        // Tab leaves the editor: the keyboard must lead out of it.
        keymap.of([
          ...closeBracketsKeymap,
          ...completionKeymap,
          ...searchKeymap,
          ...lintKeymap,
          ...historyKeymap,
          ...defaultKeymap,
        ]),
        EditorView.contentAttributes.of({ "aria-label": "Policy", tabindex: "0" }),
        EditorView.updateListener.of((update) => update.docChanged && spec.onChange()),
        EditorState.readOnly.of(spec.readOnly),
        theme,
      ],
    }),
  });
  return {
    root: view.dom,
    text: () => view.state.doc.toString(),
    blame: (mistakes) => {
      const found = mistakes.flatMap((mistake) => marked(view, mistake));
      view.dispatch(setDiagnostics(view.state, found));
    },
    goTo: (line, column) => {
      const anchor = placeOf(view.state.doc, line, column);
      view.dispatch({ selection: { anchor }, effects: EditorView.scrollIntoView(anchor, { y: "center" }) });
      view.focus();
    },
    focus: () => view.focus(),
    close: () => view.destroy(),
  };
}

/** A mistake at its word; none where its place is not known. */
function marked({ state }: EditorView, { line, column, message }: Mistake): Diagnostic[] {
  if (line === 0) return [];
  const from = placeOf(state.doc, line, column);
  const to = state.wordAt(from)?.to ?? Math.min(from + 1, state.doc.lineAt(from).to);
  return [{ from, to: Math.max(to, from), severity: "error", message }];
}
