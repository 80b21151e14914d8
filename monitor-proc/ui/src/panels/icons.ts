// Small pictures on buttons, 16 x 16.
import { svg } from "./dom";

const PATHS = {
  play: "M4 2.5v11l9-5.5z",
  pause: "M3.5 2.5h3v11h-3zM9.5 2.5h3v11h-3z",
  stop: "M3 3h10v10H3z",
  step: "M3 2.5v11l6-5.5zM10.5 2.5h2.5v11h-2.5z",
  reset:
    "M8 2.2a5.8 5.8 0 1 0 5.6 7.3l-1.9-.5A3.8 3.8 0 1 1 8 4.2c1 0 1.9.4 2.6 1L8.7 7.1h5V2.2l-1.7 1.7A5.8 5.8 0 0 0 8 2.2z",
  dot: "M8 3a5 5 0 1 0 0 10A5 5 0 0 0 8 3z",
  down: "M3.5 6h9L8 11z",
  grow: "M2 2h5v2H4v3H2zM9 12h3V9h2v5H9zM9 2h5v5h-2V4H9zM2 9h2v3h3v2H2z",
  close: "M3.4 2 8 6.6 12.6 2 14 3.4 9.4 8l4.6 4.6-1.4 1.4L8 9.4 3.4 14 2 12.6 6.6 8 2 3.4z",
  link: "M6.5 9.5a2.5 2.5 0 0 1 0-3.5l2-2a2.5 2.5 0 0 1 3.5 3.5l-1 1-1-1 1-1a1.1 1.1 0 0 0-1.5-1.5l-2 2A1.1 1.1 0 0 0 7.5 8.5zM9.5 6.5a2.5 2.5 0 0 1 0 3.5l-2 2A2.5 2.5 0 0 1 4 8.5l1-1 1 1-1 1A1.1 1.1 0 0 0 6.5 11l2-2a1.1 1.1 0 0 0 0-1.500z",
  side: "M2 3h12v10H2zM4 5v6h3V5z",
} as const;

export type IconName = keyof typeof PATHS;

export function icon(name: IconName): SVGSVGElement {
  const path = svg("path", { d: PATHS[name], "fill-rule": "evenodd" });
  const attrs = { viewBox: "0 0 16 16", width: 14, height: 14, "aria-hidden": "true", class: "icon" };
  return svg("svg", { ...attrs, "data-icon": name }, path);
}
