// The named overlays, on or off; the URL's hash keeps what differs from the
// beginning, so that a link shows the same picture.
import { getHash, setHash } from "../panels/hash";

/** Overlays in the order to show them, with what they are at first. */
const OVERLAYS: Record<string, boolean> = {
  targets: true,
  approach: false,
  spheres: false,
  distances: false,
  contacts: true,
  contact_forces: false,
  suction: true,
  trails: false,
  ghost: false,
  names: false,
};

type Listener = (name: string, on: boolean) => void;

export class Toggles {
  private readonly on = new Map<string, boolean>();
  private readonly listeners = new Set<Listener>();

  constructor() {
    const shown = getHash("show")?.split(".");
    for (const [name, first] of Object.entries(OVERLAYS)) {
      this.on.set(name, shown?.includes(name) ?? first);
    }
  }

  names(): string[] {
    return [...this.on.keys()];
  }

  get(name: string): boolean {
    return this.on.get(name) ?? false;
  }

  set(name: string, on: boolean): void {
    if (!this.on.has(name) || this.get(name) === on) return;
    this.on.set(name, on);
    const all = this.names();
    const usual = all.every((one) => this.get(one) === OVERLAYS[one]);
    setHash("show", usual ? null : all.filter((one) => this.get(one)).join("."));
    for (const listener of this.listeners) listener(name, on);
  }

  /** Calls `listener` on every change, until the returned function is called. */
  onChange(listener: Listener): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}
