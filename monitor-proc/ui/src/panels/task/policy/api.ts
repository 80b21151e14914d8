// The file that the policy is written in (`/api/policy` of docs/page-protocol.md).

export interface PolicyFile {
  kind: "tree" | "table" | "matrix" | null;
  name: string | null;
  text: string;
  language: "json" | "toml";
  schema: unknown;
  /** Whether a text that is applied is saved. */
  writable: boolean;
  /** Why there is no file. */
  why: string;
}

export interface Mistake {
  /** From 1 up; 0 where no place is known. */
  line: number;
  column: number;
  message: string;
}

export type Verdict = { ok: true; message: string } | { ok: false; errors: Mistake[] };

/** The policy's file, or why it cannot be had. */
export async function readPolicy(): Promise<PolicyFile | string> {
  const answer = await fetch("/api/policy").catch(() => null);
  if (answer === null) return "the monitor does not answer";
  if (answer.status === 404) return "this monitor cannot tell the policy's file";
  if (!answer.ok) return (await answer.text()).trim();
  const file = (await answer.json()) as PolicyFile;
  return file.kind === null ? file.why : file;
}

/** Checks `text`, and with `apply` restarts the task with it where it has no errors. */
export async function sendPolicy(text: string, apply: boolean): Promise<Verdict> {
  const headers = { "content-type": "application/json" };
  const body = JSON.stringify({ text, apply });
  const answer = await fetch("/api/policy", { method: "POST", headers, body }).catch(() => null);
  const nowhere = (message: string): Verdict => ({ ok: false, errors: [{ line: 0, column: 0, message }] });
  if (answer === null) return nowhere("the monitor does not answer");
  if (!answer.ok) return nowhere((await answer.text()).trim());
  const verdict = (await answer.json()) as Verdict;
  return verdict.ok ? verdict : { ok: false, errors: verdict.errors.map(placed) };
}

/** Some checks tell the place within the text, after the file: `FILE:LINE:COLUMN: WORDS`. */
function placed(mistake: Mistake): Mistake {
  const found = mistake.line === 0 ? /^\S.*?:(\d+):(\d+): (.*)$/s.exec(mistake.message) : null;
  if (found === null) return mistake;
  return { line: Number(found[1]), column: Number(found[2]), message: found[3] ?? "" };
}
