// The room around the cell: light, floor, background.
import {
  BackSide,
  CanvasTexture,
  Color,
  DirectionalLight,
  Fog,
  GridHelper,
  Group,
  HemisphereLight,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  PMREMGenerator,
  RingGeometry,
  Scene,
  ShaderMaterial,
  SphereGeometry,
  type Texture,
  type Vector3,
  type WebGLRenderer,
} from "three";
import { material } from "./materials";
import type { Level } from "./quality";

const HORIZON = new Color(0x737f8c);
const ZENITH = new Color(0x272e37);
const FLOOR = 0x626b75;
const LINES = 0x76818c;
const FLOOR_M = 14;
const FLOOR_RINGS = 14;
/** As much as the floor of the fine kind mirrors of the sun. */
const SHEEN = 0.037;
/** Opacity of lines that are not smooth: as bright on the whole as smooth ones. */
const ROUGH_LINES = 0.4;
const FINE_SKY = 0.6;
const PLAIN_SKY = 1.95;
const REFLECTIONS = 0.5;
const SHADOW_REACH_M = 1.35;
/** Cells up to this reach are seen without haze (m). */
const HAZE_REACH_M = 1.1;
const SUN: [number, number] = [0.9, -1.1];
const SHOULDER_RAD = 0.8;
const FILL = 0.45;
const SIDE_FILL = 1.1;

/** A dome that is bright at the horizon and dark above; its colours are computed per vertex. */
function dome(): Mesh<SphereGeometry, ShaderMaterial> {
  const paint = new ShaderMaterial({
    side: BackSide,
    depthWrite: false,
    fog: false,
    toneMapped: false,
    uniforms: { low: { value: HORIZON }, high: { value: ZENITH }, linear: { value: false } },
    vertexShader: `
      #include <tonemapping_pars_fragment>
      #include <colorspace_pars_fragment>
      uniform vec3 low;
      uniform vec3 high;
      // Tone and colour space are those of a later pass.
      uniform bool linear;
      varying vec3 seen;
      void main() {
        float height = normalize(position).z;
        vec3 light = mix(low, high, smoothstep(-0.02, 0.55, height));
        seen = linear ? light : sRGBTransferOETF(vec4(NeutralToneMapping(light), 1.0)).rgb;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: `
      varying vec3 seen;
      void main() {
        gl_FragColor = vec4(seen, 1.0);
      }`,
  });
  const mesh = new Mesh(new SphereGeometry(40, 24, 64).rotateX(Math.PI / 2), paint);
  // What the cell covers of it costs nothing when it is drawn last.
  mesh.renderOrder = 0.9;
  mesh.raycast = () => {};
  return mesh;
}

/** A dark colour as the tone mapping `NeutralToneMapping` of three.js shows it. */
function neutral(colour: Color): Color {
  const least = Math.min(colour.r, colour.g, colour.b);
  const offset = least < 0.08 ? least - 6.25 * least * least : 0.04;
  return new Color(colour.r - offset, colour.g - offset, colour.b - offset);
}

/** Fine lines, half a metre apart. */
function grid(): GridHelper {
  const lines = new GridHelper(24, 48, LINES, LINES);
  lines.material.transparent = true;
  lines.rotateX(Math.PI / 2);
  lines.position.z = 0.001;
  // Drawn first and covered by the rest: some drivers are careless with the depth of lines.
  lines.renderOrder = -0.9;
  return lines;
}

/** What shiny surfaces mirror: a pale room with two soft boxes of light. */
function reflections(renderer: WebGLRenderer, size: number) {
  const room = new Scene();
  room.background = new Color(0x59646f);
  const panel = (width: number, height: number, x: number, y: number, z: number, glow: number) => {
    const paint = new MeshBasicMaterial({ color: new Color(glow, glow, glow) });
    const mesh = new Mesh(new PlaneGeometry(width, height), paint);
    mesh.position.set(x, y, z);
    mesh.lookAt(0, 0, 0);
    room.add(mesh);
  };
  panel(6, 4, 2, 1, 5, 3.2);
  panel(3, 5, -5, -3, 2, 1.6);
  panel(3, 4, 1, 6, 1.5, 1.4);
  panel(14, 14, 0, 0, -5, 0.22);
  const generator = new PMREMGenerator(renderer);
  const { texture } = generator.fromScene(room, 0.03, 0.1, 100, { size });
  generator.dispose();
  return texture;
}

function sun(): DirectionalLight {
  const light = new DirectionalLight(0xffffff, 2.2);
  light.castShadow = true;
  light.shadow.bias = -0.0003;
  light.shadow.normalBias = 0.012;
  light.shadow.radius = 3;
  return light;
}

/** A dark spot that lets the furniture stand on the floor where shadows are off. */
function contactShade(): Mesh {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 128;
  const brush = canvas.getContext("2d");
  if (brush !== null) {
    const gradient = brush.createRadialGradient(64, 64, 10, 64, 64, 64);
    gradient.addColorStop(0, "rgba(20,26,34,0.05)");
    gradient.addColorStop(1, "rgba(20,26,34,0)");
    brush.fillStyle = gradient;
    brush.fillRect(0, 0, 128, 128);
  }
  const paint = new MeshBasicMaterial({
    map: new CanvasTexture(canvas),
    transparent: true,
    depthWrite: false,
  });
  return new Mesh(new PlaneGeometry(1, 1), paint);
}

/** The side of the sun: its usual one, or over the shoulder of a viewer looking into it. */
function sunSide(x: number, y: number): [number, number] {
  if (SUN[0] * x + SUN[1] * y >= 0) return SUN;
  const height = Math.hypot(...SUN) / Math.max(Math.hypot(x, y), 1e-6);
  const [cos, sin] = [Math.cos(SHOULDER_RAD), Math.sin(SHOULDER_RAD)];
  return [height * (cos * x - sin * y), height * (sin * x + cos * y)];
}

export class Stage {
  readonly scene = new Scene();
  readonly light = sun();
  private readonly fill = new DirectionalLight(0xd7e6ff, FILL);
  private readonly floor = new Group();
  private readonly shade = contactShade();
  private readonly lines = grid();
  private readonly dome = dome();
  private reflected: Texture | null = null;
  private readonly ground: Mesh;
  private readonly sky = new HemisphereLight(0xf2f6fc, 0x6a6f75, FINE_SKY);

  /** `mirrorSize` is the width of a face of what shiny surfaces mirror (pixels). */
  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly mirrorSize: number,
  ) {
    this.scene.background = HORIZON;
    this.scene.fog = new Fog(HORIZON, 3.5, 13);
    this.fill.position.set(-2, -3, 1.5);
    this.scene.add(this.sky, this.light, this.fill, this.light.target, this.dome, this.floor);
    // In rings: light of the cheap kind is computed per vertex.
    const disc = new RingGeometry(0, FLOOR_M, 48, FLOOR_RINGS);
    this.ground = new Mesh(disc, material({ colour: FLOOR, roughness: 0.95, sheen: SHEEN }));
    this.ground.receiveShadow = true;
    this.ground.renderOrder = 0.8;
    this.floor.add(this.ground, this.lines, this.shade);
    this.floor.traverse((object) => {
      object.raycast = () => {};
    });
  }

  /**
   * Lays the floor at `height` and lights the cell around `centre` (m), from the
   * side that is seen from `eye`.
   */
  arrange(height: number, centre: Vector3, reach: number, eye: Vector3): void {
    this.floor.position.z = height;
    this.shade.scale.setScalar(2 * reach + 1.6);
    this.shade.position.set(centre.x, centre.y, 0.002);
    const wide = Math.max(SHADOW_REACH_M, reach + 0.6);
    const [x, y] = sunSide(eye.x - centre.x, eye.y - centre.y);
    this.light.position.copy(centre).add({ x: x * wide, y: y * wide, z: 2.6 * wide });
    // What the eye sees of a large cell are mostly its upright sides.
    const moved = x !== SUN[0];
    this.fill.intensity = moved ? SIDE_FILL : FILL;
    if (moved) this.fill.position.set(eye.x - centre.x + y, eye.y - centre.y - x, 0.6 * wide);
    const haze = Math.max(1, reach / HAZE_REACH_M);
    if (this.scene.fog instanceof Fog) [this.scene.fog.near, this.scene.fog.far] = [3.5 * haze, 13 * haze];
    this.light.target.position.copy(centre);
    const frame = this.light.shadow.camera;
    frame.left = frame.bottom = -wide;
    frame.right = frame.top = wide;
    frame.near = 0.2;
    frame.far = 6 * wide;
    frame.updateProjectionMatrix();
  }

  /** Mirrors a room in shiny surfaces; without it the sky is brighter. */
  use({ fine, shadows, multisample, pixels }: Level): void {
    // Without antialiasing a line is a row of whole pixels, and these are larger with less resolution.
    this.lines.material.opacity = multisample ? 1 : ROUGH_LINES * Math.min(pixels, 1);
    (this.dome.material.uniforms.linear as { value: boolean }).value = multisample;
    // three.js maps the tones of fog only where a later pass does.
    if (this.scene.fog !== null) this.scene.fog.color.copy(multisample ? HORIZON : neutral(HORIZON));
    if (fine) this.reflected ??= reflections(this.renderer, this.mirrorSize);
    this.scene.environment = fine ? this.reflected : null;
    this.scene.environmentIntensity = REFLECTIONS;
    this.sky.intensity = fine ? FINE_SKY : PLAIN_SKY;
    // In place of the shadow of the furniture.
    this.shade.visible = shadows === null;
    if (shadows !== null) this.useMap(shadows.map);
    // A light that casts shadows is drawn with its last map, also where maps are not drawn.
    this.light.castShadow = shadows !== null;
  }

  private useMap(size: number): void {
    const { shadow } = this.light;
    if (shadow.mapSize.x === size) return;
    shadow.mapSize.set(size, size);
    shadow.map?.dispose();
    shadow.map = null;
  }
}
