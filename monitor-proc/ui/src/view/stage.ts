// The room around the cell: light, floor, background.
import {
  BackSide,
  CanvasTexture,
  CircleGeometry,
  Color,
  DirectionalLight,
  Fog,
  GridHelper,
  Group,
  HemisphereLight,
  Mesh,
  MeshBasicMaterial,
  PMREMGenerator,
  PlaneGeometry,
  Scene,
  ShaderMaterial,
  SphereGeometry,
  type Vector3,
  type WebGLRenderer,
} from "three";
import { material } from "./materials";

const HORIZON = new Color(0x8493a5);
const ZENITH = new Color(0x2c3744);
const FLOOR = 0x6d7a89;
const GRID = 0x5d6977;
const SHADOW_REACH_M = 1.35;

/** A dome that is bright at the horizon and dark above. */
function dome(): Mesh {
  const paint = new ShaderMaterial({
    side: BackSide,
    depthWrite: false,
    fog: false,
    uniforms: { low: { value: HORIZON }, high: { value: ZENITH } },
    vertexShader: `
      varying float height;
      void main() {
        height = normalize(position).z;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: `
      uniform vec3 low;
      uniform vec3 high;
      varying float height;
      void main() {
        gl_FragColor = vec4(mix(low, high, smoothstep(-0.02, 0.55, height)), 1.0);
        #include <tonemapping_fragment>
        #include <colorspace_fragment>
      }`,
  });
  const mesh = new Mesh(new SphereGeometry(40, 24, 16), paint);
  mesh.renderOrder = -1;
  mesh.raycast = () => {};
  return mesh;
}

/** What shiny surfaces mirror: a pale room with two soft boxes of light. */
function reflections(renderer: WebGLRenderer) {
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
  const { texture } = generator.fromScene(room, 0.03);
  generator.dispose();
  return texture;
}

function sun(): DirectionalLight {
  const light = new DirectionalLight(0xfff6ea, 2.1);
  light.castShadow = true;
  light.shadow.mapSize.set(2048, 2048);
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
    gradient.addColorStop(0, "rgba(12,16,22,0.5)");
    gradient.addColorStop(1, "rgba(12,16,22,0)");
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

export class Stage {
  readonly scene = new Scene();
  readonly light = sun();
  private readonly floor = new Group();
  private readonly shade = contactShade();
  private readonly sky = new HemisphereLight(0xe6eefa, 0x59626c, 0.75);

  constructor(private readonly renderer: WebGLRenderer) {
    this.scene.background = HORIZON;
    this.scene.fog = new Fog(HORIZON, 4.5, 13);
    const fill = new DirectionalLight(0xd7e6ff, 0.45);
    fill.position.set(-2, -3, 1.5);
    this.scene.add(this.sky, fill, this.light, this.light.target, dome(), this.floor);
    const ground = new Mesh(new CircleGeometry(14, 48), material({ colour: FLOOR, roughness: 0.95 }));
    ground.receiveShadow = true;
    const grid = new GridHelper(24, 48, GRID, GRID);
    grid.rotateX(Math.PI / 2);
    grid.position.z = 0.001;
    this.shade.position.z = 0.002;
    this.floor.add(ground, grid, this.shade);
    this.floor.traverse((object) => {
      object.raycast = () => {};
    });
  }

  /** Lays the floor at `height` and lights the cell around `centre` (m). */
  arrange(height: number, centre: Vector3, reach: number): void {
    this.floor.position.z = height;
    this.shade.scale.setScalar(2 * reach + 1.6);
    this.shade.position.set(centre.x, centre.y, 0.002);
    const wide = Math.max(SHADOW_REACH_M, reach + 0.3);
    this.light.position.copy(centre).add({ x: 0.9 * wide, y: -1.1 * wide, z: 2.6 * wide });
    this.light.target.position.copy(centre);
    const frame = this.light.shadow.camera;
    frame.left = frame.bottom = -wide;
    frame.right = frame.top = wide;
    frame.near = 0.2;
    frame.far = 6 * wide;
    frame.updateProjectionMatrix();
  }

  /** Mirrors a room in shiny surfaces; without it a brighter sky stands in. */
  useReflections(on: boolean): void {
    if (on && this.scene.environment === null) {
      this.scene.environment = reflections(this.renderer);
      this.scene.environmentIntensity = 0.55;
    } else if (!on && this.scene.environment !== null) {
      this.scene.environment.dispose();
      this.scene.environment = null;
    }
    this.sky.intensity = on ? 0.75 : 1.7;
  }
}
