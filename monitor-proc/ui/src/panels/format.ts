// Numbers as people read them.

/** A time in microseconds, with the unit that suits it. */
export function micros(us: number): string {
  if (!Number.isFinite(us)) return "–";
  if (us > 0 && us < 0.1) return "<0.1 µs";
  if (us < 1) return `${us.toFixed(1)} µs`;
  if (us < 1000) return `${us.toFixed(0)} µs`;
  if (us < 10_000) return `${(us / 1000).toFixed(2)} ms`;
  if (us < 1_000_000) return `${(us / 1000).toFixed(0)} ms`;
  return `${(us / 1_000_000).toFixed(2)} s`;
}

export function bytes(count: number): string {
  if (count < 1e6) return `${(count / 1e3).toFixed(0)} kB`;
  if (count < 1e9) return `${(count / 1e6).toFixed(0)} MB`;
  return `${(count / 1e9).toFixed(2)} GB`;
}

export function seconds(s: number, digits = 2): string {
  return Number.isFinite(s) ? `${s.toFixed(digits)} s` : "–";
}

/** Tenths of a second, rounded down: a clock beside it with more digits starts with the same ones. */
export function tenths(s: number): string {
  return `${(Math.floor(10 * s + 1e-6) / 10).toFixed(1)} s`;
}

export function millimetres(metres: number, digits = 1): string {
  return Number.isFinite(metres) ? `${(metres * 1000).toFixed(digits)} mm` : "–";
}

/** A name of code, `like_this`, as words. */
export function words(name: string): string {
  return name.replaceAll("_", " ");
}

/** `text` with a capital letter. */
export function sentence(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** A colour of the scene, its parts from 0 to 1. */
export function css([r, g, b]: [number, number, number]): string {
  const part = (share: number) => Math.round(255 * Math.min(Math.max(share, 0), 1));
  return `rgb(${part(r)} ${part(g)} ${part(b)})`;
}
