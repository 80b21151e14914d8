// The keys in the URL's hash (`#cam=...&tab=...`): what a bug report needs to
// show the same picture again.

function keys(): URLSearchParams {
  return new URLSearchParams(location.hash.slice(1));
}

/** The value of `key`, or null. */
export function getHash(key: string): string | null {
  return keys().get(key);
}

/** Sets or (null) removes `key`, and leaves the others and the history alone. */
export function setHash(key: string, value: string | null): void {
  const all = keys();
  if (all.get(key) === value) return;
  if (value === null) all.delete(key);
  else all.set(key, value);
  const text = all.toString();
  history.replaceState(null, "", text === "" ? location.pathname + location.search : `#${text}`);
}
