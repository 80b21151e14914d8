// The sheet in which the policy's file is edited, checked and applied.
import { button } from "../../button";
import type { PanelContext } from "../../context";
import { el, plainButton, setText, spacer } from "../../dom";
import { type Mistake, type PolicyFile, sendPolicy, type Verdict } from "./api";
import type { Editor } from "./editor";

/** A text that did not change for this time is checked. */
const REST_MS = 500;

/** The editor's own code comes when it is needed first. */
export async function openPolicy(context: PanelContext, file: PolicyFile): Promise<void> {
  const { makeEditor } = await import("./editor");
  new Sheet(context, file, makeEditor).open();
}

class Sheet {
  private readonly editor: Editor;
  private readonly state = el("p", { class: "policy-state", role: "status" });
  private readonly mistakes = el("ul", { class: "policy-mistakes", "aria-label": "Mistakes" });
  private readonly ask = el("div", { class: "policy-ask row", hidden: true });
  private readonly dialog: HTMLDialogElement;
  private applied: string;
  private timer = 0;
  /** Number of the newest check: answers to earlier ones are late. */
  private newest = 0;

  constructor(
    private readonly context: PanelContext,
    private readonly file: PolicyFile,
    makeEditor: typeof import("./editor").makeEditor,
  ) {
    this.applied = file.text;
    const { text, language, schema } = file;
    this.editor = makeEditor({ text, language, schema, readOnly: this.why() !== null, onChange: () => this.changed() });
    const name = file.name ?? "policy";
    const close = plainButton({}, () => this.leave(), "Close");
    this.dialog = el(
      "dialog",
      { class: "policy-sheet", "aria-label": `Edit ${name}` },
      el("header", {}, el("h2", {}, name), close),
      el("div", { class: "policy-text" }, this.editor.root),
      this.state,
      this.mistakes,
      this.ask,
      el("footer", { class: "row" }, el("span", { class: "dim" }, this.fate()), spacer(), ...this.buttons()),
    );
    this.fillAsk();
    // A browser lets the second Escape in a row close a dialog unasked.
    this.dialog.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || event.defaultPrevented) return;
      event.preventDefault();
      if (this.ask.hidden) this.leave();
      else this.stay();
    });
    this.dialog.addEventListener("close", () => this.closed());
  }

  open(): void {
    document.body.append(this.dialog);
    addEventListener("beforeunload", this.warn);
    this.dialog.showModal();
    this.editor.focus();
    void this.check();
  }

  /** Why the text cannot be changed, or null. */
  private why(): string | null {
    return this.context.cellRefusal();
  }

  private fate(): string {
    const { writable, name } = this.file;
    if (!writable) return "Applied texts are not saved: run with --data DIR";
    return `Applied texts are saved to ${name ?? "the file"}`;
  }

  private isDirty(): boolean {
    return this.editor.text() !== this.applied;
  }

  private changed(): void {
    this.newest++;
    this.ask.hidden = true;
    setText(this.state, "");
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.check(), REST_MS);
  }

  private async check(): Promise<Verdict | null> {
    // A viewer reads it.
    if (this.why() !== null) return null;
    clearTimeout(this.timer);
    const number = ++this.newest;
    const verdict = await sendPolicy(this.editor.text(), false);
    if (number !== this.newest) return null;
    this.show(verdict, "No errors");
    return verdict;
  }

  private async apply(): Promise<void> {
    clearTimeout(this.timer);
    const number = ++this.newest;
    const text = this.editor.text();
    const verdict = await sendPolicy(text, true);
    if (verdict.ok) this.applied = text;
    if (number !== this.newest) return;
    const saved = this.file.writable ? ` and saved to ${this.file.name ?? "the file"}` : ", not saved";
    this.show(verdict, `Applied${saved}: the task restarts`);
    if (verdict.ok) this.context.notify("the task restarts with the edited policy");
  }

  private show(verdict: Verdict, good: string): void {
    const errors = verdict.ok ? [] : verdict.errors;
    this.editor.blame(errors);
    this.mistakes.replaceChildren(...errors.map((mistake) => this.listed(mistake)));
    this.state.dataset.tone = verdict.ok ? "ok" : "bad";
    const count = errors.length === 1 ? "1 error" : `${errors.length} errors`;
    setText(this.state, verdict.ok ? good : count);
  }

  private listed({ line, column, message }: Mistake): HTMLElement {
    if (line === 0) return el("li", {}, message);
    const at = el("b", { class: "num" }, `${line}:${column}`);
    return el(
      "li",
      {},
      plainButton({ class: false }, () => this.editor.goTo(line, column), at, ` ${message}`),
    );
  }

  private buttons(): HTMLElement[] {
    const check = button(this.context, {
      label: "Check",
      about: () => "Check the text as a task would read it",
      twin: () => null,
      why: () => this.why(),
      run: () => this.check(),
    });
    const apply = button(this.context, {
      label: "Apply",
      about: () => "Restart the task with this text",
      twin: () => null,
      primary: () => this.why() === null && this.isDirty(),
      why: () => this.why() ?? (this.mistakes.childElementCount > 0 ? "the text has errors" : null),
      run: () => this.apply(),
    });
    return [check, apply];
  }

  /** What would be lost is asked about. */
  private fillAsk(): void {
    const stay = plainButton({ class: "button small" }, () => this.stay(), "Keep editing");
    const discard = plainButton({ class: "button small warn" }, () => this.dialog.close(), "Discard");
    this.ask.append(el("span", {}, "The changes are not applied."), spacer(), stay, discard);
  }

  private stay(): void {
    this.ask.hidden = true;
    this.editor.focus();
  }

  private leave(): void {
    if (!this.isDirty()) return this.dialog.close();
    this.ask.hidden = false;
    this.ask.querySelector("button")?.focus();
  }

  private closed(): void {
    clearTimeout(this.timer);
    this.newest++;
    removeEventListener("beforeunload", this.warn);
    this.editor.close();
    this.dialog.remove();
  }

  private readonly warn = (event: BeforeUnloadEvent): void => {
    if (this.isDirty()) event.preventDefault();
  };
}
