// The websocket: answers by number, and a new try when it is lost.
import { Earlier } from "./earlier";
import type { Ack, Command, TextMessage } from "./protocol";
import type { Store } from "./store";

const FIRST_RETRY_MS = 250;
const LAST_RETRY_MS = 4000;
/** A cell that does not answer for so long has ended: it is asked rarely, as the browser reports each failure. */
const ENDED_MS = 60_000;
const RARE_RETRY_MS = 30_000;
const PATIENCE_MS = 5000;
const UNAUTHORIZED = 401;

/** Ends after `ms`, or when a person looks at the page. */
function waited(ms: number): Promise<void> {
  return new Promise((done) => {
    const timer = setTimeout(end, ms);
    addEventListener("focus", end);
    function end() {
      clearTimeout(timer);
      removeEventListener("focus", end);
      done();
    }
  });
}

/** Connects `store` to the monitor, and keeps it connected. */
export function connect(store: Store, url: string): void {
  let retry = FIRST_RETRY_MS;
  let socket: WebSocket | null = null;
  let last = 0;
  const waiting = new Map<number, (ack: Ack) => void>();

  const settle = (ack: Ack) => {
    waiting.get(ack.id)?.(ack);
    waiting.delete(ack.id);
  };
  const refused = (id: number, message: string): Ack => ({ id, ok: false, tick: null, message });

  const earlier = new Earlier(store, () => socket?.close());
  store.send = (command: Command) => {
    const own = earlier.answer(command);
    if (own !== null) return Promise.resolve(own);
    const id = ++last;
    if (socket?.readyState !== WebSocket.OPEN) {
      return Promise.resolve(refused(id, "not connected to the monitor"));
    }
    socket.send(JSON.stringify({ id, ...command }));
    return new Promise((resolve) => {
      waiting.set(id, resolve);
      setTimeout(() => settle(refused(id, "no answer")), PATIENCE_MS);
    });
  };

  /** A websocket does not say why it was refused: a page of another run would ask for ever. */
  const again = async () => {
    let answer: Response | null = null;
    const since = performance.now();
    while (answer === null) {
      await waited(performance.now() - since < ENDED_MS ? retry : RARE_RETRY_MS);
      retry = Math.min(2 * retry, LAST_RETRY_MS);
      answer = await fetch("/", { method: "HEAD", cache: "no-store" }).catch(() => null);
    }
    store.refused = answer.status === UNAUTHORIZED;
    if (!store.refused) open();
  };

  const open = () => {
    const next = new WebSocket(url);
    next.binaryType = "arraybuffer";
    /** A socket that is open has not answered yet: what the page shows is still what was told before. */
    let isHeard = false;
    const hear = () => {
      if (isHeard) return;
      isHeard = true;
      retry = FIRST_RETRY_MS;
      store.connected = true;
      [store.refused, store.ended] = [false, false];
      store.emit("connection", true);
    };
    next.onmessage = ({ data }: MessageEvent<ArrayBuffer | string>) => {
      hear();
      if (data instanceof ArrayBuffer) {
        if (!earlier.hides(data)) store.takeFrame(data);
        return;
      }
      const message = JSON.parse(data) as TextMessage;
      if (message.t === "ack") settle(message);
      if (!earlier.hides(message)) store.takeText(message);
    };
    next.onclose = () => {
      for (const id of [...waiting.keys()]) settle(refused(id, "the connection was lost"));
      const was = store.connected;
      store.connected = false;
      if (was) store.emit("connection", false);
      void again();
    };
    socket = next;
  };
  open();
}
