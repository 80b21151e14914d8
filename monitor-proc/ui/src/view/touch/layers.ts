// Layers of three.js: bodies that are drawn as part of a crowd are met by the pointer, and not drawn themselves.
import { Raycaster } from "three";

export const POINTED_LAYER = 1;

/** A ray that meets all bodies. */
export function bodyCaster(): Raycaster {
  const caster = new Raycaster();
  caster.layers.enable(POINTED_LAYER);
  return caster;
}
