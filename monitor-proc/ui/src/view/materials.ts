// Every lit surface takes its material from here, so that the quality ladder
// can swap the physically based kind for the cheap one.
import { Color, type ColorRepresentation, type Material, Mesh, MeshStandardMaterial, type Object3D } from "three";
import { plainMaterial } from "./plain";

export interface Look {
  colour: ColorRepresentation;
  /** 0 mirror to 1 chalk. */
  roughness?: number;
  metalness?: number;
  /** Glows in its own colour. */
  glow?: number;
  /** Of the cheap kind: white light where it is seen flat. */
  sheen?: number;
}

/** The colours of the built-in robots. */
export const PAINT = {
  white: { colour: 0xe9ebee, roughness: 0.36 },
  dark: { colour: 0x292b2e, roughness: 0.55 },
  rubber: { colour: 0x1b1c1e, roughness: 0.9 },
  steel: { colour: 0xb9c0c7, roughness: 0.32, metalness: 0.55 },
  silver: { colour: 0xc6cace, roughness: 0.36, metalness: 0.25 },
  sky: { colour: 0x6fa8c9, roughness: 0.5 },
  led: { colour: 0x2f8fff, roughness: 0.4, glow: 1.6 },
} as const satisfies Record<string, Look>;

const fine = new Map<string, MeshStandardMaterial>();
const cheapOf = new Map<Material, Material>();
const fineOf = new Map<Material, Material>();
let cheap = false;

/** The shared material of `look`, of the kind in use now. */
export function material(look: Look): Material {
  const { roughness = 0.5, metalness = 0.02, glow = 0, sheen = 0 } = look;
  const colour = new Color(look.colour);
  const key = `${colour.getHexString()} ${roughness} ${metalness} ${glow} ${sheen}`;
  let made = fine.get(key);
  if (made === undefined) {
    made = new MeshStandardMaterial({ color: colour, roughness, metalness });
    const twin = plainMaterial(colour, glow, sheen);
    if (glow > 0) {
      made.emissive.copy(colour);
      made.emissiveIntensity = glow;
    }
    fine.set(key, made);
    cheapOf.set(made, twin);
    fineOf.set(twin, made);
  }
  return cheap ? (cheapOf.get(made) ?? made) : made;
}

/** Uses the cheap kind, or the fine one, for all meshes under `root`. */
export function useCheap(on: boolean, root: Object3D): void {
  cheap = on;
  const twins = on ? cheapOf : fineOf;
  root.traverse((object) => {
    if (!(object instanceof Mesh) || Array.isArray(object.material)) return;
    const twin = twins.get(object.material as Material);
    if (twin !== undefined) object.material = twin;
  });
}
