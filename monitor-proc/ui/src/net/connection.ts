// The websocket: answers by number, and a new try when it is lost.
import type { Ack, Command, TextMessage } from "./protocol";
import type { Store } from "./store";

const FIRST_RETRY_MS = 250;
const LAST_RETRY_MS = 4000;
const PATIENCE_MS = 5000;
const UNAUTHORIZED = 401;

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

  store.send = (command: Command) => {
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
    while (answer === null) {
      await new Promise((waited) => setTimeout(waited, retry));
      retry = Math.min(2 * retry, LAST_RETRY_MS);
      answer = await fetch("/", { method: "HEAD", cache: "no-store" }).catch(() => null);
    }
    store.refused = answer.status === UNAUTHORIZED;
    if (!store.refused) open();
  };

  const open = () => {
    const next = new WebSocket(url);
    next.binaryType = "arraybuffer";
    next.onopen = () => {
      retry = FIRST_RETRY_MS;
      store.connected = true;
      [store.refused, store.ended] = [false, false];
      store.emit("connection", true);
    };
    next.onmessage = ({ data }: MessageEvent<ArrayBuffer | string>) => {
      if (data instanceof ArrayBuffer) {
        store.takeFrame(data);
        return;
      }
      const message = JSON.parse(data) as TextMessage;
      if (message.t === "ack") settle(message);
      store.takeText(message);
    };
    next.onclose = () => {
      for (const id of [...waiting.keys()]) settle(refused(id, "the connection was lost"));
      if (store.connected) store.emit("connection", false);
      store.connected = false;
      void again();
    };
    socket = next;
  };
  open();
}
