// The ways between the states of a machine.
import { svg } from "../../dom";
import { LABEL_CHAR_PX, LABEL_HEIGHT_PX, type LaidEdge, type Point } from "./machine-layout";

let drawings = 0;

/** The head of all arrows of one drawing, and its name. */
export function drawHead(): { defs: SVGDefsElement; head: string } {
  const head = `head-${++drawings}`;
  const size = { viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 8, markerHeight: 8, markerUnits: "userSpaceOnUse" };
  const arrow = svg("path", { d: "M0,0.6L8,4L0,7.4z", class: "arrow" });
  const marker = svg("marker", { id: head, ...size, orient: "auto-start-reverse" }, arrow);
  return { defs: svg("defs", {}, marker), head };
}

export function drawEdge(edge: LaidEdge, head: string): SVGGElement {
  const path = svg("path", { d: curve(edge.points), "marker-end": `url(#${head})`, fill: "none" });
  return svg("g", { class: "edge" }, svg("title", {}, edge.about), path);
}

/** The label of an edge, on a ground that hides the edges that cross it; null for an edge without one. */
export function drawLabel({ at, text, about }: LaidEdge): SVGGElement | null {
  if (at === null) return null;
  const width = LABEL_CHAR_PX * text.length + 2;
  const [x, y] = [at.x - width / 2, at.y - LABEL_HEIGHT_PX / 2];
  const ground = svg("rect", { x, y, width, height: LABEL_HEIGHT_PX, class: "ground" });
  const words = svg("text", { x: at.x, y: at.y + 3, class: "edge-label" }, text);
  return svg("g", { class: "edge" }, svg("title", {}, about), ground, words);
}

/** A smooth line through the corners that the layout gave. */
function curve(points: Point[]): string {
  const [first, ...rest] = points;
  if (first === undefined) return "";
  let path = `M${first.x},${first.y}`;
  for (let i = 0; i < rest.length - 1; i++) {
    const corner = rest[i];
    const next = rest[i + 1];
    if (corner === undefined || next === undefined) break;
    const last = i === rest.length - 2;
    const x = last ? next.x : (corner.x + next.x) / 2;
    const y = last ? next.y : (corner.y + next.y) / 2;
    path += `Q${corner.x},${corner.y} ${x},${y}`;
  }
  if (rest.length === 1) path += `L${rest[0]?.x},${rest[0]?.y}`;
  return path;
}
