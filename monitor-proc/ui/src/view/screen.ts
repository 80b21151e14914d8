// The renderer and its canvas: size, quality, and drawing when there is need.
import {
  type Camera,
  HalfFloatType,
  NeutralToneMapping,
  PCFShadowMap,
  type Scene,
  WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { OutputPass } from "three/addons/postprocessing/OutputPass.js";
import type { Level } from "./quality";

const SAMPLES = 4;

export class Screen {
  readonly renderer: WebGLRenderer;
  private readonly output = new OutputPass();
  private smooth: WebGLRenderTarget | null = null;
  private level: Level | null = null;
  private shadowsAt = -Infinity;
  /** Width and height of the element (CSS pixels); to ask the element in each picture costs a layout of the page. */
  size: [number, number] = [1, 1];

  constructor(private readonly element: HTMLElement) {
    this.renderer = new WebGLRenderer({ antialias: false, powerPreference: "high-performance" });
    this.renderer.toneMapping = NeutralToneMapping;
    this.renderer.toneMappingExposure = 1;
    this.renderer.shadowMap.type = PCFShadowMap;
    // Shadows change when something moves, not when the camera turns.
    this.renderer.shadowMap.autoUpdate = false;
    this.renderer.domElement.className = "stage";
    element.append(this.renderer.domElement);
  }

  get canvas(): HTMLCanvasElement {
    return this.renderer.domElement;
  }

  /** Whether a program draws, and not a graphics card. */
  get isSoftware(): boolean {
    const gl = this.renderer.getContext();
    const info = gl.getExtension("WEBGL_debug_renderer_info");
    const name: unknown = info === null ? "" : gl.getParameter(info.UNMASKED_RENDERER_WEBGL);
    return /swiftshader|llvmpipe|softpipe|software/i.test(String(name));
  }

  use(level: Level): void {
    this.level = level;
    const { shadowMap } = this.renderer;
    shadowMap.enabled = level.shadows !== null;
    this.shadowsAt = -Infinity;
    this.resize();
  }

  resize(): void {
    this.size = [Math.max(1, this.element.clientWidth), Math.max(1, this.element.clientHeight)];
    const ratio = Math.min(window.devicePixelRatio, this.level?.densest ?? 1) * (this.level?.pixels ?? 1);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(...this.size, true);
    this.smooth?.dispose();
    this.smooth = null;
    if (this.level?.multisample !== true) return;
    const { width, height } = this.canvas;
    this.smooth = new WebGLRenderTarget(width, height, { samples: SAMPLES, type: HalfFloatType });
    this.output.setSize(width, height);
  }

  draw(scene: Scene, camera: Camera, moved: boolean): void {
    const now = performance.now();
    if (moved && now - this.shadowsAt >= (this.level?.shadows?.everyMs ?? 0)) {
      this.renderer.shadowMap.needsUpdate = true;
      this.shadowsAt = now;
    }
    this.renderer.setRenderTarget(this.smooth);
    this.renderer.render(scene, camera);
    if (this.smooth === null) return;
    this.renderer.setRenderTarget(null);
    this.output.renderToScreen = true;
    // The first target is what a chain of passes would write to; the last one writes none.
    this.output.render(this.renderer, this.smooth, this.smooth, 0, false);
  }
}
