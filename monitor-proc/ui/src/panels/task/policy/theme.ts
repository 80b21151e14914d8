// The colours of the page for the editor.
import { EditorView } from "@codemirror/view";

export const theme = EditorView.theme(
  {
    "&": { height: "100%", backgroundColor: "var(--bg)", color: "var(--text)", fontSize: "12.5px" },
    "&.cm-focused": { outline: "2px solid var(--blue)", outlineOffset: "-2px" },
    ".cm-scroller": { fontFamily: "var(--mono)", lineHeight: "1.45" },
    ".cm-content": { caretColor: "#fff" },
    ".cm-cursor": { borderLeftColor: "#fff" },
    ".cm-gutters": { backgroundColor: "var(--panel)", color: "var(--dim)", border: "0" },
    ".cm-activeLine": { backgroundColor: "#ffffff08" },
    "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": {
      backgroundColor: "#264a72",
    },
    ".cm-selectionMatch": { backgroundColor: "#4d4420" },
    ".cm-panels": { backgroundColor: "var(--panel)", color: "var(--text)" },
    ".cm-panels.cm-panels-top": { borderBottom: "1px solid var(--line)" },
    ".cm-searchMatch": { backgroundColor: "#6b5312" },
    ".cm-searchMatch-selected": { backgroundColor: "#8d6f1b" },
    ".cm-button": {
      backgroundImage: "none",
      backgroundColor: "var(--raised)",
      border: "1px solid var(--line)",
      color: "var(--text)",
    },
    ".cm-textfield": { backgroundColor: "var(--bg)", border: "1px solid var(--line)", color: "var(--text)" },
    ".cm-tooltip": { backgroundColor: "var(--raised)", border: "1px solid var(--strong-line)", color: "var(--text)" },
    ".cm-tooltip-autocomplete > ul > li[aria-selected]": { backgroundColor: "#264a72", color: "#fff" },
    ".cm-completionInfo": { maxWidth: "320px" },
    ".cm-diagnostic": { borderLeft: "3px solid var(--red)" },
  },
  { dark: true },
);
