// Scrolling by a person, apart from scrolling by the page itself.

/** Tells when a person last scrolled `box`, on the clock of `performance`. */
export function lastScroll(box: HTMLElement): () => number {
  let at_ms = -Infinity;
  const touch = (event: Event) => {
    if (!(event instanceof PointerEvent) || event.buttons > 0) at_ms = performance.now();
  };
  for (const kind of ["wheel", "pointerdown", "pointermove", "touchmove", "keydown"])
    box.addEventListener(kind, touch, { passive: true });
  return () => at_ms;
}
