// Real meshes, where the user fetched them, in place of the built-in look.
import { Color, Mesh, MeshStandardMaterial, type Object3D } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { material } from "../materials";

const loader = new GLTFLoader();
const loaded = new Map<string, Promise<Object3D>>();

function load(url: string): Promise<Object3D> {
  let found = loaded.get(url);
  if (found === undefined) {
    found = loader.loadAsync(url).then(({ scene }) => scene);
    loaded.set(url, found);
  }
  return found;
}

/** Takes part in the quality ladder, and in the shadows. */
function adopt(object: Object3D): void {
  if (!(object instanceof Mesh)) return;
  object.castShadow = true;
  object.receiveShadow = true;
  const own: unknown = object.material;
  if (own instanceof MeshStandardMaterial) {
    const colour = new Color().copy(own.color);
    // Shipped meshes are often mirror-like: without a room around it looks black.
    object.material = material({ colour, roughness: Math.max(own.roughness, 0.4), metalness: 0.05 });
  }
}

/** A copy of the mesh of a link, or null where it cannot be had. */
export async function fetchedMesh(robot: string, link: string): Promise<Object3D | null> {
  const url = `./meshes/${encodeURIComponent(robot)}/${encodeURIComponent(link)}.glb`;
  try {
    const copy = (await load(url)).clone(true);
    copy.traverse(adopt);
    return copy;
  } catch {
    loaded.delete(url);
    return null;
  }
}
