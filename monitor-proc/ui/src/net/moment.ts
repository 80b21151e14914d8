// The moment of the past that is looked at, in the URL (`#t=SECONDS`, and `@EPOCH`
// where it is not of the newest): a link leads there, and a reload keeps it.
import { getHash, setHash } from "../panels/hash";
import type { Store } from "./store";

const KEY = "t";

interface Moment {
  time_s: number;
  epoch?: number;
}

/** The moment that the URL names, or null. */
export function momentOfUrl(): Moment | null {
  const [time, epoch] = (getHash(KEY) ?? "").split("@").map((text) => (text === "" ? NaN : Number(text)));
  if (time === undefined || !Number.isFinite(time) || time < 0) return null;
  return epoch === undefined || !Number.isInteger(epoch) ? { time_s: time } : { time_s: time, epoch };
}

/** Keeps the URL and the moment on the page equal, over reloads and restarts of the monitor. */
export function followMoment(store: Store): void {
  let run: string | null = null;
  store.on("hello", (hello) => {
    // Another run has another past.
    if (run !== null && run !== hello.run.id) setHash(KEY, null);
    run = hello.run.id;
  });
  store.on("scene", () => {
    const wanted = momentOfUrl();
    if (wanted === null) return;
    void store.send({ do: "seek", ...wanted }).then(({ ok, message }) => {
      if (ok) return;
      setHash(KEY, null);
      store.emit("notice", { text: message, bad: true });
    });
  });
  store.on("moment", (past) => {
    const epoch = past?.epoch == null ? "" : `@${past.epoch}`;
    setHash(KEY, past === null ? null : `${past.time_s.toFixed(3)}${epoch}`);
  });
}
